"""The cars behind the tracks of many drives, in arrays that are written in place."""

import math
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.batch.drive_memories import DriveRoads
from tracker.car_filter import CarFilter
from tracker.car_filter.cues import CarCues
from tracker.car_filter.edges import (
    HIDING_MARGIN,
    MIN_HIDDEN_SHARE,
    MIN_LOWER,
)
from tracker.car_filter.estimates import COS_SAME_DIRECTION, MIN_WEIGHT
from tracker.car_filter.modes import STARTING_SPEED_STD, SWITCHING_LIMITS
from tracker.car_filter.projection import CUBOID_EDGES
from tracker.car_filter.restarts import places_by_height, restarted
from tracker.car_filter.road_memory import (
    BASE_STD,
    MIDDLE,
    MIN_MOVING_PROBABILITY,
    MIN_SLOPE_DISTANCE,
    MIN_TRAFFIC_SPEED,
    STRIP_BORDERS,
    SeenBases,
)
from tracker.car_filter.roughness import MAX_OFF_ROAD
from tracker.car_filter.states import MIN_LOG_WEIGHT, CarStates, normalised
from tracker.kernels import Kernel
from tracker.types import Camera, CarEstimates, Detections
from tracker.types.cuboids import CORNERS

MODULE = "tracker.kernels.drives"
HIDE = Kernel(MODULE, "hide_each")
SUM_ROADS = Kernel(MODULE, "sum_roads_each")
UPDATE = Kernel(MODULE, "update_each")
WATCH = Kernel(MODULE, "watch_each")
ESTIMATE = Kernel(MODULE, "estimate_each")
PREDICT = Kernel(MODULE, "predict_each")


@dataclass(eq=False)
class CarPool:
    """Hypotheses of cars: rows of tracks point to places in it."""

    how: CarFilter
    """The filter."""
    camera: Camera
    """The camera of all drives."""
    states: CarStates = field(default_factory=CarStates.empty)
    """At every place a car, or one of the past."""
    free: list[int] = field(default_factory=list)
    """Places that no track points to."""

    def put(self, cars: CarStates) -> Int[Array, " n"]:
        """The places where new cars now lie."""
        missing = len(cars) - len(self.free)
        if missing > 0:
            count = len(self.states)
            more = max(missing, count, 64)
            blank = CarStates(*(np.zeros((more, *part.shape[1:])) for part in vars(cars).values()))
            self.states = CarStates.concatenate((self.states, blank))
            self.free.extend(range(count + more - 1, count - 1, -1))
        places = np.array([self.free.pop() for _ in range(len(cars))], np.int64)
        self.write(places, cars)
        return places

    def write(self, places: Int[Array, " n"], cars: CarStates) -> None:
        """Other cars in these places."""
        states = self.states
        states.means[places], states.covs[places] = cars.means, cars.covs
        states.log_weights[places] = cars.log_weights

    def release(self, places: Int[Array, " n"]) -> None:
        """These places are free again."""
        self.free.extend(places.tolist())

    def predict(
        self,
        places: Int[Array, " n"],
        drives: Int[Array, " n"],
        T_road: Float[Array, "e 4 4"],
        steps: tuple[Float[Array, "e 4"], Float[Array, "e 3"]],
        covariance: Float[Array, "e 6 6"],
    ) -> None:
        """Move cars by what happened to their drives: `CarMotion`."""
        motion, numbers = self.how.motion, (self.how._log_size, self.how._size_cov)
        shared = T_road, steps[0], motion._times, motion._noise, steps[1]
        states = self.states
        before = states.means, states.covs, states.log_weights, MIN_LOG_WEIGHT, places, drives
        PREDICT(*before, *shared, *numbers, self.camera.place_shift, covariance)

    def hidden(
        self,
        boxes: Float[Array, "n 4"],
        starts: Int[Array, " _"],
        others: Float[Array, "m 4"],
        other_starts: Int[Array, " _"],
    ) -> Array:
        """`hidden_edges` of boxes, behind the others of their drive."""
        hidden = np.empty((len(boxes), 4), bool)
        HIDE(
            boxes, others, starts, other_starts, MIN_LOWER, MIN_HIDDEN_SHARE, HIDING_MARGIN, hidden
        )
        return hidden

    def update(
        self,
        places: Int[Array, " n"],
        starts: Int[Array, " _"],
        roads: DriveRoads,
        found: Detections,
        others: tuple[Float[Array, "m 4"], Int[Array, " _"]],
        dt: Float[Array, " e"],
    ) -> DriveRoads:
        """Cars after they were detected, row by row, as `found`: `CarFilter.update`.

        starts: where the rows of each drive begin. others: all boxes, and where those begin.
        """
        how, camera, states = self.how, self.camera, self.states
        counts = np.diff(starts)
        drives = np.repeat(np.arange(len(counts)), counts)
        hidden = self.hidden(found.boxes, starts, *others)
        boxes, variances = how.edges(found.boxes, found.scores, hidden)
        bases, sums = SeenBases.of(boxes, found.scores, hidden, camera), np.zeros((len(counts), 3))
        noise = (
            np.array([MIN_SLOPE_DISTANCE, BASE_STD, how.road.residual_std, how.road.repetition]),
            np.array(
                [
                    MIN_SLOPE_DISTANCE,
                    how.roughness.flat_std,
                    how.roughness.rough_std,
                    MAX_OFF_ROAD,
                ]
            ),
        )
        seen = bases.fall, bases.reach, bases.is_usable, bases.camera_height, how.size[1]
        SUM_ROADS(states.means, states.log_weights, places, starts, *seen, *noise, sums)
        roads = roads.after_boxes(how, sums, counts)
        told = np.zeros((len(places), states.log_weights.shape[1]))
        cues = CarCues.of(found)
        if cues is not None:
            after, told = how._after_cues(states.select(places), cues, hidden, is_first=False)
            self.write(places, after)
        misfits = np.empty(len(places))
        lens = camera.P_road, CORNERS, CUBOID_EDGES, camera.far_corner, how._limits
        weighing = how.evidence, math.log(how.switch), SWITCHING_LIMITS, STARTING_SPEED_STD**2
        cars = states.means, states.covs, states.log_weights, MIN_LOG_WEIGHT, places
        UPDATE(*cars, boxes, variances, *lens, told, *weighing, misfits)
        self._restart(places, drives, roads, found, hidden, misfits)
        traffic, limits = roads.traffic.copy(), (MIN_TRAFFIC_SPEED, MIN_MOVING_PROBABILITY)
        watched = states.means, states.log_weights, places, drives, STRIP_BORDERS, *limits
        WATCH(*watched, dt, traffic)
        return roads.replaced(traffic=traffic)

    def _restart(
        self,
        places: Int[Array, " n"],
        drives: Int[Array, " n"],
        roads: DriveRoads,
        found: Detections,
        hidden: Array,
        misfits: Float[Array, " n"],
    ) -> None:
        """Begin those cars anew of which nothing fits."""
        lost = (misfits > self.how.max_misfit).nonzero()[0]
        if not len(lost):
            return
        room = self.states.log_weights[places[lost]].min(axis=1) <= MIN_LOG_WEIGHT
        whole = self.how.can_restart(found.boxes[lost], hidden[lost], self.camera)
        lost = lost[room & whole]
        if not len(lost):
            return
        again, of = found.select(lost), drives[lost]
        at = places_by_height(again.boxes, self.how.size, self.camera)
        road = roads.roughness(self.how)[of], roads.slope[of]
        fresh = self.how.start_on(*road, at, again, hidden[lost], self.camera)
        cars, _ = restarted(self.states.select(places[lost]), np.arange(len(lost)), fresh)
        self.write(places[lost], cars)
        # as `restarted` does with all cars of the frame
        beside = np.setdiff1d(np.isin(drives, of).nonzero()[0], lost)
        kept = places[beside]
        self.states.log_weights[kept] = normalised(self.states.log_weights[kept])

    def start(
        self,
        drives: Int[Array, " b"],
        roads: DriveRoads,
        at: Float[Array, "b 3"],
        found: Detections,
        others: tuple[Float[Array, "m 4"], Int[Array, " _"]],
    ) -> Int[Array, " b"]:
        """The places of new cars; drives: ascending. See `CarFilter.start`."""
        starts = np.searchsorted(drives, np.arange(len(roads) + 1))
        hidden = self.hidden(found.boxes, starts, *others)
        road = roads.roughness(self.how)[drives], roads.slope[drives]
        return self.put(self.how.start_on(*road, at, found, hidden, self.camera))

    def estimate(
        self, places: Int[Array, " n"], drives: Int[Array, " n"], roads: DriveRoads
    ) -> CarEstimates:
        """One state per row, as rows state it: `CarFilter.estimate`."""
        n, states, how = len(places), self.states, self.how.directions
        out = np.empty((n, 9)), np.empty((n, 9, 9)), np.empty(n)
        prior = STRIP_BORDERS, MIDDLE, how.concentration, how.traffic_seconds
        stating = np.array([self.how.stated_covariance, *self.how.stated_floor])
        which = states.means, states.covs, states.log_weights, places, drives
        limits = COS_SAME_DIRECTION, MIN_WEIGHT, stating, roads.camera_velocity_cov
        ESTIMATE(*which, how._shares, roads.traffic, *prior, *limits, *out)
        return CarEstimates(*out)


__all__ = ["CarPool"]
