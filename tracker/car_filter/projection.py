"""The box that a car fills in the image, with its derivatives by the state."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.car_filter.states import LOG_SIZE, STATE_SIZE
from tracker.types import Camera
from tracker.types.cuboids import CORNERS

# Corners nearer to the camera than this are taken to be this far, m.
MIN_CORNER_DEPTH = 0.5


def project_boxes(
    states: Float[Array, "h 8"], camera: Camera
) -> tuple[Float[Array, "h 4"], Float[Array, "h 4 8"]]:
    """The upright boxes around projected cuboids (x_min, y_min, x_max, y_max, px), not clipped.

    And their Jacobians: each edge is that of the corner which it touches.
    """
    h = len(states)
    P = camera.K.dot(camera.T_cam_road[:3])
    size = np.exp(states[:, LOG_SIZE])
    c, s = np.cos(states[:, 3]), np.sin(states[:, 3])
    half_l, half_w = 0.5 * size[:, 0], 0.5 * size[:, 2]
    # homogeneous pixels: of the base's centre, and what each half axis adds
    centre = states[:, :3].dot(P[:, :3].T) + P[:, 3]
    p_x, p_y, p_z = P[:, 0], P[:, 1], P[:, 2]
    ahead = c[:, None] * p_x - s[:, None] * p_z
    aside = s[:, None] * p_x + c[:, None] * p_z
    forward, left = half_l[:, None] * ahead, half_w[:, None] * aside
    down = size[:, 1, None] * p_y
    axes = np.stack((forward, down, left))
    corners = CORNERS.dot(axes.reshape(3, -1)).reshape(8, h, 3) + centre
    w = np.maximum(corners[:, :, 2], MIN_CORNER_DEPTH)
    u, v = corners[:, :, 0] / w, corners[:, :, 1] / w
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
