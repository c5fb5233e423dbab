"""Near-online association: the cheapest tracks through the last frames, decided with a lag."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Int
from numpy import ndarray as Array

from tracker.association.min_cost_flow import Arcs, cheapest_flow
from tracker.car_filter import CarFilter, FollowedCars, smooth_first
from tracker.dynamics import ConstantVelocity
from tracker.errors import BadConfig
from tracker.lifecycle import MAX_TIME_ROUNDING
from tracker.motion_check import Contradiction
from tracker.multi_frame.car_paths import (
    CarsByFrame,
    FilteredNodes,
    filter_tracks,
    no_rows,
    with_cars,
)
from tracker.multi_frame.flow_costs import MAX_SCORE_NATS, FlowCosts
from tracker.multi_frame.interpolation import fill_gaps
from tracker.multi_frame.linking import NO_ROWS, FrameNodes, Linker, LinkerState, arcs_of
from tracker.state import TrackerStatistics
from tracker.tracker import Tracker
from tracker.types import Frame, Tracks


@dataclass(frozen=True, eq=False)
class WindowState:
    """Everything that a window remembers; never modified, so keeping it is a copy."""

    linker: LinkerState = LinkerState()
    """What the linker remembers."""
    past: tuple[FrameNodes, ...] = ()
    """Frames that were decided, as far back as a track may be continued from."""
    window: tuple[FrameNodes, ...] = ()
    """Frames that are open."""
    ends: Int[Array, " n"] = field(default_factory=lambda: np.zeros(0, np.int64))
    """The last decided node of every track."""
    ids: Int[Array, " n"] = field(default_factory=lambda: np.zeros(0, np.int64))
    """The ids of those tracks."""
    origins: Int[Array, " n"] = field(default_factory=lambda: np.zeros(0, np.int64))
    """Their first nodes."""
    next_id: int = 0
    """The id of the next track that begins."""
    cars: FollowedCars = field(default_factory=FollowedCars.none)
    """The cars of the tracks so far, at the last decided frame that was looked at; ids: the first
    nodes of their tracks, which are known before the ids are."""
    filtered: tuple[FilteredNodes, ...] = ()
    """The cars in the open frames that were looked at, by the cheapest tracks until now."""


class Paths(NamedTuple):
    """The cheapest tracks through the window."""

    nodes: list[Int[Array, " k"]]
    """For each track its nodes, increasing; the first may be the end of a decided track."""
    ids: list[int]
    """Their ids."""
    origins: list[int]
    """Their first nodes, decided ones included."""
    next_id: int
    """The id of the next track that begins."""


@dataclass
class Window:
    """Network flow over a sliding window: the rows of a frame come `lag` frames later.

    At every frame the flow is solved over the frames of the window and the tracks so far; then
    its oldest frame is decided for good, so ids are stable. Gaps are filled where the window
    contains their end, weak tracks never begin.
    """

    tracker: Tracker
    """Gives the components, see `Linker.tracker`; its association is not used."""
    flow_costs: FlowCosts = FlowCosts()
    """What nodes, links, gaps and births cost."""
    lag: int = 10
    """Frames looked ahead, enough for a birth; 10 are a second of KITTI. Only those count that a
    detector looked at. More: surer ids, later rows."""
    acceleration_std: float = ConstantVelocity.acceleration_std
    """Std of the acceleration in the smoother that fills gaps, m/s^2; more: filled paths bend
    more."""
    state: WindowState = field(default_factory=WindowState)
    """The whole memory; assign it to go back."""

    def __post_init__(self) -> None:
        if self.lag < 0:
            raise BadConfig(f"lag {self.lag}: rows cannot come before their frame; give 0 or more")
        most = (self.lag + 1) * MAX_SCORE_NATS + self.lag * self.flow_costs.fit
        if most <= self.flow_costs.birth:
            raise BadConfig(
                f"a window with a lag of {self.lag} frames gathers {most:g} nats at most, and a "
                f"birth needs {self.flow_costs.birth:g}: no track would begin; look further ahead"
            )

    def step(self, frame: Frame) -> Tracks:
        """The rows of the frame `lag` frames ago; none at first.

        With those of the frames before it that nothing looked at.
        """
        linker, frame_nodes = Linker(self.tracker, self.flow_costs)(self.state.linker, frame)
        self.state = replace(self.state, linker=linker, window=(*self.state.window, frame_nodes))
        nothing = no_rows(self.tracker)
        parts = [nothing]
        while sum(frame.is_looked_at for frame in self.state.window) > self.lag:
            parts.append(self._decide())
        return Tracks.concatenate(parts) if len(parts) > 1 else nothing

    def finish(self) -> Tracks:
        """The rows of the frames that are still open."""
        parts = [no_rows(self.tracker)]
        while self.state.window:
            parts.append(self._decide())
        return Tracks.concatenate(parts)

    @property
    def contradiction(self) -> Contradiction | None:
        """What all boxes so far contradict in the given motion or calibration; None: nothing."""
        return self.state.linker.motion_check.verdict(
            self.tracker.camera, self.tracker.lift.car_size[1]
        )

    @property
    def counts(self) -> TrackerStatistics:
        """What was done since the reset."""
        return self.state.linker.statistics

    def reset(self) -> None:
        """Forget everything; ids start at 0 again."""
        self.state = WindowState()

    def _decide(self) -> Tracks:
        """Solve, and decide the oldest frame of the window: its rows."""
        state, oldest = self.state, self.state.window[0]
        paths = self._solve()
        parts, ends, ids, origins = [NO_ROWS], [], [], []
        for path, track_id, origin in zip(paths.nodes, paths.ids, paths.origins, strict=True):
            if path[0] >= oldest.end:
                continue  # begins later: open still
            if len(path) > 1 or path[0] >= oldest.first or not oldest.is_looked_at:
                parts.append(self._row(path, track_id, oldest))
            ends.append(path[path < oldest.end][-1])
            ids.append(track_id)
            origins.append(origin)
        past = (*state.past, oldest)
        if oldest.is_looked_at:  # else nothing has been missed since
            horizon = oldest.time - self.tracker.lifecycle.max_gap - MAX_TIME_ROUNDING
            past = tuple(frame for frame in past if frame.time >= horizon)
        decided = np.array([ends, ids, origins], np.int64)
        decided = decided[:, decided[0] >= past[0].first]
        rows = Tracks.concatenate(parts)
        rows = rows.select(np.argsort(rows.ids))
        filtered, cars = self._filter(paths), state.cars
        if self.tracker.car_filter is not None:
            rows = with_cars(rows, self._cars(self.tracker.car_filter, paths, filtered))
        if filtered and oldest.is_looked_at:
            cars, filtered = filtered[0].frame.cars, filtered[1:]
        self.state = WindowState(
            state.linker, past, state.window[1:], decided[0], decided[1], decided[2], paths.next_id,
            cars.select(np.isin(cars.ids, decided[2])), tuple(filtered),
        )  # fmt: skip
        return rows

    def _filter(self, paths: Paths) -> list[FilteredNodes]:
        """The cars of these tracks in the frames of the window; none without a `car_filter`."""
        state, car_filter = self.state, self.tracker.car_filter
        if car_filter is None:
            return []
        followed = dict(zip(paths.origins, paths.nodes, strict=True))
        end = state.window[-1].end
        last = dict.fromkeys(followed, end)  # any of them may be seen again
        return filter_tracks(
            self.tracker, car_filter, state.window, followed, state.cars, last, state.filtered
        )

    def _cars(
        self, car_filter: CarFilter, paths: Paths, filtered: Sequence[FilteredNodes]
    ) -> CarsByFrame:
        """The cars of the oldest frame, if it was looked at, smoothed over the window."""
        oldest = self.state.window[0]
        if not oldest.is_looked_at:
            return {}
        names = dict(zip(paths.origins, paths.ids, strict=True))
        ids = np.array([names.get(i, -1) for i in filtered[0].frame.cars.ids.tolist()], np.int64)
        cars = smooth_first(car_filter, [each.frame for each in filtered])
        return {oldest.index: (ids, cars)}

    def _solve(self) -> Paths:
        """The cheapest paths over the ends of the tracks so far and the nodes of the window."""
        state = self.state
        new_costs = np.concatenate([frame.node_costs for frame in state.window])
        first = state.window[0].first
        order = np.argsort(state.ends)
        end_ids, end_origins, end_count = state.ids[order], state.origins[order], len(order)
        nodes = np.concatenate((state.ends[order], first + np.arange(len(new_costs))))
        node_costs = np.concatenate((np.zeros(end_count), new_costs))
        births = np.full(len(nodes), self.flow_costs.birth)
        births[:end_count] = 0.0
        flow = cheapest_flow(node_costs, births, arcs_between(nodes, arcs_of(state.window)))
        paths, ids, origins, next_id = [], [], [], state.next_id
        for places in groups(flow.tracks):
            is_new = places[0] >= end_count
            if is_new and not flow.used[places[0]]:
                continue
            path = nodes[places]
            if is_new:
                ids.append(next_id)
                origins.append(int(path[0]))
                next_id += int(path[0] < state.window[0].end)
            else:
                ids.append(int(end_ids[places[0]]))
                origins.append(int(end_origins[places[0]]))
            paths.append(path)
        return Paths(paths, ids, origins, next_id)

    def _row(self, path: Int[Array, " k"], track_id: int, oldest: FrameNodes) -> Tracks:
        """The track's row in the oldest frame of the window, or none."""
        here = path[(path >= oldest.first) & (path < oldest.end)]
        if len(here) == 0:
            span, camera = (*self.state.past, *self.state.window), self.tracker.camera
            rows = fill_gaps(span, path[:2], track_id, camera, self.acceleration_std)
            return rows.select(rows.frames == oldest.index)
        row = here - oldest.first
        frames, ids = np.array([oldest.index]), np.array([track_id])
        boxes, scores = oldest.detections.boxes[row], oldest.detections.scores[row]
        return Tracks(frames, ids, boxes, scores, cuboids=oldest.beliefs.cuboids.select(row))


def arcs_between(nodes: Int[Array, " n"], arcs: Arcs) -> Arcs:
    """The arcs between these nodes, which increase, renumbered by their places."""
    inside = np.isin(arcs.tails, nodes) & np.isin(arcs.heads, nodes)
    tails = np.searchsorted(nodes, arcs.tails[inside])
    heads = np.searchsorted(nodes, arcs.heads[inside])
    return Arcs(tails, heads, arcs.costs[inside])


def groups(labels: Int[Array, " n"]) -> list[Int[Array, " k"]]:
    """The places of every label, in the order of labels."""
    if len(labels) == 0:
        return []
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)
