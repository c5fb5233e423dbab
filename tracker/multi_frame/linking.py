"""Detections as nodes, and the arcs between them that the costs allow, a frame at a time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.association.min_cost_flow import Arcs
from tracker.beliefs import Beliefs
from tracker.box_filter import Gains
from tracker.costs import GatedPairs
from tracker.ego_motion import CameraMotion, RoadMotion
from tracker.errors import BadConfig
from tracker.geometry import homogeneous, invert, rotation_y
from tracker.lifecycle import MAX_TIME_ROUNDING, NO_TRACKS, ActiveTracks, in_view
from tracker.motion_check import MotionCheck
from tracker.multi_frame.flow_costs import FlowCosts
from tracker.score_scale import ScoreMemory
from tracker.state import Clock, TrackerStatistics
from tracker.tracker import Tracker
from tracker.types import Camera, Cuboids, Detections, Frame, Tracks

# What a step without any row gives; it has the columns that the others have.
NO_ROWS = replace(Tracks.empty(), cuboids=Cuboids.empty())


@dataclass(frozen=True, eq=False)
class FrameNodes:
    """One frame: its detections are the nodes `first`, `first` + 1, ..."""

    index: int
    """Number of the frame, counted from 0."""
    time: float
    """When it was taken, s."""
    first: int
    """Number of its first node."""
    detections: Detections
    """Its detections after suppression, one per node."""
    node_costs: Float[Array, " n"]
    """What each node costs, nats; negative: it gains."""
    observed: Beliefs
    """Where each detection alone puts its car, in this frame's road frame."""
    beliefs: Beliefs
    """The same, filtered along the likeliest arcs."""
    arcs: Arcs
    """All arcs that end in this frame."""
    T_world_road: Float[Array, "4 4"]
    """From this frame's road to that of the first frame, both as planes."""
    dt: float
    """Seconds since the last frame before that was looked at; 0: there was none."""
    T_now_before: Float[Array, "4 4"]
    """The camera's motion since then, its rotation corrected."""
    motion_cov: Float[Array, "6 6"]
    """Its covariance."""
    is_looked_at: bool = True
    """Whether a detector looked at it."""

    @property
    def nodes(self) -> Int[Array, " n"]:
        """Their numbers."""
        return self.first + np.arange(len(self.detections))

    @property
    def end(self) -> int:
        """The first node of the next frame."""
        return self.first + len(self.detections)


@dataclass(frozen=True, eq=False)
class LinkerState:
    """Everything that a linker remembers between two frames."""

    recent: ActiveTracks = NO_TRACKS
    """The nodes of the last seconds, each as a track that ends there; ids: their numbers."""
    next_node: int = 0
    """Number of the next frame's first node."""
    clock: Clock = Clock()
    """Where the linker is in time."""
    T_world_road: Float[Array, "4 4"] | None = None
    """From the road of the last frame that was looked at, as `recent` is, to that of the first
    frame; None: no such frame yet."""
    statistics: TrackerStatistics = TrackerStatistics()
    """What was done since the reset."""
    gains: Gains | None = None
    """What was learned of the noise of boxes; None: nothing yet."""
    scores: ScoreMemory = ScoreMemory()
    """What was learned of the detector's scores."""
    motion_check: MotionCheck = MotionCheck()
    """What the boxes told of the motion and the calibration that are given."""


class Links(NamedTuple):
    """Possible links from recent nodes to new ones, one per entry."""

    rows: Int[Array, " k"]
    """Row of the recent node in `LinkerState.recent`."""
    columns: Int[Array, " k"]
    """Which of the new frame's nodes follows."""
    costs: Float[Array, " k"]
    """What each link costs, nats; negative: it gains."""


@dataclass(frozen=True, eq=False)
class Linker:
    """Compares the detections of a frame with every node of the last seconds.

    Nodes are predicted and gated as a tracker does it with its tracks; each is filtered along its
    likeliest links, so that it has a velocity, and a box with less noise.
    """

    tracker: Tracker
    """Gives the components: suppression, lifting, dynamics, costs, the largest cost of a link
    (finite, > 0) and the longest memory."""
    flow_costs: FlowCosts = FlowCosts()
    """What nodes, links, gaps and births cost."""

    @property
    def max_cost(self) -> float:
        """A link costs less than this; 1 for an association without a limit."""
        return float(getattr(self.tracker.associate, "max_cost", 1.0))

    def __post_init__(self) -> None:
        if not 0.0 < self.max_cost < np.inf:
            raise BadConfig(f"max_cost {self.max_cost:g}: the largest cost is finite, above 0")

    def __call__(self, state: LinkerState, frame: Frame) -> tuple[LinkerState, FrameNodes]:
        """What is remembered after the frame; its nodes, with the arcs to them.

        A frame that nothing looked at has no nodes, and is nothing that later ones would miss.
        """
        tracker, first = self.tracker, state.next_node
        motion, dt = state.clock.since_look(frame)
        given, memory = tracker.rescored(state.scores, frame)
        detections = tracker.suppress(given, tracker.camera)
        observed = tracker.lift(detections, tracker.camera)
        recent, T_now_before, T_world_road = self._predict(state, motion, dt, detections)
        pairs = tracker.gate(recent, observed, detections, dt)
        costs, unmeasured = tracker.pair_costs(pairs)
        links = self._links(recent, pairs, costs, dt)
        arcs = Arcs(recent.ids[links.rows], first + links.columns, links.costs)

        scores = detections.scores
        new = ActiveTracks.born(observed, scores, np.ones(len(scores)), first)
        new, gains = self._filter(links, recent, new, dt, state.gains)
        for remembered in (detections, observed, new):
            remembered.locked()
        frame_nodes = FrameNodes(
            frame.index,
            frame.time,
            first,
            detections,
            self.flow_costs.of_scores(scores, memory.says_nothing),
            observed,
            new.beliefs,
            arcs,
            T_world_road,
            dt,
            T_now_before.copy(),  # the frame's arrays are the caller's
            motion.covariance.copy(),
            frame.looked_at,
        )
        n, m = pairs.shape
        statistics = state.statistics.after_frame(n * m, len(costs), unmeasured)
        clock = state.clock.after(frame)
        if not frame.looked_at:
            return replace(state, clock=clock, statistics=statistics), frame_nodes
        kept = ActiveTracks.concatenate((self._within_memory(recent), new)).locked()
        after = LinkerState(
            kept, frame_nodes.end, clock, T_world_road, statistics, gains, memory,
            state.motion_check.after(
                frame, state.clock.T_since_look(frame), observed.boxes, tracker.camera,
                tracker.lift.car_size[1],
            ),
        )  # fmt: skip
        return after, frame_nodes

    def _predict(
        self, state: LinkerState, motion: CameraMotion, dt: float, detections: Detections
    ) -> tuple[ActiveTracks, Float[Array, "4 4"], Float[Array, "4 4"]]:
        """The recent nodes as they should be at this frame; T_now_before and T_world_road of it."""
        if state.T_world_road is None:
            return NO_TRACKS, np.eye(4), np.eye(4)
        recent, T_now_before = self.tracker.predict_tracks(state.recent, motion, dt, detections)
        T_road = on_the_road(T_now_before, self.tracker.camera)
        return recent, T_now_before, state.T_world_road @ invert(T_road)

    def _links(
        self, recent: ActiveTracks, pairs: GatedPairs, costs: Float[Array, " k"], dt: float
    ) -> Links:
        """The gated pairs that cost less than the limit."""
        possible = ~(costs >= self.max_cost)  # Arcs refuses what is no number
        rows, columns = pairs.pairs[0][possible], pairs.pairs[1][possible]
        missed = recent.time_since_update[rows] - dt
        missed[missed < MAX_TIME_ROUNDING] = 0.0
        return Links(
            rows, columns, self.flow_costs.of_links(costs[possible], self.max_cost, missed)
        )

    def _filter(
        self,
        links: Links,
        recent: ActiveTracks,
        new: ActiveTracks,
        dt: float,
        gains: Gains | None,
    ) -> tuple[ActiveTracks, Gains | None]:
        """The new nodes, each after the recent one that fits best by two frames; gains learned."""
        from scipy.optimize import linear_sum_assignment

        saved = np.zeros((len(recent), len(new)))  # against a birth at the new node
        saved[links.rows, links.columns] = np.minimum(links.costs - self.flow_costs.birth, 0.0)
        rows, columns = linear_sum_assignment(saved)
        is_made = saved[rows, columns] < 0.0
        rows, columns = rows[is_made], columns[is_made]
        if len(rows) == 0:
            return new, gains
        linked = new.select(columns)
        updated, gains = self.tracker.update_tracks(
            recent.select(rows), linked.beliefs, linked.scores, linked.existence, dt, gains
        )
        return new.updated(columns, updated.replaced(ids=linked.ids)), gains

    def _within_memory(self, recent: ActiveTracks) -> ActiveTracks:
        """The recent nodes that later ones may still be linked to."""
        max_gap, camera = self.tracker.lifecycle.max_gap, self.tracker.camera
        kept = recent.time_since_update <= max_gap + MAX_TIME_ROUNDING
        return recent.select(kept & in_view(recent.beliefs, camera))


def on_the_road(T_now_before: Float[Array, "4 4"], camera: Camera) -> Float[Array, "4 4"]:
    """The camera's motion as one of the road's plane: T_roadnow_roadbefore, a turn and x, z."""
    T_road, turn, *_ = RoadMotion.of(T_now_before, camera)
    return homogeneous(rotation_y(turn), T_road[:3, 3] * (1.0, 0.0, 1.0))


def arcs_of(frames: Sequence[FrameNodes]) -> Arcs:
    """All arcs that end in these frames."""
    parts = [frame.arcs for frame in frames]
    none = np.zeros(0, np.int64)
    return Arcs(
        np.concatenate([none, *(part.tails for part in parts)]),
        np.concatenate([none, *(part.heads for part in parts)]),
        np.concatenate([np.zeros(0), *(part.costs for part in parts)]),
    )
