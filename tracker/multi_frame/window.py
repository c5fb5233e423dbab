"""Near-online association: the cheapest tracks through the last frames, decided with a lag."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Int
from numpy import ndarray as Array

from tracker.association.min_cost_flow import Arcs, cheapest_flow
from tracker.dynamics import ConstantVelocity
from tracker.errors import BadConfig
from tracker.lifecycle import ROUNDING
from tracker.multi_frame.flow_costs import MOST, FlowCosts
from tracker.multi_frame.interpolation import fill_gaps
from tracker.multi_frame.linking import NO_ROWS, FrameNodes, Linker, LinkerState, arcs_of
from tracker.state import TrackerStatistics
from tracker.tracker import Tracker
from tracker.types import Frame, Tracks


@dataclass(frozen=True, eq=False)
class WindowState:
    """Everything that a window remembers; never modified, so keeping it is a copy.

    past: frames that were decided, as far back as a track may be picked up again. window: those
    that are open. ends: the last decided sighting of every track, ids: of those tracks.
    """

    pool: LinkerState = LinkerState()
    past: tuple[FrameNodes, ...] = ()
    window: tuple[FrameNodes, ...] = ()
    ends: Int[Array, " n"] = field(default_factory=lambda: np.zeros(0, np.int64))
    ids: Int[Array, " n"] = field(default_factory=lambda: np.zeros(0, np.int64))
    next_id: int = 0


@dataclass
class Window:
    """Network flow over a sliding window: the rows of a frame come `lag` frames later.

    At every frame the flow is solved over the frames of the window and the tracks so far; then
    its oldest frame is decided for good, so ids are stable. Gaps are filled as far as the
    window shows their end, weak tracks never begin. tracker, acceleration_std: as for
    `NetworkFlow`. lag: frames looked ahead; 10 are a second of KITTI.
    """

    tracker: Tracker
    flow_costs: FlowCosts = FlowCosts()
    lag: int = 10
    acceleration_std: float = ConstantVelocity.acceleration_std
    state: WindowState = field(default_factory=WindowState)

    def __post_init__(self) -> None:
        most = (self.lag + 1) * MOST + self.lag * self.flow_costs.fit
        if most <= self.flow_costs.birth:
            raise BadConfig(
                f"a window with a lag of {self.lag} frames gathers {most:g} nats at most, and a "
                f"birth needs {self.flow_costs.birth:g}: no track would begin; look further ahead"
            )

    def step(self, frame: Frame) -> Tracks:
        """The rows of the frame `lag` frames ago; none at first."""
        pool, sighted = Linker(self.tracker, self.flow_costs)(self.state.pool, frame)
        self.state = replace(self.state, pool=pool, window=(*self.state.window, sighted))
        return self._decide() if len(self.state.window) > self.lag else NO_ROWS

    def finish(self) -> Tracks:
        """The rows of the frames that are still open."""
        parts = [NO_ROWS]
        while self.state.window:
            parts.append(self._decide())
        return Tracks.concatenate(parts)

    @property
    def counts(self) -> TrackerStatistics:
        """What was done since the reset."""
        return self.state.pool.statistics

    def reset(self) -> None:
        """Forget everything; ids start at 0 again."""
        self.state = WindowState()

    def _decide(self) -> Tracks:
        """Solve, and decide the oldest frame of the window: its rows."""
        state, oldest = self.state, self.state.window[0]
        chains, ids, next_id = self._chains()
        parts = [NO_ROWS]
        decided = oldest.first + len(oldest.detections)
        ends, named = [], []
        for name, chain in zip(ids, chains, strict=True):
            if chain[0] >= decided:
                continue  # begins later: open still
            if len(chain) > 1 or chain[0] >= oldest.first:
                parts.append(self._row(chain, name, oldest))
            ends.append(chain[chain < decided][-1])
            named.append(name)
        horizon = oldest.time - self.tracker.lifecycle.max_gap - ROUNDING
        past = tuple(frame for frame in (*state.past, oldest) if frame.time >= horizon)
        remembered = np.array(ends, np.int64) >= past[0].first
        self.state = WindowState(
            state.pool, past, state.window[1:],
            np.array(ends, np.int64)[remembered], np.array(named, np.int64)[remembered], next_id,
        )  # fmt: skip
        rows = Tracks.concatenate(parts)
        return rows.select(np.argsort(rows.ids))

    def _chains(self) -> tuple[list[Int[Array, " k"]], list[int], int]:
        """The tracks through the window: sightings, ids (new ones in the order of sightings)."""
        state = self.state
        scores = np.concatenate([frame.detections.scores for frame in state.window])
        first = state.window[0].first
        numbers = np.concatenate((state.ends, first + np.arange(len(scores))))
        order = np.argsort(numbers)  # the ends come first already, in any order
        numbers, past = numbers[order], len(state.ends)
        ids = state.ids[order[:past]]
        sightings = np.concatenate((np.zeros(past), self.flow_costs.of_scores(scores)))
        births = np.full(len(numbers), self.flow_costs.birth)
        births[:past] = 0.0
        flow = cheapest_flow(sightings, births, within(numbers, arcs_of(state.window)))
        oldest_end = first + len(state.window[0].detections)
        next_id = state.next_id
        chains, names = [], []
        for members in groups(flow.tracks):
            if not flow.used[members[0]] and members[0] >= past:
                continue
            chain = numbers[members]
            if members[0] < past:
                names.append(int(ids[members[0]]))
            else:
                names.append(next_id)
                next_id += int(chain[0] < oldest_end)
            chains.append(chain)
        return chains, names, next_id

    def _row(self, chain: Int[Array, " k"], name: int, oldest: FrameNodes) -> Tracks:
        """The track's row in the oldest frame of the window, or none."""
        mine = chain[(chain >= oldest.first) & (chain < oldest.first + len(oldest.detections))]
        frames = (*self.state.past, *self.state.window)
        if len(mine) == 0:
            rows = fill_gaps(frames, chain[:2], name, self.tracker.camera, self.acceleration_std)
            return rows.select(rows.frames == oldest.index)
        row = mine - oldest.first
        cuboids = oldest.beliefs.cuboids.select(row)
        boxes, scores = oldest.detections.boxes[row], oldest.detections.scores[row]
        return Tracks(np.array([oldest.index]), np.array([name]), boxes, scores, cuboids=cuboids)


def within(numbers: Int[Array, " n"], arcs: Arcs) -> Arcs:
    """The arcs between these sightings, which increase, renumbered by their places."""
    inside = np.isin(arcs.tails, numbers) & np.isin(arcs.heads, numbers)
    tails = np.searchsorted(numbers, arcs.tails[inside])
    heads = np.searchsorted(numbers, arcs.heads[inside])
    return Arcs(tails, heads, arcs.costs[inside])


def groups(labels: Int[Array, " n"]) -> list[Int[Array, " k"]]:
    """The places of every label, in the order of labels."""
    if len(labels) == 0:
        return []
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)
