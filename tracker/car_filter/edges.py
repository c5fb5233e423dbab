"""What the edges of a detected box tell of the car: their noise, and where they tell nothing."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.kernels import Kernel
from tracker.types import Camera

HIDE_EDGES = Kernel("tracker.kernels.car_scene", "hide_edges")
WEIGH_EDGES = Kernel("tracker.kernels.car_scene", "weigh_edges_of_boxes")
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

    def __call__(
        self, boxes: Float[Array, "n 4"], scores: Float[Array, " n"], hidden: Bool[Array, "n 4"]
    ) -> tuple[Float[Array, "n 4"], Float[Array, "n 4"]]:
        """Boxes without the detector's bias, and the variances of their edges, px^2."""
        unbiased, variances = np.empty(boxes.shape), np.empty(boxes.shape)
        WEIGH_EDGES(boxes, scores, hidden, *self.noise, unbiased, variances)
        return unbiased, variances

    @cached_property
    def noise(self) -> tuple[Float[Array, "4"], Float[Array, "4"], float, float]:
        """The bias, the factors of hidden edges, and the stds, as the kernels take them."""
        by_edge = np.array(self.bias, float), np.array(self.hidden_factors, float)
        return *by_edge, self.edge_std, self.pixel_std


def border_gaps(boxes: Float[Array, "n 4"], camera: Camera) -> Float[Array, "n 4"]:
    """How far each edge lies inside the image's border, px."""
    gaps: Float[Array, "n 4"] = np.where(OUTWARD < 0.0, boxes, camera.far_corner - boxes)
    return gaps


def hidden_edges(boxes: Float[Array, "n 4"], others: Float[Array, "m 4"]) -> Bool[Array, "n 4"]:
    """Which edges of boxes lie behind one of the others that ends lower, so is nearer."""
    hidden = np.empty((len(boxes), 4), bool)
    HIDE_EDGES(boxes, others, MIN_LOWER, MIN_HIDDEN_SHARE, HIDING_MARGIN, hidden)
    return hidden
