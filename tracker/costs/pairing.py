"""What every cost receives: the pairs inside the expected search areas, ready to compare."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.beliefs import NEAR, Beliefs
from tracker.types import Camera, Cuboids, Detections

# The corners of a region are projected from this depth at least, metres.
NEAREST_CORNER = 0.25 * NEAR


@dataclass(frozen=True, eq=False)
class Pairing:
    """Expected beliefs (rows) against observed ones (columns), both in the road frame of now.

    Costs are computed only for the pairs (rows[k], columns[k]) whose detection lies in the
    search area, the region's projection into the image: the paper's main saving.
    sigmas: how many standard deviations the regions are stretched by.
    """

    expected: Beliefs
    observed: Beliefs
    detections: Detections
    camera: Camera
    sigmas: float

    @cached_property
    def expected_regions(self) -> Cuboids:
        """g(xi, phi(pi_G^-1(.), s)) of eqs. 3-4."""
        return self.expected.region(self.sigmas)

    @cached_property
    def observed_regions(self) -> Cuboids:
        """phi(pi_G^-1(.), s) of eq. 4, of the new detections."""
        return self.observed.region(self.sigmas)

    @cached_property
    def search_areas(self) -> Float[Array, "n 4"]:
        """The upright boxes around the expected regions' projections, clipped to the image."""
        return project_cuboids(self.expected_regions, self.camera)

    @cached_property
    def boxes_in_image(self) -> Float[Array, "m 4"]:
        """The new boxes, clipped to the image."""
        return self.camera.clip_boxes(self.observed.boxes)

    @cached_property
    def pairs(self) -> tuple[Int[Array, " k"], Int[Array, " k"]]:
        """Rows and columns of the pairs whose boxes meet the search areas."""
        a, b = self.search_areas[:, None], self.observed.boxes[None]
        meet = np.minimum(a[..., 2:], b[..., 2:]) > np.maximum(a[..., :2], b[..., :2])
        rows, columns = (meet[..., 0] & meet[..., 1]).nonzero()
        return rows, columns

    @property
    def image_distance(self) -> Float[Array, " k"]:
        """How far the new boxes' centres are from the expected ones: d / (d + diagonal), in [0, 1).

        It decides ties: a box inside the search area costs 0 in eqs. 3-4.
        """
        rows, columns = self.pairs
        expected, observed = self.expected.boxes[rows], self.observed.boxes[columns]
        off = 0.5 * (expected[:, :2] + expected[:, 2:] - observed[:, :2] - observed[:, 2:])
        sides = observed[:, 2:] - observed[:, :2]
        distance = np.hypot(off[:, 0], off[:, 1])
        return distance / (distance + np.hypot(sides[:, 0], sides[:, 1]))

    @property
    def shape(self) -> tuple[int, int]:
        """The number of expected and of observed objects."""
        return len(self.expected), len(self.observed)


def project_cuboids(cuboids: Cuboids, camera: Camera) -> Float[Array, "n 4"]:
    """The upright boxes around cuboids in the image, clipped to it.

    Corners nearer than NEAREST_CORNER, or behind the camera, are drawn forward to that depth, so
    that a region that passes the camera reaches the image's border on its own side; one wholly
    nearer than NEAR gets a box without area.
    """
    P = camera.P_road_centred
    corners = cuboids.corners() @ P[:, :3].T + P[:, 3]
    depth = corners[:, :, 2:]
    pixels = corners[:, :, :2] / np.maximum(depth, NEAREST_CORNER)
    pixels += camera.K[:2, 2]
    boxes = camera.clip_boxes(np.concatenate((pixels.min(axis=1), pixels.max(axis=1)), axis=1))
    behind = depth[:, :, 0].max(axis=1) < NEAR
    if behind.any():
        boxes[behind] = 0.0
    return boxes
