"""What the edges of a detected box tell of the car: their noise, and where they tell nothing."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.types import Camera

# x_min and y_min lie on the low sides of a box.
OUTWARD = np.array([-1.0, -1.0, 1.0, 1.0])
# An edge is hidden where another box, which ends lower by this (px), ...
MIN_LOWER = 1.0
# ... covers this share of it (left, top, right, bottom), ...
MIN_HIDDEN_SHARE = np.array([0.4, 0.6, 0.4, 0.4])
# ... and its line lies inside that box or nearer to it than this, box heights.
HIDING_MARGIN = 0.03


@dataclass(frozen=True)
class EdgeModel:
    """The noise of the four edges of boxes, and when they are cut."""

    edge_std: float = 0.045
    """Std of an edge at score 1, box heights; it doubles at score 0. Single edges are off by 0.03,
    but the errors of successive boxes are alike; more: the filter follows boxes more slowly."""
    pixel_std: float = 1.0
    """Std of an edge that boxes of any size have besides, px."""
    hidden_factors: tuple[float, float, float, float] = (2.0, 1.2, 2.0, 1.4)
    """How much larger the std is of a left, top, right, bottom edge that another box hides."""
    border: float = 15.0
    """A box that ends this near to the image's border (px) may be cut by it: its edge tells
    nothing where the car is expected to go on."""
    bias: tuple[float, float, float, float] = (0.0, -0.006, 0.0, 0.0)
    """How far the detector's edges lie right of or below the car's on average, box heights."""

    def unbiased(self, boxes: Float[Array, "n 4"]) -> Float[Array, "n 4"]:
        """Boxes without the detector's bias."""
        return boxes - np.array(self.bias) * (boxes[:, 3:] - boxes[:, 1:2])

    def variances(
        self, boxes: Float[Array, "n 4"], scores: Float[Array, " n"], hidden: Bool[Array, "n 4"]
    ) -> Float[Array, "n 4"]:
        """Of the edges of boxes, px^2."""
        heights = np.maximum(boxes[:, 3] - boxes[:, 1], 1.0)
        std = self.edge_std * heights * (2.0 - np.minimum(np.maximum(scores, 0.0), 1.0))
        factors = np.where(hidden, np.square(self.hidden_factors), 1.0)
        return (std**2 + self.pixel_std**2)[:, None] * factors

    def censored(
        self, boxes: Float[Array, "h 4"], expected: Float[Array, "h 4"], camera: Camera
    ) -> Bool[Array, "h 4"]:
        """Which edges the image's border may have cut: the car is expected to go on beyond."""
        return (border_gaps(boxes, camera) < self.border) & ((expected - boxes) * OUTWARD > 0.0)


def border_gaps(boxes: Float[Array, "n 4"], camera: Camera) -> Float[Array, "n 4"]:
    """How far each edge lies inside the image's border, px."""
    gaps: Float[Array, "n 4"] = np.where(OUTWARD < 0.0, boxes, camera.far_corner - boxes)
    return gaps


def hidden_edges(boxes: Float[Array, "n 4"], others: Float[Array, "m 4"]) -> Bool[Array, "n 4"]:
    """Which edges of boxes lie behind one of the others that ends lower, so is nearer."""
    nearer = others[None, :, 3] > boxes[:, 3, None] + MIN_LOWER
    rows, columns = nearer.nonzero()
    hidden = np.zeros((len(boxes), 4), bool)
    if len(rows) == 0:
        return hidden
    mine, theirs = boxes[rows], others[columns]
    size = np.maximum(mine[:, 2:] - mine[:, :2], 1.0)
    shared = np.minimum(mine[:, 2:], theirs[:, 2:]) - np.maximum(mine[:, :2], theirs[:, :2])
    share = (shared / size)[:, [1, 0, 1, 0]]  # of upright edges: in y; of level ones: in x
    margin = HIDING_MARGIN * size[:, 1:]
    low, high = theirs[:, [0, 1, 0, 1]] - margin, theirs[:, [2, 3, 2, 3]] + margin
    covered = (mine > low) & (mine < high) & (share > MIN_HIDDEN_SHARE)
    np.logical_or.at(hidden, rows, covered)
    return hidden
