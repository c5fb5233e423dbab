"""Filling triangles with OpenCV: which triangle is nearest at each pixel, and how far it is.

`cv2.triangleRasterize` wants an OpenGL camera with the principal point in the middle and one
focal length; ours goes into its `world2cam` as a shear. It clips nothing, so that corners must
lie before the camera. The image needs no flip.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float, Float32, Int, Int32
from numpy import ndarray as Array

from mot_sim.simulation.renderers.triangles import Triangles
from tracker.types import Camera

HALF_PI = 0.5 * np.pi  # the field of view for which OpenCV's focal length is half the height
MAX_NUMBER = float(1 << 24)  # triangle numbers over this are colours in [0, 1], exact in float32
SPARE_PIXELS = 0.1  # pixels: more than single precision may be wrong about where a corner is
DEPTH_MARGIN = 1e-3  # how much wider than the triangles the range of depths is drawn


@dataclass(frozen=True, eq=False)
class Fragments:
    """What triangles cover of the rows of an image from `top` on, until nothing more comes."""

    top: int
    """Row of the image that the first row here is."""
    numbers: Int[Array, "r w"]
    """1 + row of the nearest triangle; 0: none."""
    depth: Float32[Array, "r w"]
    """Metres along the optical axis; valid where there is a triangle."""


class Canvas:
    """OpenCV's buffers and settings for one camera's frame."""

    def __init__(self, camera: Camera) -> None:
        width, height = camera.image_size
        self._camera = camera
        self._A_opencv_cam = world2cam(camera)
        self._depth = np.empty((height, width), np.float32)  # filled where it is used
        self._settings = cv2.TriangleRasterizeSettings()
        self._settings.setCullingMode(cv2.RASTERIZE_CULLING_NONE)
        self._settings.setShadingType(cv2.RASTERIZE_SHADING_FLAT)
        self._settings.setGlCompatibleMode(cv2.RASTERIZE_COMPAT_INVDEPTH)

    def fill(self, triangles: Triangles) -> Fragments:
        """The nearest triangle at each pixel's centre; of several at one depth, the first."""
        points = triangles.corners.reshape(-1, 3).astype(np.float32)
        boxes = pixel_bounds(points, self._camera)
        kept = touching(boxes, self._camera)
        if not len(kept):
            nothing = np.zeros((0, self._depth.shape[1]))
            return Fragments(0, nothing.astype(np.int64), nothing.astype(np.float32))
        height = len(self._depth)
        top = int(max(boxes[1, kept].min() - 1.0, 0.0))
        bottom = int(min(boxes[3, kept].max() + 2.0, height))
        self._depth[top:bottom].fill(1.0)
        numbers = np.zeros((*self._depth.shape, 3), np.float32)
        range_ = near_far(triangles)
        self._draw(points, kept, numbers, range_)
        found = (numbers[top:bottom, :, 0] * np.float32(MAX_NUMBER)).astype(np.int64)
        return Fragments(top, found, depth_of(self._depth[top:bottom], range_))

    def _draw(
        self,
        points: Float32[Array, "c 3"],
        rows: Int[Array, " k"],
        numbers: Float32[Array, "h w 3"],
        range_: tuple[float, float],
    ) -> None:
        """Fill some triangles into the depth and into the picture of numbers."""
        colours = np.zeros((3 * len(rows), 3), np.float32)  # a flat triangle takes the first one's
        colours[::3, 0] = (rows + 1) * (1.0 / MAX_NUMBER)
        cv2.triangleRasterize(
            points.reshape(-1, 9).take(rows, axis=0).reshape(-1, 3),
            _indices(len(rows)),
            colours,
            numbers,
            self._depth,
            self._A_opencv_cam,
            HALF_PI,
            *range_,
            self._settings,
        )

    def draw_alone(
        self, triangles: Triangles, box: tuple[int, int, int, int], range_: tuple[float, float]
    ) -> Float32[Array, "r c"]:
        """How near the triangles are at the pixels of a box that holds them: 1 = nothing there.

        box: first column and row, last column and row plus one. range_: the depths of 0 and 1;
        values between are linear in the inverse of depth, see `depth_of`. The same sums in the
        same buffers as `fill`: a pixel that is covered there is covered here. The array is
        the canvas's own, until the next call.
        """
        left, top, right, bottom = box
        crop = self._depth[top:bottom, left:right]
        crop.fill(1.0)
        cv2.triangleRasterizeDepth(
            triangles.corners.reshape(-1, 3).astype(np.float32),
            _indices(len(triangles)),
            self._depth,
            self._A_opencv_cam,
            HALF_PI,
            *range_,
            self._settings,
        )
        return crop


def pixel_bounds(points: Float32[Array, "c 3"], camera: Camera) -> Float32[Array, "4 t"]:
    """First and last pixels (u, v, u, v) whose centres triangles may hold, a little more.

    points: in the camera's frame, three a triangle.
    """
    bounds = np.empty((4, len(points) // 3), np.float32)
    for axis, row in enumerate(camera.K[:2].astype(np.float32)):
        pixel = points @ row
        pixel /= points[:, 2]
        a, b, c = pixel[::3], pixel[1::3], pixel[2::3]
        bounds[axis] = np.ceil(np.minimum(np.minimum(a, b), c) - SPARE_PIXELS)
        bounds[axis + 2] = np.floor(np.maximum(np.maximum(a, b), c) + SPARE_PIXELS)
    return bounds


def touching(bounds: Float32[Array, "4 t"], camera: Camera) -> Int[Array, " k"]:
    """The triangles that may hold a pixel's centre.

    Those beside the image, and those that slip between the centres, cover nothing.
    """
    width, height = camera.image_size
    left, top, right, bottom = bounds
    inside = (left <= right) & (right >= 0.0) & (left < width)
    return np.flatnonzero(inside & (top <= bottom) & (bottom >= 0.0) & (top < height))


def depth_of(share: Float32[Array, "*s"], range_: tuple[float, float]) -> Float32[Array, "*s"]:
    """Metres, from OpenCV's values: 0 at the near end of the range, 1 at the far one."""
    near, far = range_
    inverse = np.float32(1.0) - share
    inverse *= np.float32(1.0 / near)
    inverse += share * np.float32(1.0 / far)
    return np.divide(np.float32(1.0), inverse, out=inverse)


def world2cam(camera: Camera) -> Float[Array, "4 4"]:
    """From our camera's frame to OpenCV's (y up, z backwards), with K in it as a shear.

    With pixel centres at integers, and OpenCV's at halves, counted from below:
    x = z (2u + 1 - width) / height and y = z (height - 1 - 2v) / height.
    """
    width, height = camera.image_size
    A = np.zeros((4, 4))
    A[0, :3] = 2.0 * camera.K[0] / height
    A[0, 2] += (1.0 - width) / height
    A[1, :3] = -2.0 * camera.K[1] / height
    A[1, 2] += (height - 1.0) / height
    A[2, 2] = -1.0
    A[3, 3] = 1.0
    return A


def near_far(triangles: Triangles) -> tuple[float, float]:
    """As narrow a range of depths as holds the triangles: the z-buffer is finest so."""
    nearest, farthest = triangles.depths
    return nearest * (1.0 - DEPTH_MARGIN), farthest * (1.0 + DEPTH_MARGIN)


@lru_cache(maxsize=64)
def _indices(count: int) -> Int32[Array, "t 3"]:
    return np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
