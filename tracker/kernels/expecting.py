"""What is expected of tracks in a frame, and which detections lie in their search areas."""

from math import nan

import numpy as np

from tracker.kernels.compiling import (
    A1,
    A2,
    F1,
    F2,
    F3,
    FLOAT,
    OUT1,
    OUT2,
    OUT3,
    OUT_I1,
    kernel,
)
from tracker.kernels.lifting import carry_beliefs
from tracker.kernels.pairing import gate


@kernel(
    A2, A1, A2, A2, F3, A2, A2, F1, F1, FLOAT, FLOAT, F2, FLOAT, F2, F1, F2, F2, A2, A1, F2,
    F1, F1, F2, F1, FLOAT, FLOAT, FLOAT, A2, OUT2, OUT1, OUT2, OUT3, OUT2, OUT1, OUT1, OUT1, OUT2,
    OUT2, OUT_I1, OUT_I1,
)  # fmt: skip
def expect_tracks(
    base, yaw, size, velocity, covs, boxes, moved, since, existence, dt, survival, T_road, turn, H,
    shift, by_moved, road_shift, motion_cov, depth_of, P, centre, far, signs, limits, sigmas,
    min_corner_depth, min_depth, seen, base_now, yaw_now, velocity_now, covs_now, boxes_now,
    since_now, existence_now, scores, stretched, areas, rows, columns,
):  # fmt: skip
    """`carry_beliefs`, then `gate` of one drive; how many pairs there are.

    since_now, existence_now: dt seconds later; scores: NaN, nothing is detected yet.
    """
    carry_beliefs(
        base, size, velocity, covs, boxes, moved, T_road, road_shift, motion_cov, depth_of, H,
        shift, by_moved, limits, base_now, velocity_now, covs_now, boxes_now,
    )  # fmt: skip
    for row in range(len(yaw)):
        yaw_now[row] = yaw[row] + turn
        since_now[row] = since[row] + dt
        existence_now[row] = existence[row] * survival
        scores[row] = nan
    starts, seen_starts = np.zeros(2, np.int64), np.zeros(2, np.int64)
    starts[1], seen_starts[1] = len(base), len(seen)
    return gate(
        base_now, yaw_now, size, covs_now, sigmas, P, centre, far, signs, min_corner_depth,
        min_depth, seen, starts, seen_starts, stretched, areas, rows, columns,
    )  # fmt: skip
