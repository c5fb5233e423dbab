"""3D-2D: how much of the new box lies in the expected search area (eq. 3)."""

from dataclasses import dataclass

from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs.gating import GatedPairs
from tracker.geometry.overlap import box_area, box_intersection


@dataclass(frozen=True)
class Reprojection:
    """1 - |search area n box| / |box|: 0 inside the search area (eq. 3).

    The part of a box outside the image does not count; a box without area costs NaN.
    """

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        """The cost of every pair of the pairing, in [0, 1]."""
        rows, columns = pairing.pairs
        boxes = pairing.boxes_in_image[columns]
        return 1.0 - box_intersection(pairing.search_areas[rows], boxes) / box_area(boxes)
