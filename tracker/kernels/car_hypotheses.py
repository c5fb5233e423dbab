"""What the hypotheses of cars say together: weights, the likeliest state, parked or moving."""

from math import cos, erfc, exp, inf, log, pi, sin, sqrt

import numpy as np

from tracker.kernels.compiling import (
    F1,
    F2,
    F3,
    F4,
    FLOAT,
    OUT1,
    OUT2,
    OUT3,
    OUT4,
    OUT_I2,
    inlined,
    inlined_with_arrays,
    kernel,
)  # fmt: skip

YAW, SPEED, LOG_HEIGHT, YAW_RATE = 3, 4, 6, 8


@inlined
def normalise(log_weights):
    """Shift the logarithms of weights so that these sum up to 1."""
    highest, total = -inf, 0.0
    for column in range(len(log_weights)):
        highest = max(highest, log_weights[column])
    for column in range(len(log_weights)):
        log_weights[column] -= highest
        total += exp(log_weights[column])
    for column in range(len(log_weights)):
        log_weights[column] -= log(total)


@inlined
def strip_of(x, borders):
    """The strip of the road at x."""
    strip = 0
    while strip < len(borders) and borders[strip] < x:
        strip += 1
    return strip


@kernel(F3, F2, F3, F2, F1, F1, FLOAT, FLOAT, OUT2, allocates=False)
def weigh_directions(
    means, log_weights, shares, traffic, borders, middle, concentration, prior, weights
):
    """Probabilities (n, k) of hypotheses by their headings as well, see `DirectionPrior`."""
    for car in range(len(means)):
        total = 0.0
        for which in range(means.shape[1]):
            weights[car, which] = 0.0
            if log_weights[car, which] == -inf:
                continue
            x, ahead = means[car, which, 0], -sin(means[car, which, YAW])
            aside = min(max((abs(x) - middle[0]) / (middle[1] - middle[0]), 0.0), 1.0)
            there = 1 if x < 0.0 else 2
            same = shares[0, which, 0] + aside * (shares[there, which, 0] - shares[0, which, 0])
            back = shares[0, which, 1] + aside * (shares[there, which, 1] - shares[0, which, 1])
            both, strip = same + back, strip_of(x, borders)
            share = prior * same / both + traffic[strip, 0]
            share /= prior + (traffic[strip, 0] + traffic[strip, 1])
            # densities of its directions, over the uniform one
            peak = sqrt(2.0 * pi * concentration) * both
            way, other = exp(concentration * (ahead - 1.0)), exp(concentration * (-ahead - 1.0))
            density = peak * (share * way + (1.0 - share) * other) + (1.0 - both)
            weights[car, which] = exp(log_weights[car, which]) * density
            total += weights[car, which]
        for which in range(means.shape[1]):
            weights[car, which] /= total


@inlined
def likeliest(means, weights, ways, alike, cos_same, min_weight):
    """The likeliest hypothesis of the likeliest direction; how probable its side is.

    alike: of all hypotheses whether they face as it does.
    """
    count, best, most = len(weights), 0, 0.0
    for which in range(count):
        ways[which, 0], ways[which, 1] = cos(means[which, YAW]), sin(means[which, YAW])
    for which in range(count):
        if weights[which] > min_weight:
            votes = 1e-3 * weights[which]
            for other in range(count):
                cosine = ways[which, 0] * ways[other, 0] + ways[which, 1] * ways[other, 1]
                if cosine > cos_same:
                    votes += weights[other]
            if votes > most:
                best, most = which, votes
    known = 0.0
    for other in range(count):
        cosine = ways[best, 0] * ways[other, 0] + ways[best, 1] * ways[other, 1]
        alike[other] = cosine > cos_same
        if cosine > 0.0:
            known += weights[other]
    return best, known


@inlined_with_arrays
def room_to_estimate(count):
    """Arrays that `estimate_in_room` writes to, for cars with so many hypotheses."""
    ways, off = np.empty((count, 2)), np.empty((count, 9))
    return ways, np.empty(count, np.bool_), off, np.empty(count), np.empty(9)


@inlined
def estimate_in_room(means, covs, weights, cos_same, min_weight, means_out, covs_out, known, room):
    """What `estimate_cars` does."""
    count, (ways, alike, off, shares, shift) = means.shape[1], room
    covs, covs_out = covs.reshape(len(means), count, 81), covs_out.reshape(len(means), 81)
    for car in range(len(means)):
        best, known[car] = likeliest(means[car], weights[car], ways, alike, cos_same, min_weight)
        total, shift[:] = 0.0, 0.0
        for which in range(count):
            shares[which] = weights[car, which] if alike[which] else 0.0
            shares[which] = shares[which] if weights[car, which] > min_weight else 0.0
            total += shares[which]
            for column in range(9):
                off[which, column] = means[car, which, column] - means[car, best, column]
            off[which, YAW] = (off[which, YAW] + pi) % (2.0 * pi) - pi
        for which in range(count):
            if alike[which]:
                for column in range(9):
                    shift[column] += shares[which] / total * off[which, column]
        total = 0.0
        for which in range(count):
            for column in range(9):
                off[which, column] -= shift[column]
            is_near = abs(off[which, YAW]) < 0.5 * pi and weights[car, which] > min_weight
            shares[which] = weights[car, which] if is_near else 0.0
            total += shares[which]
        for row in range(9):
            means_out[car, row] = means[car, best, row] + shift[row]
            for column in range(9):
                covs_out[car, 9 * row + column] = 0.0
        for which in range(count):
            share = shares[which] / total
            if share > 0.0:
                cov, out, spread = covs[car, which], covs_out[car], shift  # no longer needed
                for row in range(9):
                    spread[row] = share * off[which, row]
                for column in range(means.shape[2]):
                    beside = off[which, column]
                    for row in range(9):
                        out[9 * row + column] += (
                            share * cov[9 * row + column] + spread[row] * beside
                        )


@kernel(F3, F4, F2, FLOAT, FLOAT, OUT2, OUT3, OUT1)
def estimate_cars(means, covs, weights, cos_same, min_weight, means_out, covs_out, known):
    """One state per car out of its hypotheses (n, k, 9), see `estimate`."""
    room = room_to_estimate(means.shape[1])
    estimate_in_room(means, covs, weights, cos_same, min_weight, means_out, covs_out, known, room)


@kernel(F2, F3, FLOAT, FLOAT, FLOAT, F2, OUT3, allocates=False)
def state_covariances(means, covs, factor, yaw_std, speed_std, own, stated):
    """Covariances (n, 9, 9) as rows state them. own: of the camera's velocity (2, 2)."""
    for car in range(len(means)):
        for row in range(9):
            for column in range(9):
                stated[car, row, column] = factor * covs[car, row, column]
        x, z = cos(means[car, YAW]), -sin(means[car, YAW])
        stated[car, YAW, YAW] += yaw_std**2
        stated[car, SPEED, SPEED] += speed_std**2
        stated[car, SPEED, SPEED] += own[0, 0] * x * x + 2.0 * own[0, 1] * x * z + own[1, 1] * z * z


@inlined
def begin_again(mean, cov, source, target, var):
    """A mode out of the other one: a car that stands, so far."""
    for row in range(9):
        mean[target, row] = mean[source, row]
        for column in range(9):
            cov[target, row, column] = cov[source, row, column]
    for fixed in (SPEED, YAW_RATE):
        mean[target, fixed] = 0.0
        for column in range(9):
            cov[target, fixed, column] = cov[target, column, fixed] = 0.0
    cov[target, SPEED, SPEED] = var


@inlined
def log_forward(speed, var):
    """Log-probability that a car which seems to drive backwards does not."""
    deviation = speed / sqrt(max(var, 1e-9))
    if deviation > -30.0:
        return log(0.5 * erfc(-deviation * sqrt(0.5)))
    # the first terms of the series: erfc is 0 farther out
    square = 1.0 / (deviation * deviation)
    tail = 1.0 - square * (1.0 - 3.0 * square * (1.0 - 5.0 * square))
    return -0.5 * deviation * deviation - log(-deviation * sqrt(2.0 * pi)) + log(tail)


@inlined
def switch_modes(means, covs, weights, begin, limits, starting_var, parents):
    """Let modes of a car that have died out begin again, in place, see `weigh_cars`."""
    half, changed = len(weights) // 2, False
    for parked in range(half):
        moving = parked + half
        parents[parked], parents[moving] = parked, moving
        if weights[parked] < weights[moving] + begin - limits[0]:
            stops = weights[moving] > limits[1] and means[moving, SPEED] < limits[2]
            source, target, var = (moving if stops else -1), parked, 0.0
        elif weights[moving] < weights[parked] + begin - limits[0]:
            starts = weights[parked] > limits[1]
            source, target, var = (parked if starts else -1), moving, starting_var
        else:
            continue
        if source >= 0:
            begin_again(means, covs, source, target, var)
            weights[target] = weights[source] + begin
            parents[target], changed = source, True
    if changed:
        normalise(weights)


@kernel(OUT3, OUT4, F2, FLOAT, F2, F2, FLOAT, FLOAT, F1, FLOAT, OUT2, OUT_I2, allocates=False)
def weigh_cars(
    means, covs, before, min_log_weight, fits, told, evidence, begin, limits, starting_var,
    log_weights, parents,
):  # fmt: skip
    """Logarithms of the weights of hypotheses after their boxes, and their parents.

    means, covs: after the boxes, changed in place: no car drives backwards, and modes that have
    died out begin again, see `weighed`. before: the logarithms before the boxes. fits, told: what
    boxes and cues count for. limits: nats of dead modes, the least log-weight of the other one,
    the speed of parking cars.
    """
    for car in range(len(means)):
        for which in range(means.shape[1]):
            log_weights[car, which] = -inf
            if before[car, which] > min_log_weight:
                fit, speed = fits[car, which], means[car, which, SPEED]
                if speed < 0.0:
                    fit += log_forward(speed, covs[car, which, SPEED, SPEED])
                    means[car, which, SPEED] = 0.0
                log_weights[car, which] = before[car, which] + evidence * fit + told[car, which]
        weights = log_weights[car]
        normalise(weights)
        switch_modes(means[car], covs[car], weights, begin, limits, starting_var, parents[car])


@kernel(F3, F2, F1, FLOAT, FLOAT, FLOAT, OUT2, allocates=False)
def watch_traffic(means, log_weights, borders, min_speed, min_probability, dt, traffic):
    """Add the seconds of traffic, the camera's way and oncoming, of cars that move for certain."""
    count = means.shape[1]
    for car in range(len(means)):
        total = aside = same = oncoming = 0.0
        for which in range(count // 2, count):
            if means[car, which, SPEED] > min_speed:
                weight, ahead = exp(log_weights[car, which]), -sin(means[car, which, YAW])
                total += weight
                aside += weight * means[car, which, 0]
                same += weight if ahead > 0.7 else 0.0
                oncoming += weight if ahead < -0.7 else 0.0
        if total > min_probability:
            strip = strip_of(aside, borders)
            traffic[strip, 0] += dt * same
            traffic[strip, 1] += dt * oncoming


@kernel(F3, F2, OUT1, allocates=False)
def believe_heights(means, log_weights, heights):
    """Heights (n,) of cars by the expected logarithm, m."""
    for car in range(len(means)):
        expected = 0.0
        for which in range(means.shape[1]):
            expected += exp(log_weights[car, which]) * means[car, which, LOG_HEIGHT]
        heights[car] = exp(expected)
