"""What is expected of tracks in a frame, and which detections lie in their search areas."""

from math import atan2, inf, nan

import numpy as np

from tracker.kernels.compiling import (
    A1,
    A2,
    A_I1,
    F1,
    F2,
    F3,
    FLOAT,
    INT,
    OUT1,
    OUT2,
    OUT3,
    OUT_I1,
    kernel,
)
from tracker.kernels.lifting import carry_beliefs
from tracker.kernels.pairing import gate
from tracker.kernels.tables import belief_columns, moment_columns


@kernel(F3, FLOAT, F2, OUT3, allocates=False)
def move_covariances(covs, step, noise, covs_now):
    """F P F' + Q of (x, z, velocity x, velocity z), where F moves places by `step` velocities."""
    for car in range(len(covs)):
        cov, now = covs[car], covs_now[car]
        for column in range(4):
            for row in range(2):
                now[row, column] = cov[row, column] + step * cov[row + 2, column]
                now[row + 2, column] = cov[row + 2, column]
        for row in range(4):
            for column in range(2):
                now[row, column] += step * now[row, column + 2]
        for row in range(4):
            for column in range(4):
                now[row, column] += noise[row, column]


@kernel(A2, A2, OUT2, allocates=False)
def multiply(a, b, out):
    """The product of two matrices."""
    for row in range(len(out)):
        for column in range(out.shape[1]):
            total = a[row, 0] * b[0, column]
            for inner in range(1, a.shape[1]):
                total += a[row, inner] * b[inner, column]
            out[row, column] = total


@kernel(A2, A2, A2, A2, A2, OUT1)
def move_road(T_now_before, K, K_inverse, T_cam_road, T_road_cam, motion):
    """What a motion of the camera does to the road frame and to pixels, see `RoadMotion`.

    motion: T_road (4, 4), H (3, 3), shift (3,), by_moved (3, 2), turn, one after the other.
    """
    T_road, H = motion[:16].reshape((4, 4)), motion[16:25].reshape((3, 3))
    between, K_R = np.empty((4, 4)), np.empty((3, 3))
    multiply(T_road_cam, T_now_before, between)
    multiply(between, T_cam_road, T_road)
    multiply(K, T_now_before[:3, :3], K_R)
    multiply(K_R, K_inverse, H)
    multiply(K, T_now_before[:3, 3:], motion[25:28].reshape((3, 1)))
    multiply(K_R, T_cam_road[:3, :3:2], motion[28:34].reshape((3, 2)))
    motion[34] = atan2(T_road[0, 2] - T_road[2, 0], T_road[0, 0] + T_road[2, 2])


@kernel(
    F1, INT, F1, INT, FLOAT, FLOAT, FLOAT, F2, A2, F2, F1, FLOAT, OUT1, OUT_I1
)  # fmt: skip
def expect_tracks(
    floats, n, seen, m, dt, survival, step, noise, T_now_before, motion_cov, lens, sigmas, now,
    pairs,
):  # fmt: skip
    """Packed tracks dt seconds later, and which of the m packed beliefs lie in their search areas.

    It is `move_covariances`, `move_road`, `carry_beliefs`, then `gate` of one drive. survival: the
    probability that a car is still there. lens: see `_lens` of the caller. now: the tracks, without
    scores; their regions as packed cuboids; the search areas; the motion of the road. pairs: the
    rows, then from n * m on the columns. Gives how many pairs there are.
    """
    K, K_inverse = lens[:9].reshape((3, 3)), lens[9:18].reshape((3, 3))
    T_cam_road, T_road_cam = lens[18:34].reshape((4, 4)), lens[34:50].reshape((4, 4))
    road_shift, P = lens[50:98].reshape((4, 12)), lens[98:110].reshape((3, 4))
    signs, far, centre, limits = (
        lens[110:134].reshape((8, 3)),
        lens[134:138],
        lens[138:140],
        lens[140:142],
    )
    base, yaw, size, velocity, cov, boxes = belief_columns(floats, n)
    since, existence, innovations, _ = moment_columns(floats, n)
    base_now, yaw_now, size_now, velocity_now, cov_now, boxes_now = belief_columns(now, n)
    since_now, existence_now, innovations_now, scores = moment_columns(now, n)
    motion = now[47 * n : 47 * n + 35]
    move_road(T_now_before, K, K_inverse, T_cam_road, T_road_cam, motion)
    moved, later = np.empty((n, 2)), np.empty((n, 4, 4))
    move_covariances(cov, step, noise, later)
    for row in range(n):
        for axis in range(2):
            moved[row, axis] = velocity[row, axis] * step
        for axis in range(3):
            size_now[row, axis] = size[row, axis]
        for side in range(4):
            innovations_now[row, side] = innovations[row, side]
        yaw_now[row] = yaw[row] + motion[34]
        since_now[row], existence_now[row] = since[row] + dt, existence[row] * survival
        scores[row] = nan
    carry_beliefs(
        base, size, velocity, later, boxes, moved, motion[:16].reshape((4, 4)), road_shift,
        motion_cov, T_cam_road[2], motion[16:25].reshape((3, 3)), motion[25:28],
        motion[28:34].reshape((3, 2)), limits, base_now, velocity_now, cov_now, boxes_now,
    )  # fmt: skip
    for number in range(4 * n):  # place and yaw of the regions
        now[36 * n + number] = now[number]
    starts, seen_starts = np.empty(2, np.int64), np.empty(2, np.int64)
    starts[0], seen_starts[0], starts[1], seen_starts[1] = 0, 0, n, m
    return gate(
        base_now, yaw_now, size, cov_now, sigmas, P, centre, far, signs, lens[142], lens[143],
        seen[25 * m : 29 * m].reshape((m, 4)), starts, seen_starts,
        now[40 * n : 43 * n].reshape((n, 3)), now[43 * n : 47 * n].reshape((n, 4)),
        pairs[: n * m], pairs[n * m :],
    )  # fmt: skip


@kernel(A_I1, A_I1, A1, OUT2, allocates=False)
def place_costs(rows, columns, costs, matrix):
    """The matrix with these costs in these places, and inf in all others."""
    for row in range(len(matrix)):
        for column in range(matrix.shape[1]):
            matrix[row, column] = inf
    for pair in range(len(rows)):
        matrix[rows[pair], columns[pair]] = costs[pair]
