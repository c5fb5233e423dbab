"""The box that a car fills in the image, with its derivatives by the state."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter.states import LOG_SIZE, STATE_SIZE
from tracker.types import Camera, Cuboids
from tracker.types.cuboids import CORNERS

# Corners nearer to the camera than this are taken to be this far, m.
MIN_CORNER_DEPTH = 0.5
# The twelve edges of a cuboid, as pairs of its corners.
CUBOID_EDGES = np.array(
    [(a, b) for a in range(8) for b in range(a) if np.abs(CORNERS[a] - CORNERS[b]).sum() in (1, 2)]
)
# Steps of numerical derivatives.
STEP = 1e-5
# Columns of a state that the box depends on.
SEEN_COLUMNS = np.array([0, 1, 2, 3, 5, 6, 7])


def project_boxes(
    states: Float[Array, "h 9"], camera: Camera
) -> tuple[Float[Array, "h 4"], Float[Array, "h 4 9"]]:
    """The upright boxes around projected cuboids (x_min, y_min, x_max, y_max, px).

    And their Jacobians: each edge is that of the corner which it touches. Boxes are not clipped,
    but of a car that reaches beyond the left or right border of the image, upper and lower edge are
    those of its part inside: the nearest corner, which would be lowest, is not seen.
    """
    edges, jacobian = _whole_boxes(states, camera)
    cut = ((edges[:, 0] < 0.0) | (edges[:, 2] > camera.far_corner[0])).nonzero()[0]
    if len(cut):
        inside, by_state = _levels_inside(states[cut], camera)
        seen = np.isfinite(inside).all(axis=1)
        edges[cut[seen], 1::2], jacobian[cut[seen], 1::2] = inside[seen], by_state[seen]
    return edges, jacobian


def expected_boxes(states: Float[Array, "h 9"], camera: Camera) -> Float[Array, "h 4"]:
    """The boxes of `project_boxes`, without derivatives."""
    u, v, _ = _corners(states, camera)
    edges = np.stack((u.min(0), v.min(0), u.max(0), v.max(0)), axis=1)
    cut = ((edges[:, 0] < 0.0) | (edges[:, 2] > camera.far_corner[0])).nonzero()[0]
    if len(cut):
        inside = _levels(states[cut], camera)
        seen = np.isfinite(inside).all(axis=1)
        edges[cut[seen], 1::2] = inside[seen]
    return edges


def _levels_inside(
    states: Float[Array, "h 9"], camera: Camera
) -> tuple[Float[Array, "h 2"], Float[Array, "h 2 9"]]:
    """Highest and lowest row (px) of the parts between the image's sides, and their derivatives.

    Infinite where there is no such part.
    """
    h, changes = len(states), STEP * np.eye(STATE_SIZE)[SEEN_COLUMNS]
    steps = np.concatenate((np.zeros((1, STATE_SIZE)), changes, -changes))
    levels = _levels((states + steps[:, None]).reshape(-1, STATE_SIZE), camera)
    levels = levels.reshape(len(steps), h, 2)
    jacobian = np.zeros((h, 2, STATE_SIZE))
    with np.errstate(invalid="ignore"):
        slopes = (levels[1 : len(changes) + 1] - levels[len(changes) + 1 :]) / (2.0 * STEP)
    jacobian[:, :, SEEN_COLUMNS] = np.nan_to_num(slopes).transpose(1, 2, 0)
    return levels[0], jacobian


def _levels(states: Float[Array, "h 9"], camera: Camera) -> Float[Array, "h 2"]:
    """Highest and lowest row of the parts of cuboids between the image's sides, px."""
    cuboids = Cuboids(states[:, :3], states[:, 3], np.exp(states[:, LOG_SIZE]))
    P = camera.K.dot(camera.T_cam_road[:3])
    pixels = cuboids.corners().dot(P[:, :3].T) + P[:, 3]  # h, 8, 3; homogeneous
    inward = np.stack(
        (pixels[:, :, 0], camera.far_corner[0] * pixels[:, :, 2] - pixels[:, :, 0])
    )  # how far inside of the left and of the right side, times the depth
    a, b = inward[:, :, CUBOID_EDGES[:, 0]], inward[:, :, CUBOID_EDGES[:, 1]]
    crosses = a * b < 0.0
    share = a / np.where(crosses, a - b, 1.0)
    first, second = pixels[:, CUBOID_EDGES[:, 0]], pixels[:, CUBOID_EDGES[:, 1]]
    points = first + share[:, :, :, None] * (second - first)  # 2, h, 12, 3
    points = np.concatenate((pixels, *points), axis=1)
    seen = np.concatenate(((inward > 0.0).all(axis=0), *crosses), axis=1)
    seen &= points[:, :, 2] > MIN_CORNER_DEPTH
    rows = points[:, :, 1] / np.where(seen, points[:, :, 2], 1.0)
    highest = np.where(seen, rows, np.inf).min(axis=1)
    return np.stack((highest, np.where(seen, rows, -np.inf).max(axis=1)), axis=1)


def _whole_boxes(
    states: Float[Array, "h 9"], camera: Camera
) -> tuple[Float[Array, "h 4"], Float[Array, "h 4 9"]]:
    """The boxes around whole cuboids with their Jacobians."""
    h = len(states)
    P = camera.K.dot(camera.T_cam_road[:3])
    size = np.exp(states[:, LOG_SIZE])
    c, s = np.cos(states[:, 3]), np.sin(states[:, 3])
    half_l, half_w = 0.5 * size[:, 0], 0.5 * size[:, 2]
    u, v, w = _corners(states, camera)
    touched = np.stack((u.argmin(0), v.argmin(0), u.argmax(0), v.argmax(0)))  # 4, h
    rows = np.arange(h)
    edges = np.stack(
        (u[touched[0], rows], v[touched[1], rows], u[touched[2], rows], v[touched[3], rows])
    )
    depth = w[touched, rows]  # 4, h
    signs = CORNERS[touched]  # 4, h, 3
    # d edge = (row of P - edge * last row of P) . dX / depth
    row = np.array([0, 1, 0, 1])
    gradient = (P[row, :3][:, None] - edges[:, :, None] * P[2, :3]) / depth[:, :, None]
    g_x, g_y, g_z = gradient[:, :, 0], gradient[:, :, 1], gradient[:, :, 2]
    along = c * g_x - s * g_z
    across = s * g_x + c * g_z
    jacobian = np.zeros((h, 4, STATE_SIZE))
    by_l, by_w = signs[:, :, 0] * half_l, signs[:, :, 2] * half_w
    jacobian[:, :, :3] = gradient.transpose(1, 0, 2)
    jacobian[:, :, 3] = (by_w * along - by_l * across).T
    jacobian[:, :, 5] = (by_l * along).T
    jacobian[:, :, 6] = (signs[:, :, 1] * size[:, 1] * g_y).T
    jacobian[:, :, 7] = (by_w * across).T
    return edges.T, jacobian


def _corners(
    states: Float[Array, "h 9"], camera: Camera
) -> tuple[Float[Array, "8 h"], Float[Array, "8 h"], Float[Array, "8 h"]]:
    """Column, row (px) and depth (m) of the corners of whole cuboids, in the order of CORNERS."""
    P = camera.K.dot(camera.T_cam_road[:3])
    size = np.exp(states[:, LOG_SIZE])
    c, s = np.cos(states[:, 3]), np.sin(states[:, 3])
    # homogeneous pixels: of the base's centre, and what each half axis adds
    centre = states[:, :3].dot(P[:, :3].T) + P[:, 3]
    p_x, p_y, p_z = P[:, 0], P[:, 1], P[:, 2]
    forward = 0.5 * size[:, 0, None] * (c[:, None] * p_x - s[:, None] * p_z)
    left = 0.5 * size[:, 2, None] * (s[:, None] * p_x + c[:, None] * p_z)
    axes = np.stack((forward, size[:, 1, None] * p_y, left))
    corners = CORNERS.dot(axes.reshape(3, -1)).reshape(8, len(states), 3) + centre
    w = np.maximum(corners[:, :, 2], MIN_CORNER_DEPTH)
    return corners[:, :, 0] / w, corners[:, :, 1] / w, w
