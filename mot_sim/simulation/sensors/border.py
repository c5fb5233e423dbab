"""What the image's border does: boxes end there, and an edge near it snaps to it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from mot_sim.simulation.sensors.checks import require_sigmas
from tracker.types import Camera


@dataclass(frozen=True)
class Border:
    """snap: pixels; an edge this near to the border lies on it."""

    snap: float = 0.0

    def __post_init__(self) -> None:
        require_sigmas("border snap", self.snap)

    def __call__(self, boxes: Float[Array, "n 4"], camera: Camera) -> Float[Array, "n 4"]:
        """The boxes inside the image; exact boxes stay as they are when nothing snaps."""
        clipped = camera.clip_boxes(boxes)
        if self.snap == 0.0:
            return clipped
        far = camera.far_corner
        low = np.where(clipped[:, :2] < self.snap, 0.0, clipped[:, :2])
        high = np.where(clipped[:, 2:] > far[2:] - self.snap, far[2:], clipped[:, 2:])
        return np.concatenate((low, high), axis=1)


def has_area(boxes: Float[Array, "n 4"]) -> Bool[Array, " n"]:
    """Boxes with an inside; others (wholly outside the image) no detector reports."""
    return np.asarray((boxes[:, 2:] > boxes[:, :2]).all(axis=1))
