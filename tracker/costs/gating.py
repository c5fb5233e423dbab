"""What every cost receives: the pairs inside the expected search areas, ready to compare."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.beliefs import MIN_DEPTH, Beliefs
from tracker.kernels import Kernel
from tracker.types import Camera, Cuboids, Detections
from tracker.types.cuboids import CORNERS

# The corners of a region are projected from this depth at least, metres.
MIN_CORNER_DEPTH = 0.25 * MIN_DEPTH
BOX_CUBOIDS = Kernel("tracker.kernels.pairing", "box_cuboids")
GATE = Kernel("tracker.kernels.pairing", "gate")
PLACE_COSTS = Kernel("tracker.kernels.expecting", "place_costs")
DISTANCE_OF_BOXES = Kernel("tracker.kernels.comparing", "distance_of_boxes")


@dataclass(frozen=True, eq=False)
class GatedPairs:
    """Expected beliefs (rows) against observed ones (columns), both in the road frame of now.

    Costs are computed only for the pairs (rows[k], columns[k]) whose detection lies in the
    search area, the region's projection into the image: the paper's main saving.
    """

    expected: Beliefs
    """What is compared with new detections: the tracks as predicted for now."""
    observed: Beliefs
    """The new detections, lifted to the road."""
    detections: Detections
    """The new detections as the detector gave them, in the same order."""
    camera: Camera
    """The camera of both."""
    sigmas: float
    """How many standard deviations the regions are stretched by, >= 0."""
    seconds: float = 0.0
    """Since the last frame that a detector looked at, s, >= 0."""
    expected_regions: Cuboids = field(init=False)
    """g(xi, phi(pi_G^-1(.), s)) of eqs. 3-4, in the road frame."""
    search_areas: Float[Array, "n 4"] = field(init=False)
    """Upright boxes around their projections: x_min, y_min, x_max, y_max, px, clipped to the
    image."""
    pairs: tuple[Int[Array, " k"], Int[Array, " k"]] = field(init=False)
    """Rows and columns of the pairs whose boxes meet the search areas."""

    @classmethod
    def known(
        cls,
        beliefs: tuple[Beliefs, Beliefs],
        detections: Detections,
        how: tuple[Camera, float, float],
        gated: dict[str, Any],
    ) -> "GatedPairs":
        """Those whose regions, search areas and pairs are known.

        beliefs: expected, observed. how: camera, sigmas, seconds.
        """
        (expected, observed), (camera, sigmas, seconds) = beliefs, how
        pairs = object.__new__(cls)
        pairs.__dict__.update(
            expected=expected,
            observed=observed,
            detections=detections,
            camera=camera,
            sigmas=sigmas,
            seconds=seconds,
            **gated,
        )
        return pairs

    def __post_init__(self) -> None:
        starts = np.array((0, len(self.expected))), np.array((0, len(self.observed)))
        self.__dict__.update(self.gated(*starts))

    def gated(self, starts: Int[Array, " _"], seen_starts: Int[Array, " _"]) -> dict[str, Any]:
        """The regions, search areas and pairs of the beliefs and detections of drives.

        starts, seen_starts: where those of each drive begin; only they meet.
        """
        expected, (cuboids, seen) = self.expected, (self.expected.cuboids, self.observed.boxes)
        counts = starts[1:] - starts[:-1], seen_starts[1:] - seen_starts[:-1]
        n, most = len(expected), int(counts[0].dot(counts[1]))
        size, areas = np.empty((n, 3)), np.empty((n, 4))
        rows, columns = np.empty(most, np.int64), np.empty(most, np.int64)
        given = cuboids.base, cuboids.yaw, cuboids.size, expected.cov, self.sigmas
        out = size, areas, rows, columns
        count = GATE(*given, *view_of_regions(self.camera), seen, starts, seen_starts, *out)
        regions = Cuboids(cuboids.base, cuboids.yaw, size)
        pairs = rows[:count], columns[:count]
        return {"expected_regions": regions, "search_areas": areas, "pairs": pairs}

    @cached_property
    def observed_regions(self) -> Cuboids:
        """phi(pi_G^-1(.), s) of eq. 4, of the new detections."""
        return self.observed.region(self.sigmas)

    @cached_property
    def boxes_in_image(self) -> Float[Array, "m 4"]:
        """The new boxes, clipped to the image."""
        return self.camera.clip_boxes(self.observed.boxes)

    @property
    def image_distance(self) -> Float[Array, " k"]:
        """How far the new boxes' centres are from the expected ones: d / (d + diagonal), in [0, 1).

        It decides ties: a box inside the search area costs 0 in eqs. 3-4.
        """
        rows, columns = self.pairs
        distances = np.empty(len(rows))
        DISTANCE_OF_BOXES(self.expected.boxes, self.observed.boxes, rows, columns, distances)
        return distances

    def matrix(self, costs: Float[Array, " k"]) -> Float[Array, "n m"]:
        """The costs of the pairs in their places; inf in all others."""
        matrix = np.empty(self.shape)
        PLACE_COSTS(*self.pairs, np.asarray(costs, float), matrix)
        return matrix

    @cached_property
    def shape(self) -> tuple[int, int]:
        """The number of expected and of observed objects."""
        return len(self.expected), len(self.observed)


def project_cuboids(cuboids: Cuboids, camera: Camera) -> Float[Array, "n 4"]:
    """The upright boxes around cuboids in the image, clipped to it.

    Corners nearer than NEAREST_CORNER, or behind the camera, are drawn forward to that depth, so
    that a region that passes the camera reaches the image's border on its own side; one wholly
    nearer than NEAR gets a box without area.
    """
    boxes = np.empty((len(cuboids), 4))
    BOX_CUBOIDS(cuboids.base, cuboids.yaw, cuboids.size, *view_of_regions(camera), boxes)
    return boxes


def view_of_regions(camera: Camera) -> tuple[Any, ...]:
    """How kernels project corners of cuboids."""
    lens = camera.P_road_centred, camera.principal_point, camera.far_corner
    return *lens, CORNERS, MIN_CORNER_DEPTH, MIN_DEPTH
