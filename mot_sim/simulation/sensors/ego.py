"""The ego car's own measurements: odometry that drifts, a camera that is not quite as believed."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.checks import require_finite, require_rates, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import (
    FRAME_ID,
    Autocorrelation,
    bursts,
    correlated_normals,
)
from tracker.geometry import homogeneous, invert, rotation_x, rotation_y
from tracker.types import Camera


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
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    dropout_autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)

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
        owner = np.full_like(frames, FRAME_ID)
        x = correlated_normals(seed, "odometry", owner, frames, self.autocorrelation, step, 2)
        rates = np.full(len(frames), min(level * self.dropouts, 1.0))
        lost = bursts(
            rates, seed, "odometry/lost", owner, frames, self.dropout_autocorrelation, step
        )
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


@dataclass(frozen=True)
class Miscalibration:
    """Stds, drawn once an episode: focal (relative), pitch (radians), height (metres).

    slope: radians by which the road ahead rises (not drawn; to the tracker it is a pitch).
    vibration: std in radians of the pitch from frame to frame; autocorrelation: of it.
    """

    focal: float = 0.0
    pitch: float = 0.0
    height: float = 0.0
    slope: float = 0.0
    vibration: float = 0.0
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)

    def __post_init__(self) -> None:
        require_sigmas("miscalibration", self.focal, self.pitch, self.height, self.vibration)
        require_finite("miscalibration slope", self.slope)

    def believed(self, camera: Camera, seed: int, level: float = 1.0) -> Camera:
        """The camera that the tracker is given; the true one at level 0."""
        if level == 0.0 or not (self.focal or self.pitch or self.height or self.slope):
            return camera
        nothing = np.zeros(1, np.int64)
        x = random_numbers.normal(seed, "miscalibration", nothing, nothing, 3)[0]
        K = camera.K.copy()
        K[[0, 1], [0, 1]] *= np.exp(level * self.focal * x[0])
        pitch = level * (self.pitch * x[1] - self.slope)
        T_road_cam = camera.T_road_cam @ homogeneous(rotation_x(pitch), np.zeros(3))
        T_road_cam[1, 3] *= np.exp(level * self.height * x[2] / camera.height)
        return Camera(K, camera.image_size, invert(T_road_cam))

    def shake(
        self,
        boxes: Float[Array, "n 4"],
        frames: Int[Array, " n"],
        camera: Camera,
        seed: int,
        step: float,
        level: float = 1.0,
    ) -> Float[Array, "n 4"]:
        """Boxes where a vibrating mount puts them: all of a frame move up or down alike."""
        if level == 0.0 or self.vibration == 0.0:
            return boxes
        owner = np.full_like(frames, FRAME_ID)
        x = correlated_normals(seed, "vibration", owner, frames, self.autocorrelation, step)[:, 0]
        rise = camera.K[1, 1] * np.tan(level * self.vibration * x)
        return boxes + rise[:, None] * np.array([0.0, 1.0, 0.0, 1.0])
