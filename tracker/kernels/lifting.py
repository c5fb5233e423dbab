"""Boxes back-projected to the road, eq. 2, and beliefs carried to another frame of the camera."""

from math import inf, nan

import numpy as np

from tracker.kernels.compiling import (
    A1,
    A2,
    BOOL,
    F1,
    F2,
    F3,
    FLOAT,
    OUT1,
    OUT2,
    OUT3,
    inlined,
    kernel,
)
from tracker.kernels.tables import belief_columns


@inlined
def touch(ray, height, per_pixel, sigma, height_std, pitch_std, min_dip, cov):
    """Reach along a ray to the road; the covariance of the contact's x and z into `cov`."""
    dip = ray[1] if ray[1] > min_dip else nan
    contact_y, contact_z = ray[1] * (height / dip), ray[2] * (height / dip)
    near = contact_y / ray[1]
    for row in range(2):
        for column in range(2):
            cov[row, column] = 0.0
    x, z = ray[0] * (height / dip) / contact_y, contact_z / contact_y  # per metre of height
    for pixel in range(2):
        by_x = sigma * near * (per_pixel[pixel, 0] - x * per_pixel[pixel, 1])
        by_z = sigma * near * (per_pixel[pixel, 2] - z * per_pixel[pixel, 1])
        add_square(cov, by_x, by_z)
    add_square(cov, height_std * x, height_std * z)
    add_square(cov, pitch_std * (x * contact_z), pitch_std * (z * contact_z + contact_y))
    return near


@inlined
def add_square(cov, x, z):
    """Add the covariance of an error that shifts so."""
    cov[0, 0] += x * x
    cov[0, 1] += x * z
    cov[1, 0] += z * x
    cov[1, 1] += z * z


@kernel(A2, A1, A1, A2, A1, F2, F1, FLOAT, FLOAT, FLOAT, F1, F1, F1, BOOL, OUT1)
def lift_boxes(
    boxes, scores, yaws, sizes, behind, per_pixel, at_origin, height, focal, lowest, stds,
    speed_std, limits, use_box_height, beliefs,
):  # fmt: skip
    """Packed beliefs of boxes on the road, see `Lift`.

    yaws, sizes, behind: one for all, or one a box. lowest: rows from which the border cuts boxes.
    stds: of edges, height, pitch, sizes. limits: of the dip of rays, and of depths.
    """
    ray, cov, gain = np.empty(3), np.empty((2, 2)), np.empty(2)
    base, yaw, size, velocity, covs, own_boxes = belief_columns(beliefs, len(boxes))
    for car in range(len(boxes)):
        stance = car if len(yaws) > 1 else 0
        yaw[car], velocity[car, 0], velocity[car, 1] = yaws[stance], 0.0, 0.0
        for axis in range(3):
            size[car, axis] = sizes[stance, axis]
        for side in range(4):
            own_boxes[car, side] = boxes[car, side]
        u, v = 0.5 * boxes[car, 0] + 0.5 * boxes[car, 2], boxes[car, 3]
        for axis in range(3):
            ray[axis] = u * per_pixel[0, axis] + v * per_pixel[1, axis] + at_origin[axis]
        tall = max(boxes[car, 3] - boxes[car, 1], 1.0)
        relative_std = stds[0] * (2.0 - min(max(scores[car], 0.0), 1.0))
        sigma = relative_std * tall
        near = touch(ray, height, per_pixel, sigma, stds[1], stds[2], limits[0], cov)
        by_height, is_cut = focal * sizes[stance, 1] / tall, boxes[car, 3] >= lowest
        if is_cut or not near < limits[2]:  # no contact with the road
            near = by_height if not near < by_height else near
            near = min(max(near, limits[1]), limits[2])
            for row in range(2):
                for column in range(2):
                    cov[row, column] = 1.0 if row == column else 0.0
            add_square(cov, ray[0] * (0.5 * near), ray[2] * (0.5 * near))
        if use_box_height:
            var = by_height**2 * (2.0 * relative_std**2 + stds[3] ** 2)  # two edges
            var = inf if is_cut else var
            gain[0], gain[1] = cov[0, 1] / (cov[1, 1] + var), cov[1, 1] / (cov[1, 1] + var)
            near += gain[1] * (by_height - near)
            along, across = cov[1, 0], cov[1, 1]
            for row in range(2):
                cov[row, 0] -= gain[row] * along
                cov[row, 1] -= gain[row] * across
        far = near + behind[stance]
        base[car, 0], base[car, 2] = ray[0] * far, ray[2] * far
        base[car, 1] = ray[1] * near - height
        for row in range(4):
            for column in range(4):
                covs[car, row, column] = 0.0
            for column in range(2):
                if row < 2:
                    covs[car, row, column] = cov[row, column]
        covs[car, 2, 2], covs[car, 3, 3] = speed_std[0] ** 2, speed_std[1] ** 2


@inlined
def turn_covariance(cov, R, out):
    """R B R' of each 2 x 2 block B."""
    for top in range(0, 4, 2):
        for left in range(0, 4, 2):
            for row in range(2):
                for column in range(2):
                    total = 0.0
                    for inner in range(2):
                        turned = 0.0
                        for first in range(2):
                            turned += R[2 * row, 2 * first] * cov[top + first, left + inner]
                        total += turned * R[2 * column, 2 * inner]
                    out[top + row, left + column] = total


@inlined
def add_motion(place, shift, motion_cov, jacobian, cov):
    """Add what an uncertain motion of the camera does to x and z of a place: J C J'."""
    for entry in range(12):
        jacobian[entry] = (
            place[0] * shift[0, entry] + place[1] * shift[1, entry] + place[2] * shift[2, entry]
        ) + shift[3, entry]
    for row in range(2):
        for column in range(6):
            moved = 0.0
            for inner in range(6):
                moved += jacobian[6 * row + inner] * motion_cov[inner, column]
            for other in range(2):
                cov[row, other] += moved * jacobian[6 * other + column]


@kernel(A2, A2, A2, F3, A2, A2, F2, F2, A2, A1, F2, F1, F2, F1, OUT2, OUT2, OUT3, OUT2)
def carry_beliefs(
    base, size, velocity, covs, boxes, moved, T_road, road_shift, motion_cov, depth_of,
    H, shift, by_moved, limits, base_now, velocity_now, covs_now, boxes_now,
):  # fmt: skip
    """Places, velocities, covariances and boxes in the camera's frame of now.

    depth_of: (4,) gives the depth of a point of the road frame. H, shift, by_moved: move pixels at
    infinity, at depth 1, and by a metre of the object itself. limits: least depth and scale.
    """
    jacobian, at = np.empty(12), np.empty(3)
    for car in range(len(base)):
        x, y, z = base[car, 0], base[car, 1], base[car, 2]
        depth = x * depth_of[0] + y * depth_of[1] + z * depth_of[2] + depth_of[3]
        depth = max(depth - 0.25 * size[car, 0], limits[0])
        for row in range(3):
            by_car = moved[car, 0] * by_moved[row, 0] + moved[car, 1] * by_moved[row, 1]
            at[row] = (shift[row] + by_car) / depth
        for corner in range(0, 4, 2):
            u, v = boxes[car, corner], boxes[car, corner + 1]
            scale = max(u * H[2, 0] + v * H[2, 1] + H[2, 2] + at[2], limits[1])
            for row in range(2):
                pixel = u * H[row, 0] + v * H[row, 1] + H[row, 2] + at[row]
                boxes_now[car, corner + row] = pixel / scale
        x, z = x + moved[car, 0], z + moved[car, 1]
        for row in range(3):
            turned = x * T_road[row, 0] + y * T_road[row, 1] + z * T_road[row, 2]
            base_now[car, row] = turned + T_road[row, 3]
        for row in range(2):
            velocity_now[car, row] = (
                velocity[car, 0] * T_road[2 * row, 0] + velocity[car, 1] * T_road[2 * row, 2]
            )
        turn_covariance(covs[car], T_road, covs_now[car])
        add_motion(base_now[car], road_shift, motion_cov, jacobian, covs_now[car])


@kernel(A2, A2, F3, A2, F3, OUT2, OUT2, OUT3)
def correct_places(base, velocity, covs, seen, seen_covs, base_out, velocity_out, covs_out):
    """The Kalman update of (x, z, velocity x, velocity z) by seen places (n, 3)."""
    gain = np.empty((4, 2))
    for car in range(len(base)):
        cov = covs[car]
        a, b = cov[0, 0] + seen_covs[car, 0, 0], cov[0, 1] + seen_covs[car, 0, 1]
        c, d = cov[1, 0] + seen_covs[car, 1, 0], cov[1, 1] + seen_covs[car, 1, 1]
        scale = a * d - b * c
        x, z = seen[car, 0] - base[car, 0], seen[car, 2] - base[car, 2]
        for row in range(4):
            gain[row, 0] = cov[row, 0] * (d / scale) + cov[row, 1] * (-c / scale)
            gain[row, 1] = cov[row, 0] * (-b / scale) + cov[row, 1] * (a / scale)
            for column in range(4):
                covs_out[car, row, column] = cov[row, column] - (
                    gain[row, 0] * cov[0, column] + gain[row, 1] * cov[1, column]
                )
        base_out[car, 0] = base[car, 0] + (gain[0, 0] * x + gain[0, 1] * z)
        base_out[car, 1] = seen[car, 1]
        base_out[car, 2] = base[car, 2] + (gain[1, 0] * x + gain[1, 1] * z)
        for row in range(2):
            velocity_out[car, row] = velocity[car, row] + (
                gain[2 + row, 0] * x + gain[2 + row, 1] * z
            )
