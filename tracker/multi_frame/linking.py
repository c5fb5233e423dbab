"""Sightings, and every link between them that the costs allow, a frame at a time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array
from scipy.optimize import linear_sum_assignment

from tracker.association.min_cost_flow import Arcs
from tracker.beliefs import Beliefs
from tracker.box_filter import Gains
from tracker.costs import GatedPairs, weighted_sum
from tracker.errors import BadConfig
from tracker.geometry import homogeneous, invert, rotation_y
from tracker.lifecycle import NO_TRACKS, ROUNDING, ActiveTracks, in_view
from tracker.multi_frame.flow_costs import FlowCosts
from tracker.state import TrackerStatistics
from tracker.tracker import Tracker, elapsed
from tracker.types import Camera, Cuboids, Detections, Frame, Tracks

# What a step without any row gives; it has the columns that the others have.
NO_ROWS = replace(Tracks.empty(), cuboids=Cuboids.empty())


@dataclass(frozen=True, eq=False)
class FrameNodes:
    """One frame: its detections are sightings `first`, `first` + 1, ...

    observed: where each puts its car alone; beliefs: with its likeliest forerunners. arcs: all
    links that end here. T_world_road: from this frame's road to the first one's, both planes.
    """

    index: int
    time: float
    first: int
    detections: Detections
    observed: Beliefs
    beliefs: Beliefs
    arcs: Arcs
    T_world_road: Float[Array, "4 4"]

    @property
    def sightings(self) -> Int[Array, " n"]:
        """Their numbers."""
        return self.first + np.arange(len(self.detections))


@dataclass(frozen=True, eq=False)
class LinkerState:
    """All that linking remembers, and where we are.

    recent: the sightings of the last seconds, each as a track that ends there; ids: their
    numbers. gains: what was learned of the noise of boxes.
    """

    recent: ActiveTracks = NO_TRACKS
    next_sighting: int = 0
    time: float | None = None
    T_world_road: Float[Array, "4 4"] | None = None
    statistics: TrackerStatistics = TrackerStatistics()
    gains: Gains | None = None


@dataclass(frozen=True, eq=False)
class Linker:
    """Compares the detections of a frame with every sighting of the last seconds.

    tracker: gives the components: what is suppressed, how boxes are lifted, how cars move, the
    costs, the largest cost of a link and the longest memory. Sightings are carried and paired
    as a tracker does it with its tracks; each is filtered along its likeliest links, so that
    it has a velocity, and a box with less noise.
    """

    tracker: Tracker
    flow_costs: FlowCosts = FlowCosts()

    @property
    def max_cost(self) -> float:
        """A link costs less than this; 1 for an association without a limit."""
        return float(getattr(self.tracker.associate, "max_cost", 1.0))

    def __post_init__(self) -> None:
        if not 0.0 < self.max_cost < np.inf:
            raise BadConfig(f"max_cost {self.max_cost:g}: the largest cost is finite, above 0")

    def __call__(self, pool: LinkerState, frame: Frame) -> tuple[LinkerState, FrameNodes]:
        """What is remembered after the frame, and its sightings with the links to them."""
        tracker = self.tracker
        detections = tracker.suppress(frame.detections, tracker.camera)
        observed = tracker.lift(detections, tracker.camera)
        expected, T_world_road = self._expect(pool, frame, detections)
        step = 0.0 if pool.time is None else frame.time - pool.time
        pairing = GatedPairs(expected.beliefs, observed, detections, tracker.camera, tracker.sigmas)
        costs, unmeasured = self._costs(pairing)
        possible = ~(costs >= self.max_cost)  # what is no number is found by Arcs
        rows, columns = pairing.pairs[0][possible], pairing.pairs[1][possible]
        missed = expected.time_since_update[rows] - step
        missed[missed < ROUNDING] = 0.0
        links = self.flow_costs.of_links(costs[possible], self.max_cost, missed)
        arcs = Arcs(expected.ids[rows], pool.next_sighting + columns, links)

        gains = np.zeros(pairing.shape)
        gains[rows, columns] = np.minimum(links - self.flow_costs.birth, 0.0)
        new = ActiveTracks.born(
            observed, detections.scores, np.ones(len(detections)), pool.next_sighting
        )
        new, learned = self._filtered(pool.gains, expected, new, gains, step)
        sighted = FrameNodes(
            frame.index, frame.time, pool.next_sighting, detections, observed, new.beliefs, arcs,
            T_world_road,
        )  # fmt: skip
        recent = expected.time_since_update <= tracker.lifecycle.max_gap + ROUNDING
        recent &= in_view(expected.beliefs, tracker.camera)
        kept = ActiveTracks.concatenate((expected.select(recent), new))
        next_sighting = pool.next_sighting + len(detections)
        counts = updated_statistics(pool.statistics, pairing, unmeasured)
        return LinkerState(kept, next_sighting, frame.time, T_world_road, counts, learned), sighted

    def _expect(
        self, pool: LinkerState, frame: Frame, detections: Detections
    ) -> tuple[ActiveTracks, Float[Array, "4 4"]]:
        """The recent sightings at this frame, and T_world_road of it."""
        if pool.time is None or pool.T_world_road is None:
            return NO_TRACKS, np.eye(4)
        dt, old = elapsed(frame, pool.time), pool.recent
        beliefs, T_now_before = self.tracker.predict_tracks(old, frame, dt, detections)
        T_world_road = pool.T_world_road @ invert(on_the_road(T_now_before, self.tracker.camera))
        return old.replaced(
            beliefs=beliefs, time_since_update=old.time_since_update + dt
        ), T_world_road

    def _costs(self, pairing: GatedPairs) -> tuple[Float[Array, " k"], int]:
        """The cost of every pair of the pairing; how many single costs were NaN."""
        if len(pairing.pairs[0]) == 0:
            return np.zeros(0), 0
        total, _, unmeasured = weighted_sum(pairing, self.tracker.costs)
        if self.tracker.tie_break:
            total = total + self.tracker.tie_break * pairing.image_distance
        return total, unmeasured

    def _filtered(
        self,
        learned: Gains | None,
        expected: ActiveTracks,
        new: ActiveTracks,
        gains: Float[Array, "n m"],
        dt: float,
    ) -> tuple[ActiveTracks, Gains | None]:
        """The new sightings, each after those that fit best by two frames; what was learned."""
        rows, columns = linear_sum_assignment(gains)
        made = gains[rows, columns] < 0.0
        rows, columns = rows[made], columns[made]
        if len(rows) == 0:
            return new, learned
        before, now = expected.select(rows), new.select(columns)
        beliefs, surprises, learned = self.tracker.update_tracks(before, now.beliefs, dt, learned)
        again = before.seen_again(beliefs, now.scores, now.existence, surprises)
        return new.updated(columns, again.replaced(ids=now.ids)), learned


def on_the_road(T_now_before: Float[Array, "4 4"], camera: Camera) -> Float[Array, "4 4"]:
    """The camera's motion as one of the road's plane: T_roadnow_roadbefore, a turn and x, z."""
    T_road = camera.T_road_cam @ T_now_before @ camera.T_cam_road
    turn = math.atan2(T_road[0, 2] - T_road[2, 0], T_road[0, 0] + T_road[2, 2])
    return homogeneous(rotation_y(turn), T_road[:3, 3] * (1.0, 0.0, 1.0))


def updated_statistics(
    old: TrackerStatistics, pairing: GatedPairs, unmeasured: int
) -> TrackerStatistics:
    """The counts after another frame."""
    n, m = pairing.shape
    compared = old.compared + len(pairing.pairs[0])
    return TrackerStatistics(
        old.frames + 1, old.pairs + n * m, compared, old.unmeasured + unmeasured
    )


def arcs_of(seen: Sequence[FrameNodes]) -> Arcs:
    """All links that end in these frames."""
    parts = [sighted.arcs for sighted in seen]
    none = np.zeros(0, np.int64)
    return Arcs(
        np.concatenate([none, *(part.tails for part in parts)]),
        np.concatenate([none, *(part.heads for part in parts)]),
        np.concatenate([np.zeros(0), *(part.costs for part in parts)]),
    )
