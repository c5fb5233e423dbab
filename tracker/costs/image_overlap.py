"""2D-2D: the overlap of the expected box with the new one."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs.gating import GatedPairs
from tracker.geometry import box_iou


@dataclass(frozen=True)
class ImageOverlap:
    """1 - IoU of the expected box (moved by the camera's and the car's motion) and the new one.

    Not of the paper's eqs. 3-6; its Table IV uses such a 2D-2D cue as the baseline.
    """

    buffer: float = 0.0
    """Share of its sides that both boxes are widened by, on each side, so that small and fast cars
    still meet (as C-BIoU does); more: boxes farther apart overlap."""
    drift: float = 0.0
    """Share of its sides per second since the last frame that a detector looked at; both boxes are
    widened by that where it is more than `buffer`."""

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        """The cost of every pair of the pairing, in [0, 1]."""
        rows, columns = pairing.pairs
        fraction = max(self.buffer, round(self.drift * pairing.seconds, 6))
        expected = widened(pairing.expected.boxes, fraction)
        observed = widened(pairing.observed.boxes, fraction)
        return 1.0 - box_iou(expected.take(rows, 0), observed.take(columns, 0))


def widened(boxes: Float[Array, "n 4"], fraction: float) -> Float[Array, "n 4"]:
    """The boxes with every side moved outwards by a fraction of the box's width or height."""
    return boxes.dot(_widening(fraction)) if fraction else boxes


@lru_cache(maxsize=64)
def _widening(fraction: float) -> Float[Array, "4 4"]:
    """x_min - f (x_max - x_min), and so on, as a matrix."""
    return np.eye(4) * (1.0 + 2.0 * fraction) - fraction * np.tile(np.eye(2), (2, 2))
