"""A camera that is not quite what is believed: focal length, pitch, height, a loose mount."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.bursts import FRAME
from mot_sim.simulation.sensors.checks import require_finite, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals
from tracker.geometry import homogeneous, invert, rotation_x
from tracker.types import Camera


@dataclass(frozen=True)
class Miscalibration:
    """Stds, drawn once an episode: focal (relative), pitch (radians), height (metres).

    slope: radians by which the road ahead rises (not drawn; to the tracker it is a pitch).
    vibration: std in radians of the pitch from frame to frame; memory: of it.
    """

    focal: float = 0.0
    pitch: float = 0.0
    height: float = 0.0
    slope: float = 0.0
    vibration: float = 0.0
    memory: Autocorrelation = field(default_factory=Autocorrelation)

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
        owner = np.full_like(frames, FRAME)
        x = correlated_normals(seed, "vibration", owner, frames, self.memory, step)[:, 0]
        rise = camera.K[1, 1] * np.tan(level * self.vibration * x)
        return boxes + rise[:, None] * np.array([0.0, 1.0, 0.0, 1.0])
