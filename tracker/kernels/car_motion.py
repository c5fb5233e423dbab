"""How cars move between two frames: their states, and the covariances of these."""

from math import cos, exp, sin, sqrt

import numpy as np

from tracker.kernels.compiling import (
    A2,
    F1,
    F2,
    F3,
    F4,
    FLOAT,
    OUT2,
    OUT3,
    OUT4,
    inlined,
    inlined_with_arrays,
    kernel,
)  # fmt: skip


@inlined
def put_moved(state, T_road, step, rates, log_size, later):
    """A state after a step, in the road frame of then.

    step: turn, dt, the road's slope before and now. rates: turn, off-road and size time.
    """
    turn, dt, slope_before, slope_now = step[0], step[1], step[2], step[3]
    way = state[3] + 0.5 * dt * state[8]  # halfway
    distance = dt * state[4]
    x, y, z = state[0] + distance * cos(way), state[1], state[2] - distance * sin(way)
    for row in range(3):
        later[row] = T_road[row, 0] * x + T_road[row, 1] * y + T_road[row, 2] * z + T_road[row, 3]
    later[3] = state[3] + (turn + dt * state[8])
    later[4] = state[4]
    later[8] = state[8] * exp(-dt / rates[0])
    reach = sqrt(later[0] ** 2 + later[2] ** 2)
    later[1] = (later[1] - slope_before * reach) * exp(-dt / rates[1]) + slope_now * reach
    kept = exp(-dt / rates[2])
    for side in range(3):
        later[5 + side] = (state[5 + side] - log_size[side]) * kept + log_size[side]
    return reach


@inlined
def step_rows(cov, T_road, by_turn, by_pace, dt, kept, count, out):
    """Rows of a covariance (81,) after driving, and by what is the same for all cars: F P.

    x and z take of yaw, yaw rate and speed. One loop over flat arrays, whose end the compiler does
    not know, is one that it works off several columns at a time.
    """
    a, b, c = T_road[0, 0], T_road[0, 1], T_road[0, 2]
    d, e, f = kept[1] * T_road[1, 0], kept[1] * T_road[1, 1], kept[1] * T_road[1, 2]
    g, h, i = T_road[2, 0], T_road[2, 1], T_road[2, 2]
    for at in range(count):
        yaw, pace, rate = cov[27 + at], cov[36 + at], cov[72 + at]
        turning = yaw + 0.5 * dt * rate
        x = cov[at] + (by_turn[0] * turning + by_pace[0] * pace)
        y = cov[9 + at]
        z = cov[18 + at] + (by_turn[1] * turning + by_pace[1] * pace)
        out[at] = a * x + b * y + c * z
        out[9 + at] = d * x + e * y + f * z
        out[18 + at] = g * x + h * y + i * z
        out[27 + at] = yaw + dt * rate
        out[36 + at] = pace
        out[45 + at] = kept[2] * cov[45 + at]
        out[54 + at] = kept[2] * cov[54 + at]
        out[63 + at] = kept[2] * cov[63 + at]
        out[72 + at] = kept[0] * rate


@inlined
def transpose(square, out):
    """The transposed matrix, both (81,)."""
    for row in range(9):
        for column in range(9):
            out[9 * row + column] = square[9 * column + row]


@kernel(F2, F2, F1, F1, F1, OUT2, allocates=False)
def moved(states, T_road, step, rates, log_size, later):
    """States (h, 9) after a step."""
    for car in range(len(states)):
        put_moved(states[car], T_road, step, rates, log_size, later[car])


@inlined
def copy_hypothesis(mean, cov, mean_out, cov_out):
    """The same state and covariance (81,)."""
    for row in range(9):
        mean_out[row] = mean[row]
    for entry in range(len(cov)):
        cov_out[entry] = cov[entry]


@inlined
def add_noise(cov, pace, reach, is_moving, dt, new, noise, off_road, log_size_cov):
    """Add to a covariance (81,) what changes at random in a step.

    new: shares of yaw rate, road, size.
    """
    cov[0] += noise[0] * dt
    cov[20] += noise[0] * dt
    cov[10] += new[1] * off_road[2] * (off_road[0] + off_road[1] * reach) ** 2
    if is_moving:
        cov[30] += noise[1] * dt * pace
        cov[80] += new[0] * noise[2] * pace
        cov[40] += noise[3] * dt
    else:
        cov[30] += noise[4] * dt
    for side in range(3):
        for beside in range(3):
            cov[50 + 9 * side + beside] += new[2] * log_size_cov[side, beside]


@inlined
def add_ego_motion(state, place_shift, motion_cov, jacobian, cov):
    """Add what an uncertain motion of the camera does to the place and the yaw: J C J'."""
    for row in range(3):
        for column in range(6):
            entry, by_place = 6 * row + column, 0.0
            for axis in range(3):
                by_place += state[axis] * place_shift[axis, entry]
            jacobian[row, column] = by_place + place_shift[3, entry]
    for row in range(3):
        for column in range(6):
            moved = 0.0
            for inner in range(6):
                moved += jacobian[row, inner] * motion_cov[inner, column]
            for other in range(3):
                cov[9 * row + other] += moved * jacobian[other, column]
    cov[30] += motion_cov[4, 4]


@inlined
def kept_in(dt, rates):
    """What is kept of yaw rate, height off the road and size in a step."""
    return exp(-dt / rates[0]), exp(-dt / rates[1]), exp(-dt / rates[2])


@inlined
def predict_hypothesis(state, cov, is_moving, shared, ego, scratch, later, cov_out):
    """A hypothesis after a step; it may be written where it is read.

    cov: (81,). shared: as `predict_cars` has it. ego: what the camera's motion does to places, its
    covariance.
    """
    T_road, step, rates, kept, noise, off_road, log_size, log_size_cov = shared
    jacobian, one, other = scratch
    dt, count = step[1], len(state)
    new = 1.0 - kept[0] ** 2, 1.0 - kept[1] ** 2, 1.0 - kept[2] ** 2
    way = state[3] + 0.5 * dt * state[8]
    c, s, distance = cos(way), sin(way), dt * state[4]
    by_turn, by_pace = (-s * distance, -c * distance), (dt * c, -dt * s)
    # F P F' in two parts, from either side
    step_rows(cov, T_road, by_turn, by_pace, dt, kept, count, one)
    transpose(one, other)
    step_rows(other, T_road, by_turn, by_pace, dt, kept, count, cov_out)
    reach = put_moved(state, T_road, step, rates, log_size, later)
    pace = min(1.0, later[4] / noise[5] + noise[6])
    add_noise(cov_out, pace, reach, is_moving, dt, new, noise, off_road, log_size_cov)
    add_ego_motion(later, ego[0], ego[1], jacobian, cov_out)


@inlined_with_arrays
def room_to_predict():
    """Arrays that `predict_hypothesis` writes to, made once for many hypotheses."""
    return np.empty((3, 6)), np.empty(81), np.empty(81)


@inlined
def predict_in_room(
    means, covs, log_weights, min_log_weight, T_road, step, rates, noise, off_road, log_size,
    log_size_cov, place_shift, motion_cov, means_out, covs_out, room,
):  # fmt: skip
    """What `predict_cars` does."""
    kept, half = kept_in(step[1], rates), means.shape[1] // 2
    shared = T_road, step, rates, kept, noise, off_road, log_size, log_size_cov
    flat = len(means), means.shape[1], 81
    covs, covs_out = covs.reshape(flat), covs_out.reshape(flat)
    for car in range(len(means)):
        for which in range(means.shape[1]):
            state, cov = means[car, which], covs[car, which]
            later, cov_out = means_out[car, which], covs_out[car, which]
            if log_weights[car, which] > min_log_weight:
                is_moving, ego = which >= half, (place_shift, motion_cov)
                predict_hypothesis(state, cov, is_moving, shared, ego, room, later, cov_out)
            else:
                copy_hypothesis(state, cov, later, cov_out)


@kernel(F3, F4, F2, FLOAT, F2, F1, F1, F1, F1, F1, F2, F2, A2, OUT3, OUT4)
def predict_cars(
    means, covs, log_weights, min_log_weight, T_road, step, rates, noise, off_road, log_size,
    log_size_cov, place_shift, motion_cov, means_out, covs_out,
):  # fmt: skip
    """Hypotheses (n, k, 9) and covariances after a step; those not followed stay as they are.

    The second half of a car's hypotheses moves. noise: variances in a second of drift, heading, yaw
    rate, speed, heading of parked cars; the speed below which cars turn less, and their share then.
    off_road: std at the camera, per metre, and the road's roughness.
    """
    predict_in_room(
        means, covs, log_weights, min_log_weight, T_road, step, rates, noise, off_road, log_size,
        log_size_cov, place_shift, motion_cov, means_out, covs_out, room_to_predict(),
    )  # fmt: skip
