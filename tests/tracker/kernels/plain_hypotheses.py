"""Hypotheses of cars, edges and road in plain NumPy: what the kernels must equal."""

import math

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import log_ndtr

from tracker.beliefs import BOTTOM_CENTRE
from tracker.car_filter import (
    CarFilter,
    CarStates,
    DirectionPrior,
    EdgeModel,
    RoadMemory,
    RoadModel,
    border_gaps,
)
from tracker.car_filter.edges import HIDING_MARGIN, MIN_HIDDEN_SHARE, MIN_LOWER, OUTWARD
from tracker.car_filter.estimates import COS_SAME_DIRECTION, MIN_WEIGHT
from tracker.car_filter.modes import (
    DEAD_NATS,
    MAX_PARKING_SPEED,
    MIN_SWITCH_LOG_WEIGHT,
    STARTING_SPEED_STD,
)
from tracker.car_filter.road_memory import (
    BASE_STD,
    MIDDLE,
    MIN_BORDER_GAP,
    MIN_MOVING_PROBABILITY,
    MIN_SLOPE_DISTANCE,
    MIN_SLOPE_SCORE,
    MIN_TRAFFIC_SPEED,
    STRIP_BORDERS,
    SeenBases,
)
from tracker.car_filter.roughness import MAX_OFF_ROAD, RoughnessModel
from tracker.car_filter.states import (
    HEADING_COUNT,
    HYPOTHESIS_COUNT,
    LOG_HEIGHT,
    MIN_LOG_WEIGHT,
    MOVING,
    PARKED,
    SPEED,
    YAW,
    YAW_RATE,
    normalised,
)
from tracker.geometry import wrap_angle
from tracker.types import Camera, CarEstimates


def plain_unbiased(self: EdgeModel, boxes: Float[Array, "n 4"]) -> Float[Array, "n 4"]:
    """Boxes without the detector's bias."""
    return boxes - np.array(self.bias) * (boxes[:, 3:] - boxes[:, 1:2])


def plain_variances(
    self: EdgeModel,
    boxes: Float[Array, "n 4"],
    scores: Float[Array, " n"],
    hidden: Bool[Array, "n 4"],
) -> Float[Array, "n 4"]:
    """Of the edges of boxes, px^2."""
    heights = np.maximum(boxes[:, 3] - boxes[:, 1], 1.0)
    std = self.edge_std * heights * (2.0 - np.minimum(np.maximum(scores, 0.0), 1.0))
    factors = np.where(hidden, np.square(self.hidden_factors), 1.0)
    return (std**2 + self.pixel_std**2)[:, None] * factors


def plain_censored(
    self: EdgeModel, boxes: Float[Array, "h 4"], expected: Float[Array, "h 4"], camera: Camera
) -> Bool[Array, "h 4"]:
    """Which edges the image's border may have cut: the car is expected to go on beyond."""
    return (border_gaps(boxes, camera) < self.border) & ((expected - boxes) * OUTWARD > 0.0)


def plain_hidden_edges(
    boxes: Float[Array, "n 4"], others: Float[Array, "m 4"]
) -> Bool[Array, "n 4"]:
    """Which edges of boxes lie behind one of the others that ends lower, so is nearer."""
    nearer = others[None, :, 3] > boxes[:, 3, None] + MIN_LOWER
    rows, columns = nearer.nonzero()
    hidden = np.zeros((len(boxes), 4), bool)
    if len(rows) == 0:
        return hidden
    mine, theirs = boxes[rows], others[columns]
    size = np.maximum(mine[:, 2:] - mine[:, :2], 1.0)
    shared = np.minimum(mine[:, 2:], theirs[:, 2:]) - np.maximum(mine[:, :2], theirs[:, :2])
    share = (shared / size)[:, [1, 0, 1, 0]]  # of upright edges: in y; of level ones: in x
    margin = HIDING_MARGIN * size[:, 1:]
    low, high = theirs[:, [0, 1, 0, 1]] - margin, theirs[:, [2, 3, 2, 3]] + margin
    covered = (mine > low) & (mine < high) & (share > MIN_HIDDEN_SHARE)
    np.logical_or.at(hidden, rows, covered)
    return hidden


def plain_bases(
    boxes: Float[Array, "n 4"],
    scores: Float[Array, " n"],
    hidden: Bool[Array, "n 4"],
    camera: Camera,
) -> SeenBases:
    """Where bases seem to be."""
    depth = camera.K[1, 1] / np.maximum(boxes[:, 3] - boxes[:, 1], 1.0)
    rays = camera.rays_road(boxes.dot(BOTTOM_CENTRE)) * depth[:, None]
    gap = border_gaps(boxes, camera).min(axis=1)
    reach = np.hypot(rays[:, 0], rays[:, 2])
    usable = (gap > MIN_BORDER_GAP) & (scores > MIN_SLOPE_SCORE) & ~hidden[:, 1] & ~hidden[:, 3]
    return SeenBases(rays[:, 1], reach, camera.height, usable)


def plain_at(
    self: SeenBases, heights: Float[Array, "#n"]
) -> tuple[Float[Array, " n"], Float[Array, " n"], Bool[Array, " n"]]:
    """Below the plane, away, and which tell something."""
    distance = self.reach * heights
    tells = self.is_usable & (distance > MIN_SLOPE_DISTANCE)
    return self.fall * heights - self.camera_height, np.maximum(distance, 1e-3), tells


def plain_slope(
    self: RoadModel,
    memory: RoadMemory,
    bases: SeenBases,
    heights: Float[Array, " n"],
) -> RoadMemory:
    """The memory after boxes of cars of these heights, m."""
    if self.slope_std == 0.0 or len(heights) == 0:
        return memory
    below, distance, tells = plain_at(bases, heights)
    var = (BASE_STD / distance) ** 2 + self.residual_std**2
    information = tells / (self.repetition * var)
    before = 1.0 / min(memory.slope_var, self.slope_std**2)
    total = before + information.sum()
    slope = (before * memory.slope + (information * below / distance).sum()) / total
    return memory._replace(slope=float(slope), slope_var=float(1.0 / total))


def plain_flatness(
    self: RoughnessModel,
    memory: RoadMemory,
    bases: SeenBases,
    height: float,
) -> RoadMemory:
    """The memory after boxes of a frame. height: the mean car's, m."""
    below, distance, usable = plain_at(bases, np.array([height]))
    if not np.count_nonzero(usable):
        return memory
    square, distance = np.square(below[usable]), distance[usable]
    flat = self.flat_std**2
    rough = flat + (self.rough_std * distance) ** 2
    told = (
        np.log(rough / flat)
        + np.minimum(square / rough, MAX_OFF_ROAD**2)
        - np.minimum(square / flat, MAX_OFF_ROAD**2)
    )
    flatness = memory.flatness + 0.5 * float(told.sum()) / self.repetition
    return memory._replace(flatness=flatness)


def plain_directions(
    self: DirectionPrior, memory: RoadMemory, states: CarStates
) -> Float[Array, "n k"]:
    """How much likelier each hypothesis is by its heading than if cars faced any way alike."""
    x, ahead = states.means[:, :, 0], -np.sin(states.means[:, :, YAW])
    side = np.abs(x) - MIDDLE[0]
    side = np.minimum(np.maximum(side / (MIDDLE[1] - MIDDLE[0]), 0.0), 1.0)
    before, left, right = self._shares
    aside = np.where(x[:, :, None] < 0.0, left, right)
    shares = before + side[:, :, None] * (aside - before)
    both = shares.sum(axis=2)
    strips = np.searchsorted(STRIP_BORDERS, x)
    seconds, all_seconds = memory.traffic[:, 0], memory.traffic.sum(axis=1)
    there = self.traffic_seconds * shares[:, :, 0] / both + seconds.take(strips)
    there /= self.traffic_seconds + all_seconds.take(strips)
    # densities of its directions, over the uniform one
    peak = math.sqrt(2.0 * math.pi * self.concentration) * both
    same_way = np.exp(self.concentration * (ahead - 1.0))
    opposite = np.exp(self.concentration * (-ahead - 1.0))
    factor = peak * (there * same_way + (1.0 - there) * opposite) + (1.0 - both)
    weights = np.exp(states.log_weights) * factor
    return weights / weights.sum(axis=1, keepdims=True)


def plain_likeliest(
    states: CarStates, weights: Float[Array, "n k"]
) -> tuple[Int[Array, " n"], Bool[Array, "n k"], Float[Array, " n"]]:
    """Of each car the likeliest hypothesis of the likeliest direction, and who faces as it does.

    And the probability that the car faces there rather than the other way round.
    """
    yaw = states.means[:, :, YAW]
    ways = np.empty((*yaw.shape, 2))
    ways[:, :, 0], ways[:, :, 1] = np.cos(yaw), np.sin(yaw)
    cosine = ways @ ways.transpose(0, 2, 1)  # of the angles between them
    alike = cosine > COS_SAME_DIRECTION
    votes = (alike @ weights[:, :, None])[:, :, 0] + 1e-3 * weights
    best = np.where(weights > MIN_WEIGHT, votes, 0.0).argmax(axis=1)
    rows = np.arange(len(states))
    heading_known = (weights * (cosine[rows, best] > 0.0)).sum(axis=1)
    return best, alike[rows, best], heading_known


def plain_estimate(states: CarStates, weights: Float[Array, "n k"]) -> CarEstimates:
    """Mean of the hypotheses that face the likeliest direction, and how sure that is.

    The covariance is about that mean, over all hypotheses that do not face the other way: from its
    width alone a car may be turned to the left or to the right. weights: probabilities of the
    hypotheses, which sum up to 1 over a row.
    """
    best, alike, heading_known = plain_likeliest(states, weights)
    centre = states.means[np.arange(len(states)), best]
    off = states.means - centre[:, None]
    off[:, :, YAW] = wrap_angle(off[:, :, YAW])
    shift = (_shares(weights, alike)[:, None] @ np.where(alike[:, :, None], off, 0.0))[:, 0]
    off -= shift[:, None]
    shares = _shares(weights, np.abs(off[:, :, YAW]) < 0.5 * np.pi)
    off *= (shares > 0.0)[:, :, None]
    spread = (off * shares[:, :, None]).transpose(0, 2, 1) @ off
    n, k, size = states.means.shape
    within = (shares[:, None] @ states.covs.reshape(n, k, size * size)).reshape(n, size, size)
    return CarEstimates(centre + shift, within + spread, heading_known)


def _shares(weights: Float[Array, "n k"], chosen: Bool[Array, "n k"]) -> Float[Array, "n k"]:
    """The weights of the chosen hypotheses, which sum up to 1 over a row."""
    shares: Float[Array, "n k"] = weights * chosen * (weights > MIN_WEIGHT)
    return shares / shares.sum(axis=1, keepdims=True)


def plain_forward(speeds: Float[Array, " h"], variances: Float[Array, " h"]) -> Float[Array, " h"]:
    """Log-probability that cars which seem to drive backwards do not."""
    deviation = np.minimum(speeds, 0.0) / np.sqrt(np.maximum(variances, 1e-9))
    log_probability: Float[Array, " h"] = np.where(speeds < 0.0, log_ndtr(deviation), 0.0)
    return log_probability


def plain_weighed(
    states: CarStates,
    before: Float[Array, "n k"],
    fits: Float[Array, "n k"],
    told: Float[Array, "n k"],
    evidence: float,
    switch: float,
) -> tuple[CarStates, Int[Array, "n k"]]:
    """Weights after boxes, no car driving backwards, modes that have died out begun again."""
    at, means = (before > MIN_LOG_WEIGHT).nonzero(), states.means.copy()
    speeds, variances = means[*at, SPEED], states.covs[*at, SPEED, SPEED]
    means[*at, SPEED] = np.maximum(speeds, 0.0)
    log_weights = np.full(before.shape, -np.inf)
    fit = fits[at] + plain_forward(speeds, variances)
    log_weights[at] = before[at] + evidence * fit + told[at]
    return plain_switched(CarStates(means, states.covs, normalised(log_weights)), switch)


def plain_traffic(states: CarStates, dt: float, memory: RoadMemory) -> Float[Array, "5 2"]:
    """Seconds of traffic in each strip after `dt` seconds of these cars."""
    moving = states.means[:, MOVING]
    weights = np.exp(states.log_weights[:, MOVING]) * (moving[:, :, SPEED] > MIN_TRAFFIC_SPEED)
    certain = weights.sum(axis=1) > MIN_MOVING_PROBABILITY
    weights, moving = weights[certain], moving[certain]
    ahead = -np.sin(moving[:, :, YAW])  # along the road that the camera looks down
    strips = np.searchsorted(STRIP_BORDERS, (weights * moving[:, :, 0]).sum(axis=1))
    same, oncoming = ((weights * way).sum(axis=1) for way in (ahead > 0.7, ahead < -0.7))
    seen = np.bincount(strips, same, 5), np.bincount(strips, oncoming, 5)
    return memory.traffic + dt * np.stack(seen, axis=1)


def plain_heights(states: CarStates) -> Float[Array, " n"]:
    """Each car's height by the expected logarithm, m."""
    heights: Float[Array, " n"] = np.exp(
        (np.exp(states.log_weights) * states.means[:, :, LOG_HEIGHT]).sum(axis=1)
    )
    return heights


def plain_switched(states: CarStates, share: float) -> tuple[CarStates, Int[Array, "n k"]]:
    """Cars stop and start: a mode that has died out begins again from the other one.

    share: the probability with which it does. And the hypothesis that each one was made of.
    """
    parents = np.tile(np.arange(HYPOTHESIS_COUNT), (len(states), 1))
    log_weights, speeds = states.log_weights, states.means[:, MOVING, SPEED]
    parked, moving = log_weights[:, PARKED], log_weights[:, MOVING]
    begin = math.log(share)
    stops = (parked < moving + begin - DEAD_NATS) & (moving > MIN_SWITCH_LOG_WEIGHT)
    stops &= speeds < MAX_PARKING_SPEED
    starts = (moving < parked + begin - DEAD_NATS) & (parked > MIN_SWITCH_LOG_WEIGHT)
    if not (np.count_nonzero(stops) or np.count_nonzero(starts)):
        return states, parents
    log_weights = log_weights.copy()  # means and covariances are this update's own
    for which, source, target, var in (
        (stops, HEADING_COUNT, 0, 0.0),
        (starts, 0, HEADING_COUNT, STARTING_SPEED_STD**2),
    ):
        rows, headings = which.nonzero()
        before, after = (rows, headings + source), (rows, headings + target)
        mean, cov = states.means[before], states.covs[before]
        for column in (SPEED, YAW_RATE):
            mean[:, column] = cov[:, column] = cov[:, :, column] = 0.0
        cov[:, SPEED, SPEED] = var
        states.means[after], states.covs[after] = mean, cov
        log_weights[after] = log_weights[before] + begin
        parents[after] = before[1]
    return states.replaced(log_weights=normalised(log_weights)), parents


def plain_stated(
    self: CarFilter, estimates: CarEstimates, memory: RoadMemory, factor: float = 1.0
) -> CarEstimates:
    """The estimates with the covariance that rows state. factor: on it besides.

    Speeds are those over the ground, so what is unknown of the camera's own is added.
    """
    covs = factor * self.stated_covariance * estimates.covs
    for column, std in zip((YAW, SPEED), self.stated_floor, strict=True):
        covs[:, column, column] += std**2
    yaw = estimates.means[:, YAW]
    x, z, own = np.cos(yaw), -np.sin(yaw), memory.camera_velocity_cov
    covs[:, SPEED, SPEED] += own[0, 0] * x * x + 2.0 * own[0, 1] * x * z + own[1, 1] * z * z
    return estimates.replaced(covs=covs)
