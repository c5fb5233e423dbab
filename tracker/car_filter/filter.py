"""The state of cars from their boxes: an extended Kalman filter over several hypotheses each."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.car_filter.cues import CarCues, CueModel
from tracker.car_filter.edges import (
    HIDING_MARGIN,
    MIN_HIDDEN_SHARE,
    MIN_LOWER,
    EdgeModel,
    border_gaps,
    hidden_edges,
)
from tracker.car_filter.estimates import COS_SAME_DIRECTION, MIN_WEIGHT
from tracker.car_filter.modes import switching
from tracker.car_filter.motion import CarMotion, RoadStep
from tracker.car_filter.prior import prior_states
from tracker.car_filter.projection import CUBOID_EDGES
from tracker.car_filter.restarts import places_by_height, restarted
from tracker.car_filter.road_memory import (
    MIN_BORDER_GAP,
    MIN_SLOPE_SCORE,
    DirectionPrior,
    RoadMemory,
    RoadModel,
)
from tracker.car_filter.roughness import RoughnessModel
from tracker.car_filter.states import (
    HEADING_COUNT,
    HYPOTHESIS_COUNT,
    MIN_LOG_WEIGHT,
    STATE_SIZE,
    CarStates,
    normalised,
)
from tracker.ego_motion import RoadMotion
from tracker.errors import BadConfig
from tracker.kernels import Kernel
from tracker.types import CAR_SIZE, CAR_SIZE_STD, Camera, CarEstimates, Detections
from tracker.types.cuboids import CORNERS

# How lengths, heights and widths of KITTI's labelled cars go together (ten sequences).
LOG_SIZE_CORRELATION = np.array([[1.0, 0.1, 0.28], [0.1, 1.0, 0.33], [0.28, 0.33, 1.0]])
# How often the first box is linearised anew.
START_ITERATIONS = 3
# An innovation counts as no more standard deviations than this.
MAX_DEVIATION = 4.0
UPDATE = Kernel("tracker.kernels.car_update", "update_cars")
SEE_CARS = Kernel("tracker.kernels.car_frames", "see_cars")
FIT_CARS = Kernel("tracker.kernels.car_frames", "fit_cars")
STATE_CARS = Kernel("tracker.kernels.car_frames", "state_cars")
STATE_COVARIANCES = Kernel("tracker.kernels.car_hypotheses", "state_covariances")


class BoxFits(NamedTuple):
    """Hypotheses after the boxes of their cars; those that are not followed as before."""

    states: CarStates
    """Their states and covariances, weighted as before the boxes."""
    fits: Float[Array, "n k"]
    """Log-likelihoods of the boxes, but for a constant; 0: not followed."""
    misfits: Float[Array, "n k"]
    """Squares of the boxes' standard deviations off, summed over the edges that tell something;
    inf: not followed."""


class PredictedCars(NamedTuple):
    """Cars before the boxes of a frame."""

    states: CarStates
    """In the road frame of the frame."""
    memory: RoadMemory
    """What is known of the road."""
    step: RoadStep
    """What happened to all of them."""

    @property
    def at(self) -> tuple[Int[Array, " h"], Int[Array, " h"]]:
        """Rows and columns of the hypotheses that are followed."""
        return self.states.followed()

    def places_of(self, rows: Int[Array, " k"], columns: Int[Array, " k"]) -> Int[Array, " k"]:
        """Where these hypotheses, which are followed, stand in `at`."""
        places = np.zeros(self.states.log_weights.shape, np.int64)
        at = self.at
        places[at] = np.arange(len(at[0]))
        chosen: Int[Array, " k"] = places[rows, columns]
        return chosen


class UpdatedCars(NamedTuple):
    """Cars after the boxes of a frame."""

    states: CarStates
    """In the road frame of the frame."""
    memory: RoadMemory
    """What is known of the road."""
    parents: Int[Array, "n k"]
    """The predicted hypothesis that each hypothesis was made of; -1: it begins here."""


@dataclass(frozen=True)
class CarFilter:
    """Follows the place, heading, speed and size of every track: see docs/paper.md.

    All hypotheses of all cars are one batch of arrays.
    """

    edges: EdgeModel = EdgeModel()
    """The noise of boxes."""
    cues: CueModel = CueModel()
    """The noise of measured yaws and sizes."""
    motion: CarMotion = CarMotion()
    """How cars move."""
    road: RoadModel = RoadModel()
    """The slope of the road that the cars of a frame share."""
    roughness: RoughnessModel = RoughnessModel()
    """How far cars stand off that road."""
    directions: DirectionPrior = DirectionPrior()
    """Which way cars face before their motion tells it."""
    size: tuple[float, float, float] = CAR_SIZE
    """Length, height and width of the mean car among KITTI's labels (ten sequences), m."""
    size_std: tuple[float, float, float] = CAR_SIZE_STD
    """Their stds, shares of them; more: sizes are learned sooner, places are less certain."""
    start_speed: tuple[float, float] = (3.0, 5.0)
    """Mean and std of the speed of a new car that moves, m/s."""
    evidence: float = 1.5
    """How much of a box's log-likelihood counts for the hypotheses, > 0: errors of successive
    boxes are alike. Less: hypotheses are told apart later."""
    tightness: float = 0.5
    """How much it counts therein that a hypothesis expected the box in a narrow place, 0 to 1: less
    than that the box is there, since boxes are less noisy than `edges` has it. More: parked cars
    are recognised sooner, slow ones are taken for parked."""
    max_misfit: float = 9.0
    """A car of which every hypothesis is off by more (see `BoxFits.misfits`) begins anew beside
    them; more: turns that nobody expected are followed later."""
    moving_share: float = 0.35
    """Probability that a new car moves, 0 < share < 1; more: parked cars are recognised later."""
    stated_covariance: float = 1.6
    """How much larger the covariance in rows is than the filter's own, which takes the errors of
    successive boxes for independent; chosen so that as many errors lie within it as it says."""
    stated_floor: tuple[float, float] = (0.045, 0.2)
    """What headings (rad) and speeds (m/s) are off by besides: parked cars creep, and no car drives
    exactly where it faces. More: rows state less certain ones."""
    switch: float = 0.02
    """Probability with which a mode that has died out begins again: cars stop and start."""
    carries_boxes: bool = True
    """Whether the boxes expected of tracks move and grow as their cars do; False, or where the
    camera's motion is unknown: with the tracker's `dynamics`, as suits what is no car."""

    def __post_init__(self) -> None:
        for name, share in (("moving_share", self.moving_share), ("switch", self.switch)):
            if not 0.0 < share < 1.0:
                raise BadConfig(f"{name} {share:g}: give a probability between 0 and 1")

    def predict(
        self,
        states: CarStates,
        memory: RoadMemory,
        T_now_before: Float[Array, "4 4"],
        motion_cov: Float[Array, "6 6"],
        dt: float,
        camera: Camera,
    ) -> PredictedCars:
        """What is believed `dt` seconds later, in the road frame of then, before its boxes.

        T_now_before, motion_cov: of the camera, as in `Frame`.
        """
        T_road, turn, *_ = RoadMotion.of(T_now_before, camera)
        memory = self.roughness.predict(memory, dt)
        memory, slope = self.road.predict(memory, T_road, dt)
        memory = self.directions.predict(memory, turn, dt)
        if dt > 0.0:
            R = camera.T_road_cam[:3:2, :3] / dt
            velocity_cov = R.dot(motion_cov[:3, :3]).dot(R.T)
            memory = RoadMemory(*memory[:3], velocity_cov, memory.flatness)
        roughness = self.roughness(memory)
        slopes = roughness * slope, roughness * memory.slope
        step = RoadStep(T_road, turn, dt, slopes, roughness, self._log_size, self._size_cov)
        if len(states):
            states = self.motion(states, step, motion_cov, camera)
        return PredictedCars(states, memory, step)

    def update(
        self,
        states: CarStates,
        memory: RoadMemory,
        found: Detections,
        others: Float[Array, "m 4"],
        dt: float,
        camera: Camera,
    ) -> UpdatedCars:
        """What is believed after these cars were detected, row by row, as `found`.

        Yaws and sizes in it are used. others: all boxes of the frame. dt: seconds since the last
        one.
        """
        if len(states) == 0:
            return UpdatedCars(states, memory, np.zeros((0, HYPOTHESIS_COUNT), np.int64))
        hidden, boxes, variances, told_of_road = self._see(states, found, others, camera)
        memory = self.road.after(memory, *told_of_road[:2])
        memory = self.roughness.after(memory, told_of_road[2])
        told = np.zeros(states.log_weights.shape)
        cues = CarCues.of(found)
        if cues is not None:
            states, told = self._after_cues(states, cues, hidden, is_first=False)
        after, parents, misfits = self._fit(states, boxes, variances, told, camera)
        lost = (misfits > self.max_misfit).nonzero()[0]
        if len(lost):
            room = after.log_weights[lost].min(axis=1) <= MIN_LOG_WEIGHT
            lost = lost[room & self.can_restart(found.boxes[lost], hidden[lost], camera)]
        if len(lost):
            again = found.select(lost)
            places = places_by_height(again.boxes, self.size, camera)
            fresh = self.start(memory, places, again, others, camera)
            after, is_fresh = restarted(after, lost, fresh)
            parents[is_fresh] = -1
        return UpdatedCars(after, self.directions.update(memory, after, dt), parents)

    def start(
        self,
        memory: RoadMemory,
        places: Float[Array, "n 3"],
        found: Detections,
        others: Float[Array, "m 4"],
        camera: Camera,
    ) -> CarStates:
        """New cars by their first detections, yaws and sizes included.

        places: centres of mean cars' bases that look down the road, as `Lift` has them. others:
        all boxes of the frame.
        """
        if len(found) == 0:
            return CarStates.empty()
        hidden = hidden_edges(found.boxes, others)
        return self.start_on(self.roughness(memory), memory.slope, places, found, hidden, camera)

    def start_on(
        self,
        roughness: float | Float[Array, " n"],
        slope: float | Float[Array, " n"],
        places: Float[Array, "n 3"],
        found: Detections,
        hidden: Bool[Array, "n 4"],
        camera: Camera,
    ) -> CarStates:
        """The same on a road, or one of each car, of this roughness and slope; n > 0.

        hidden: which edges of their boxes other boxes of the frame hide.
        """
        known = self._log_size, self._size_cov
        road = roughness, slope, self.motion
        means, covs = prior_states(places, self.size, known, self.start_speed, road)
        cues = CarCues.of(found)
        boxes, variances = self.edges(found.boxes, found.scores, hidden)
        modes = np.log([1.0 - self.moving_share, self.moving_share]).repeat(HEADING_COUNT)
        states, told = CarStates(means, covs, np.zeros(means.shape[:2])), np.zeros(1)
        if cues is not None:
            states, told = self._after_cues(states, cues, hidden, is_first=True)
        linear = None
        for _ in range(START_ITERATIONS):
            fitted = self._update(states, boxes, variances, camera, linear)
            linear = fitted.states.means
        log_weights = normalised(modes + (fitted.fits + told))
        return fitted.states.replaced(log_weights=log_weights)

    def can_restart(
        self, boxes: Float[Array, "n 4"], hidden: Bool[Array, "n 4"], camera: Camera
    ) -> Bool[Array, " n"]:
        """Which boxes are whole, so that cars may begin anew by them."""
        return (border_gaps(boxes, camera).min(axis=1) > self.edges.border) & ~hidden.any(axis=1)

    def estimate(self, states: CarStates, memory: RoadMemory) -> CarEstimates:
        """One state per car: of its likeliest direction, with how likely that is."""
        n = len(states)
        if n == 0:
            return CarEstimates.unknown(0)
        out = np.empty((n, STATE_SIZE)), np.empty((n, STATE_SIZE, STATE_SIZE)), np.empty(n)
        known, limits = self.directions.known(memory), (COS_SAME_DIRECTION, MIN_WEIGHT)
        stating = self.stated_covariance, *self.stated_floor, memory.camera_velocity_cov
        STATE_CARS(states.means, states.covs, states.log_weights, *known, *limits, *stating, *out)
        return CarEstimates(*out)

    def stated(
        self, estimates: CarEstimates, memory: RoadMemory, factor: float = 1.0
    ) -> CarEstimates:
        """The estimates with the covariance that rows state. factor: on it besides.

        Speeds are those over the ground, so what is unknown of the camera's own is added.
        """
        covs = np.empty(estimates.covs.shape)
        how = factor * self.stated_covariance, *self.stated_floor, memory.camera_velocity_cov
        STATE_COVARIANCES(estimates.means, estimates.covs, *how, covs)
        return estimates.replaced(covs=covs)

    def weights(self, states: CarStates, memory: RoadMemory) -> Float[Array, "n k"]:
        """Probabilities of the hypotheses, the prior of directions included."""
        return self.directions(memory, states)

    @cached_property
    def _log_size(self) -> Float[Array, "3"]:
        """Of the mean car."""
        return np.array([math.log(side) for side in self.size])

    @cached_property
    def _size_cov(self) -> Float[Array, "3 3"]:
        """Of the logarithms of sizes of all cars."""
        cov: Float[Array, "3 3"] = LOG_SIZE_CORRELATION * np.outer(self.size_std, self.size_std)
        return cov

    def _after_cues(
        self, states: CarStates, cues: CarCues, hidden: Bool[Array, "n 4"], is_first: bool
    ) -> tuple[CarStates, Float[Array, "n k"]]:
        """The followed hypotheses after the cues of their cars, and what those count for, nats.

        hidden: which edges of their boxes another one hides. is_first: no cue was read before.
        """
        return self.cues(states, cues, np.asarray(hidden.any(axis=1)), is_first)

    def _see(
        self,
        states: CarStates,
        found: Detections,
        others: Float[Array, "m 4"],
        camera: Camera,
    ) -> tuple[Bool[Array, "n 4"], Float[Array, "n 4"], Float[Array, "n 4"], tuple[float, ...]]:
        """Hidden edges, boxes without bias, variances of edges; what they tell of the road."""
        shape = found.boxes.shape
        hidden, boxes, variances = np.empty(shape, bool), np.empty(shape), np.empty(shape)
        hiding = MIN_LOWER, MIN_HIDDEN_SHARE, HIDING_MARGIN
        lens = *camera.pixel_rays_road, camera.K[1, 1], camera.far_corner
        of_boxes = found.boxes, found.scores, others, *hiding, *self.edges.noise, *lens
        of_cars = MIN_BORDER_GAP, MIN_SLOPE_SCORE, states.means, states.log_weights
        heights = camera.height, self.size[1], self.road._noise, self.roughness._noise
        told = SEE_CARS(*of_boxes, *of_cars, *heights, hidden, boxes, variances)
        return hidden, boxes, variances, told

    def _fit(
        self,
        states: CarStates,
        boxes: Float[Array, "n 4"],
        variances: Float[Array, "n 4"],
        told: Float[Array, "n k"],
        camera: Camera,
    ) -> tuple[CarStates, Int[Array, "n k"], Float[Array, " n"]]:
        """Cars after boxes, their weights included; parents; the least misfit of each.

        told: what cues tell, nats. It is what `_update` and `weighed` give.
        """
        means, covs, shape = states.means, states.covs, states.log_weights.shape
        out = np.empty(means.shape), np.empty(covs.shape), np.empty(shape)
        parents, misfits = np.empty(shape, np.int64), np.empty(len(means))
        before = means, covs, states.log_weights, MIN_LOG_WEIGHT, boxes, variances
        lens = camera.P_road, CORNERS, CUBOID_EDGES, camera.far_corner, self._limits
        weighing = told, self.evidence, *switching(self.switch)
        FIT_CARS(*before, *lens, *weighing, *out, parents, misfits)
        return CarStates(*out), parents, misfits

    def _update(
        self,
        states: CarStates,
        boxes: Float[Array, "n 4"],
        variances: Float[Array, "n 4"],
        camera: Camera,
        linear: Float[Array, "n k 9"] | None = None,
    ) -> BoxFits:
        """Cars after boxes, edge by edge, which is the joint update: the noise is diagonal.

        linear: the states at which the projection is linearised; None: at the means.
        """
        means, shape = states.means, states.log_weights.shape
        out = np.empty(means.shape), np.empty(states.covs.shape), np.empty(shape), np.empty(shape)
        at, is_given = (means, False) if linear is None else (linear, True)
        before = means, states.covs, states.log_weights, MIN_LOG_WEIGHT, at, is_given
        lens = camera.P_road, CORNERS, CUBOID_EDGES, camera.far_corner
        UPDATE(*before, boxes, variances, *lens, self._limits, *out)
        return BoxFits(CarStates(*out[:2], states.log_weights), *out[2:])

    @cached_property
    def _limits(self) -> Float[Array, "3"]:
        """Border of the image, most standard deviations, tightness."""
        return np.array([self.edges.border, MAX_DEVIATION, self.tightness])
