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
    """How the ego car's measured motion is off."""

    scale: float = 0.0
    """Measured over true path, less 1, finite; 0.01: every way is 1 % too long."""
    drift: float = 0.0
    """Std of the yaw rate's error, rad/s, >= 0; more: the measured path bends more."""
    slip: float = 0.0
    """Std of the relative error of a step's length, >= 0; more: less exact steps."""
    dropouts: float = 0.0
    """Rate of frames whose motion is unknown and taken for none, 0 to 1; more: more lost motion."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How drift and slip are correlated over time; slower: larger errors of the path."""
    dropout_autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How dropouts are correlated over time; slower: more frames are lost in a row."""

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
    """How far the camera that the tracker is given is from the true one; drawn once per episode."""

    focal: float = 0.0
    """Std of the focal length's relative error, >= 0; more: distances are less exact."""
    pitch: float = 0.0
    """Std of the pitch's error, radians, >= 0; more: the road's distances are less exact."""
    height: float = 0.0
    """Std of the error of the height above the road, metres, >= 0; more: distances are less
    exact."""
    slope: float = 0.0
    """Radians by which the road ahead rises, finite; not drawn, and to the tracker it is a
    pitch."""
    vibration: float = 0.0
    """Std of the pitch from frame to frame, radians, >= 0; more: all boxes of a frame move more."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How the vibration is correlated over time; slower: the boxes sway instead of jumping."""

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
