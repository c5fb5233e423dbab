"""Lens distortion (Brown's model, as OpenCV has it): to a pinhole camera's pixels and back."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import ceil, floor

import cv2
import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import BadCalibration
from tracker.types import Camera

COUNTS = (4, 5, 8)
# The pinhole image may be so many times as wide and as high as the real one.
MAX_GROWTH = 4.0
# Points on each border of the image that are followed.
BORDER_POINTS = 65
# Each takes what is off after there and back to about a tenth.
REPAIRS = 4
# Pixels by which a point may miss itself after there and back.
MAX_ROUND_TRIP = 0.05


@dataclass(frozen=True, eq=False)
class Distortion:
    """A camera with a lens, and the pinhole camera that stands in for it.

    Raises BadCalibration for a lens that folds the image over, or bends it beyond use.
    """

    camera: Camera
    """The real camera; its K is that of the lens model, its image size that of the images."""
    coefficients: Float[Array, " c"]
    """k1, k2, p1, p2 and perhaps k3, k4, k5, k6: OpenCV's order; 4, 5 or 8 of them."""

    def __post_init__(self) -> None:
        width, height = self.camera.image_size
        x, y = np.meshgrid(
            np.linspace(0.0, width - 1.0, BORDER_POINTS),
            np.linspace(0.0, height - 1.0, BORDER_POINTS),
        )
        grid = np.stack([x.ravel(), y.ravel()], axis=1)
        straight = self._straight(grid)
        miss = np.abs(self._bent(straight) - grid).max()
        steps = straight.reshape(BORDER_POINTS, BORDER_POINTS, 2)
        right, down = np.diff(steps, axis=1)[:-1], np.diff(steps, axis=0)[:, :-1]
        turned = right[..., 0] * down[..., 1] - right[..., 1] * down[..., 0]
        if not (miss < MAX_ROUND_TRIP and (turned > 0.0).all()):
            raise BadCalibration(
                f"distortion {self.coefficients.tolist()} folds the {width}x{height} image over: "
                "no pinhole camera sees the same; are they k1, k2, p1, p2, k3 for this K?"
            )
        _ = self.pinhole

    @cached_property
    def _corner(self) -> tuple[int, int, int, int]:
        """Where the image's border lies without the lens: left, top, right, bottom, px, whole."""
        width, height = self.camera.image_size
        along = np.linspace(0.0, width - 1.0, BORDER_POINTS)
        down = np.linspace(0.0, height - 1.0, BORDER_POINTS)
        border = np.concatenate(
            [np.stack([along, np.full_like(along, v)], 1) for v in (0.0, height - 1.0)]
            + [np.stack([np.full_like(down, u), down], 1) for u in (0.0, width - 1.0)]
        )
        left, top = self._straight(border).min(axis=0)
        right, bottom = self._straight(border).max(axis=0)
        return floor(left), floor(top), ceil(right), ceil(bottom)

    @cached_property
    def pinhole(self) -> Camera:
        """The pinhole camera at the same place, whose image holds all that the lens shows."""
        left, top, right, bottom = self._corner
        size = int(right - left) + 1, int(bottom - top) + 1
        growth = np.array(size) / np.array(self.camera.image_size)
        if growth.max() > MAX_GROWTH:
            raise BadCalibration(
                f"distortion {self.coefficients.tolist()}: without it the image has "
                f"{size[0]}x{size[1]} pixels; so wide a view is no pinhole's (a fisheye lens?)"
            )
        K = self.camera.K.copy()
        K[:2, 2] -= left, top
        return Camera(K, size, self.camera.T_cam_road)

    def undistort_boxes(self, boxes: Float[Array, "n 4"]) -> Float[Array, "n 4"]:
        """Boxes of the real image in the pinhole's: by the middles of their edges."""
        offset = np.array([*self._corner[:2]])
        return _moved(boxes, lambda points: self._straight(points) - offset)

    def distort_boxes(self, boxes: Float[Array, "n 4"]) -> Float[Array, "n 4"]:
        """Boxes of the pinhole's image in the real one, clipped to it."""
        offset = np.array([*self._corner[:2]])
        wanted = _moved(boxes, lambda points: self._bent(points + offset))
        bent = wanted
        for _ in range(REPAIRS):  # the middles of edges are not quite the same on both sides
            there = self.undistort_boxes(bent)
            bent = bent + wanted - _moved(there, lambda points: self._bent(points + offset))
        return self.camera.clip_boxes(bent)

    def _straight(self, points: Float[Array, "n 2"]) -> Float[Array, "n 2"]:
        """Pixels without the lens, in the real camera's K."""
        K, criteria = self.camera.K, (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-9)
        # OpenCV 4 has a name of its own for it with a criterion
        undistort = getattr(cv2, "undistortPointsIter", cv2.undistortPoints)
        seen = points.reshape(-1, 1, 2), K, self.coefficients
        found = undistort(*seen, R=np.eye(3), P=K, criteria=criteria)
        return np.asarray(found, dtype=float).reshape(-1, 2)

    def _bent(self, points: Float[Array, "n 2"]) -> Float[Array, "n 2"]:
        """The inverse of `_straight`."""
        K = self.camera.K
        rays = np.linalg.solve(K, np.column_stack([points, np.ones(len(points))]).T).T
        found, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), K, self.coefficients)
        return np.asarray(found, dtype=float).reshape(-1, 2)


def _moved(
    boxes: Float[Array, "n 4"], move: Callable[[Float[Array, "n 2"]], Float[Array, "n 2"]]
) -> Float[Array, "n 4"]:
    """Boxes whose edges go where their middles go."""
    if len(boxes) == 0:
        return boxes
    middle = 0.5 * (boxes[:, :2] + boxes[:, 2:])
    left = move(np.column_stack([boxes[:, 0], middle[:, 1]]))[:, 0]
    right = move(np.column_stack([boxes[:, 2], middle[:, 1]]))[:, 0]
    top = move(np.column_stack([middle[:, 0], boxes[:, 1]]))[:, 1]
    bottom = move(np.column_stack([middle[:, 0], boxes[:, 3]]))[:, 1]
    return np.column_stack([left, top, right, bottom])
