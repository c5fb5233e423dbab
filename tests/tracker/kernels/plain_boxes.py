"""Boxes of cars in plain NumPy: what the kernels must equal."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.car_filter.states import LOG_HEIGHT, LOG_SIZE, STATE_SIZE, YAW
from tracker.types import Camera
from tracker.types.cuboids import CORNERS

# Corners nearer to the camera than this are taken to be this far, m.
MIN_CORNER_DEPTH = 0.5
# The twelve edges of a cuboid, as pairs of its corners.
CUBOID_EDGES = np.array(
    [(a, b) for a in range(8) for b in range(a) if np.abs(CORNERS[a] - CORNERS[b]).sum() in (1, 2)]
)
# Of the points that may lie highest or lowest inside the image: the corners, then the places where
# the edges cross the left side, and the right one. The two corners between which each lies.
POINT_CORNERS = np.concatenate((np.arange(8)[:, None].repeat(2, 1), CUBOID_EDGES, CUBOID_EDGES))
# Rows of the projection that x_min, y_min, x_max and y_max are of.
EDGE_ROWS = np.array([0, 1, 0, 1])


class CarAxes(NamedTuple):
    """What the corners of cuboids depend on besides their places."""

    cosine: Float[Array, " h"]
    """Of the yaw."""
    sine: Float[Array, " h"]
    """Of the yaw."""
    size: Float[Array, "h 3"]
    """Length, height and width, m."""

    @classmethod
    def of(cls, states: Float[Array, "h 9"]) -> "CarAxes":
        """Of these cars."""
        yaw = states[:, YAW]
        return cls(np.cos(yaw), np.sin(yaw), np.exp(states[:, LOG_SIZE]))

    def corners(self, states: Float[Array, "h 9"], P: Float[Array, "3 4"]) -> Float[Array, "8 h 3"]:
        """Homogeneous pixels of the corners, in the order of CORNERS."""
        p_x, p_y, p_z = P[:, 0], P[:, 1], P[:, 2]
        c, s = self.cosine[:, None], self.sine[:, None]
        axes = np.empty((3, len(states), 3))  # what each half axis adds
        axes[0] = 0.5 * self.size[:, 0, None] * (c * p_x - s * p_z)
        axes[1] = self.size[:, 1, None] * p_y
        axes[2] = 0.5 * self.size[:, 2, None] * (s * p_x + c * p_z)
        centre = states[:, :3].dot(P[:, :3].T) + P[:, 3]
        corners: Float[Array, "8 h 3"] = CORNERS.dot(axes.reshape(3, -1)).reshape(8, -1, 3)
        return corners + centre

    def by_state(
        self, gradient: Float[Array, "e h 3"], corners: Int[Array, "e h"]
    ) -> Float[Array, "h e 9"]:
        """Derivatives by the state of what depends so on the places of these corners, per metre."""
        signs = CORNERS[corners]
        g_x, g_z = gradient[:, :, 0], gradient[:, :, 2]
        along = self.cosine * g_x - self.sine * g_z
        across = self.sine * g_x + self.cosine * g_z
        by_l = signs[:, :, 0] * (0.5 * self.size[:, 0])
        by_w = signs[:, :, 2] * (0.5 * self.size[:, 2])
        jacobian = np.zeros((*gradient.shape[:2], STATE_SIZE))
        jacobian[:, :, :3] = gradient
        jacobian[:, :, YAW] = by_w * along - by_l * across
        jacobian[:, :, 5] = by_l * along
        jacobian[:, :, LOG_HEIGHT] = signs[:, :, 1] * self.size[:, 1] * gradient[:, :, 1]
        jacobian[:, :, 7] = by_w * across
        return jacobian.transpose(1, 0, 2)

    def select(self, rows: Int[Array, " k"]) -> "CarAxes":
        """Those of these cars."""
        return CarAxes(self.cosine[rows], self.sine[rows], self.size[rows])


def plain_project_boxes(
    states: Float[Array, "h 9"], camera: Camera
) -> tuple[Float[Array, "h 4"], Float[Array, "h 4 9"]]:
    """The upright boxes around projected cuboids (x_min, y_min, x_max, y_max, px).

    And their Jacobians: each edge is that of the corner which it touches. Boxes are not clipped,
    but of a car that reaches beyond the left or right border of the image, upper and lower edge are
    those of its part inside: the nearest corner, which would be lowest, is not seen.
    """
    P, axes, count = camera.P_road, CarAxes.of(states), np.arange(len(states))
    corners = axes.corners(states, P)
    u, v, w = _pixels(corners)
    touched = np.array((u.argmin(0), v.argmin(0), u.argmax(0), v.argmax(0)))
    edges = np.empty(touched.shape)
    edges[::2], edges[1::2] = u[touched[::2], count], v[touched[1::2], count]
    # d edge = (row of P - edge * last row of P) . dX / depth
    gradient = (P[EDGE_ROWS, :3][:, None] - edges[:, :, None] * P[2, :3]) / w[touched, count][
        :, :, None
    ]
    jacobian, edges = axes.by_state(gradient, touched), edges.T
    cut = _reaching_out(edges, camera)
    if len(cut):
        levels = LevelsInside.of(corners[:, cut].transpose(1, 0, 2), camera)
        seen = np.isfinite(levels.rows).all(axis=1)
        cut, levels = cut[seen], levels.select(seen)
        edges[cut, 1::2], jacobian[cut, 1::2] = levels.rows, levels.by_state(axes.select(cut), P)
    return edges, jacobian


class LevelsInside(NamedTuple):
    """Highest and lowest point of the parts of cuboids between the image's sides."""

    rows: Float[Array, "h 2"]
    """Their rows, px; infinite where there is no such part."""
    corners: Int[Array, "h 2 2"]
    """The corners between which each lies."""
    ends: Float[Array, "h 2 2 3"]
    """Homogeneous pixels of those."""
    inward: Float[Array, "h 2 2"]
    """How far these lie inside of the side that the point lies on, times their depths."""
    normal: Float[Array, "h 2 3"]
    """What that distance is of homogeneous pixels; 0 where the point is a corner itself."""

    @classmethod
    def of(cls, pixels: Float[Array, "h 8 3"], camera: Camera) -> "LevelsInside":
        """Of the parts of cuboids with these corners, in homogeneous pixels."""
        sides = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, camera.far_corner[0]]])
        inward = pixels.dot(sides.T)  # h, 8, 2
        a, b = inward[:, CUBOID_EDGES[:, 0]], inward[:, CUBOID_EDGES[:, 1]]
        crosses = a * b < 0.0
        share = a / np.where(crosses, a - b, 1.0)
        first, second = pixels[:, CUBOID_EDGES[:, 0]], pixels[:, CUBOID_EDGES[:, 1]]
        change = second - first
        crossings = [first + share[:, :, side, None] * change for side in (0, 1)]
        points = np.concatenate((pixels, *crossings), axis=1)
        crosses = crosses.transpose(0, 2, 1).reshape(len(pixels), -1)
        seen = np.concatenate(((inward > 0.0).all(axis=2), crosses), axis=1)
        seen &= points[:, :, 2] > MIN_CORNER_DEPTH
        levels = points[:, :, 1] / np.where(seen, points[:, :, 2], 1.0)
        above, below = np.where(seen, levels, np.inf), np.where(seen, levels, -np.inf)
        which = np.array((above.argmin(axis=1), below.argmax(axis=1))).T
        car = np.arange(len(pixels))[:, None]
        corners = POINT_CORNERS[which]
        side = (which >= 8 + len(CUBOID_EDGES)).astype(int)
        normal = sides[side] * (which >= 8)[:, :, None]
        return cls(
            np.array((above[car[:, 0], which[:, 0]], below[car[:, 0], which[:, 1]])).T,
            corners,
            pixels[car[:, :, None], corners],
            inward[car[:, :, None], corners, side[:, :, None]],
            normal,
        )

    def select(self, rows: Bool[Array, " h"]) -> "LevelsInside":
        """Those of these cars."""
        return LevelsInside(*(column[rows] for column in self))

    def by_state(self, axes: CarAxes, P: Float[Array, "3 4"]) -> Float[Array, "h 2 9"]:
        """Derivatives of the rows, which are finite, by the states of these cars."""
        a, b = self.inward[:, :, 0, None], self.inward[:, :, 1, None]
        crosses = self.normal.any(axis=2, keepdims=True)
        between = np.where(crosses, a - b, 1.0)
        share = np.where(crosses, a / between, 0.0)
        change = self.ends[:, :, 1] - self.ends[:, :, 0]
        depth = self.ends[:, :, 0, 2] + share[:, :, 0] * change[:, :, 2]
        by_point = np.zeros(change.shape)  # of a row: by the homogeneous pixel of its point
        by_point[:, :, 1], by_point[:, :, 2] = 1.0 / depth, -self.rows / depth
        # along the edge, since the place where it crosses the side moves
        moves = (by_point * change).sum(axis=2, keepdims=True) / between**2 * self.normal
        ends = (1.0 - share) * by_point - b * moves, share * by_point + a * moves
        gradient = np.concatenate(ends, axis=1).dot(P[:, :3]).transpose(1, 0, 2)
        corners = self.corners.transpose(2, 1, 0).reshape(4, -1)
        jacobian = axes.by_state(gradient, corners)
        by_state: Float[Array, "h 2 9"] = jacobian[:, :2] + jacobian[:, 2:]
        return by_state


def _pixels(
    corners: Float[Array, "8 h 3"],
) -> tuple[Float[Array, "8 h"], Float[Array, "8 h"], Float[Array, "8 h"]]:
    """Column, row (px) and depth (m) of corners; none is nearer than MIN_CORNER_DEPTH."""
    depth = np.maximum(corners[:, :, 2], MIN_CORNER_DEPTH)
    return corners[:, :, 0] / depth, corners[:, :, 1] / depth, depth


def _reaching_out(edges: Float[Array, "h 4"], camera: Camera) -> Int[Array, " k"]:
    """Which boxes go on beyond the left or right border of the image."""
    beyond = (edges[:, 0] < 0.0) | (edges[:, 2] > camera.far_corner[0])
    cut: Int[Array, " k"] = beyond.nonzero()[0]
    return cut
