"""Filling triangles: which one is nearest at each pixel, and how near it is."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from jaxtyping import Bool, Float32, Int32
from numpy import ndarray as Array

from mot_sim.simulation.renderers.triangles import Triangles
from tracker.kernels import Kernel
from tracker.types import Camera

FILL_TRIANGLES = Kernel("mot_sim.simulation.kernels.filling", "fill_triangles")
FILL_AROUND_LEAVES = Kernel("mot_sim.simulation.kernels.filling", "fill_around_leaves")


@dataclass(frozen=True, eq=False)
class Fragments:
    """What triangles cover of an image."""

    numbers: Int32[Array, "h w"]
    """1 + row of the nearest triangle; 0: none."""
    nearness: Float32[Array, "h w"]
    """The inverse of its depth, 1 / m; 0: none."""


class Filler(Protocol):
    """Finds the nearest triangles; `KernelFiller` is one."""

    def fill(self, triangles: Triangles, camera: Camera) -> Fragments:
        """The nearest triangle at each pixel's centre; of several at one depth, the first."""

    def fill_behind(
        self, triangles: Triangles, camera: Camera, leaves: Bool[Array, " t"]
    ) -> tuple[Fragments, Fragments]:
        """`fill`, and what lies behind those triangles that are leaves; known beneath leaves."""


def fill(triangles: Triangles, camera: Camera) -> Fragments:
    """The nearest triangle at each pixel's centre; of several at one depth, the first.

    The same sums as in `scan_view`: what is covered there is covered here.
    """
    width, height = camera.image_size
    numbers, nearness = np.zeros((height, width), np.int32), np.zeros((height, width), np.float32)
    K = np.ascontiguousarray(camera.K, float)
    FILL_TRIANGLES(np.ascontiguousarray(triangles.corners), K, nearness, numbers)
    return Fragments(numbers, nearness)


def fill_behind(
    triangles: Triangles, camera: Camera, leaves: Bool[Array, " t"]
) -> tuple[Fragments, Fragments]:
    """`fill`, and what lies behind those triangles that are leaves; known only beneath leaves."""
    width, height = camera.image_size
    seen = Fragments(np.zeros((height, width), np.int32), np.zeros((height, width), np.float32))
    behind = Fragments(np.empty((height, width), np.int32), np.empty((height, width), np.float32))
    K, corners = np.ascontiguousarray(camera.K, float), np.ascontiguousarray(triangles.corners)
    FILL_AROUND_LEAVES(
        corners, K, leaves, seen.nearness, seen.numbers, behind.nearness, behind.numbers
    )
    return seen, behind


class KernelFiller:
    """Finds the nearest triangles with the compiled functions `fill` and `fill_behind`."""

    fill = staticmethod(fill)
    fill_behind = staticmethod(fill_behind)
