"""Odometry that drifts, measures too far or too short, and fails for a while."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.sensors.bursts import FRAME, bursts
from mot_sim.simulation.sensors.checks import require_finite, require_rates, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals
from tracker.geometry import homogeneous, invert, rotation_y


@dataclass(frozen=True)
class Odometry:
    """scale: path over true path, less 1. drift: std of the yaw rate's error, radians a second.

    slip: std of the relative error of a step. dropouts: the rate of frames whose motion is
    unknown and taken for none. Memories: of drift and slip, and of how long it stays lost.
    """

    scale: float = 0.0
    drift: float = 0.0
    slip: float = 0.0
    dropouts: float = 0.0
    memory: Autocorrelation = field(default_factory=Autocorrelation)
    dropout_memory: Autocorrelation = field(default_factory=Autocorrelation)

    def __post_init__(self) -> None:
        require_finite("odometry scale", self.scale)
        require_sigmas("odometry drift, slip", self.drift, self.slip)
        require_rates("odometry dropouts", self.dropouts)

    def __call__(
        self, Ts_world_cam: Float[Array, "m 4 4"], seed: int, step: float, level: float = 1.0
    ) -> Float[Array, "m 4 4"]:
        """The poses as the odometry believes them, from the same first pose; level 0: exact."""
        if level == 0.0 or self == Odometry() or len(Ts_world_cam) < 2:
            return Ts_world_cam
        frames = np.arange(1, len(Ts_world_cam))
        owner = np.full_like(frames, FRAME)
        x = correlated_normals(seed, "odometry", owner, frames, self.memory, step, 2)
        rates = np.full(len(frames), min(level * self.dropouts, 1.0))
        lost = bursts(rates, seed, "odometry/lost", owner, frames, self.dropout_memory, step)
        Ts_before_now = invert(Ts_world_cam[:-1]) @ Ts_world_cam[1:]
        Ts_before_now[:, :3, 3] *= (1.0 + level * (self.scale + self.slip * x[:, 1]))[:, None]
        poses = [Ts_world_cam[0]]
        for T_before_now, turn, unknown in zip(
            Ts_before_now, level * self.drift * step * x[:, 0], lost, strict=True
        ):
            moved = homogeneous(rotation_y(float(turn)), np.zeros(3)) @ T_before_now
            poses.append(poses[-1] if unknown else poses[-1] @ moved)
        return np.array(poses)

    def motion_cov(self, Ts_world_cam: Float[Array, "m 4 4"], step: float) -> Array | None:
        """How far off it says that its motions are, over one step: a 6x6 covariance, see `Frame`.

        Honest of drift, slip and scale (by the root mean square of the way of a step); of
        dropouts it knows nothing. None where nothing is wrong.
        """
        if max(self.drift, self.slip, abs(self.scale)) == 0.0 or len(Ts_world_cam) < 2:
            return None
        ways = np.diff(Ts_world_cam[:, :3, 3], axis=0)
        along = np.hypot(self.scale, self.slip) * float(np.sqrt((ways**2).sum(axis=1).mean()))
        return np.diag(np.square([0.0, 0.0, along, 0.0, self.drift * step, 0.0]))
