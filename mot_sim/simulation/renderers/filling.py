"""Filling triangles: which one is nearest at each pixel, and how near it is."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float32, Int32
from numpy import ndarray as Array

from mot_sim.simulation.renderers.triangles import Triangles
from tracker.kernels import Kernel
from tracker.types import Camera

FILL_TRIANGLES = Kernel("mot_sim.simulation.kernels.filling", "fill_triangles")
SPARE_PIXELS = 16  # at the end of what is filled, see `kernels.filling.PIXELS`


@dataclass(frozen=True, eq=False)
class Fragments:
    """What triangles cover of an image."""

    numbers: Int32[Array, "h w"]
    """1 + row of the nearest triangle; 0: none."""
    nearness: Float32[Array, "h w"]
    """The inverse of its depth, 1 / m; 0: none."""


@runtime_checkable
class Filler(Protocol):
    """Finds the nearest triangles; `KernelFiller` is one."""

    def fill(self, triangles: Triangles, camera: Camera) -> Fragments:
        """The nearest triangle at each pixel's centre; of several at one depth, the first."""

    def fill_apart(
        self, triangles: Triangles, camera: Camera, leaves: Bool[Array, " t"]
    ) -> tuple[Fragments, Fragments | None]:
        """`fill` of the triangles that are no leaves, and of those that are, if there are any."""


def fill(triangles: Triangles, camera: Camera) -> Fragments:
    """The nearest triangle at each pixel's centre; of several at one depth, the first.

    The same sums as in `scan_view`: what is covered there is covered here.
    """
    return fill_apart(triangles, camera, np.zeros(len(triangles), bool))[0]


def fill_apart(
    triangles: Triangles, camera: Camera, leaves: Bool[Array, " t"]
) -> tuple[Fragments, Fragments | None]:
    """`fill` of the triangles that are no leaves, and of those that are, if there are any."""
    width, height = camera.image_size
    kinds = (np.float32, np.int32) * (2 if leaves.any() else 1)
    layers = [np.zeros(width * height + SPARE_PIXELS, each) for each in kinds]
    K, corners = np.ascontiguousarray(camera.K, float), np.ascontiguousarray(triangles.corners)
    FILL_TRIANGLES(corners, K, leaves, width, height, *layers[:2], *layers[-2:])
    images = [each[: width * height].reshape(height, width) for each in layers]
    others = Fragments(images[1], images[0])
    return others, Fragments(images[3], images[2]) if len(images) > 2 else None


class KernelFiller:
    """Finds the nearest triangles with the compiled functions `fill` and `fill_apart`."""

    fill = staticmethod(fill)
    fill_apart = staticmethod(fill_apart)
