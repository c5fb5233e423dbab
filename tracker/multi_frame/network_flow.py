"""Global association: all frames first, then the cheapest tracks through all of them."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Int
from numpy import ndarray as Array

from tracker.association.min_cost_flow import cheapest_flow
from tracker.dynamics import ConstantVelocity
from tracker.motion_check import Contradiction
from tracker.multi_frame.car_paths import filter_whole_tracks, no_rows, smoothed_cars, with_cars
from tracker.multi_frame.flow_costs import FlowCosts
from tracker.multi_frame.interpolation import fill_gaps
from tracker.multi_frame.linking import NO_ROWS, FrameNodes, Linker, LinkerState, arcs_of
from tracker.state import TrackerStatistics
from tracker.tracker import Tracker
from tracker.types import Frame, Tracks


@dataclass(frozen=True, eq=False)
class NetworkFlowState:
    """Everything that a network flow remembers; never modified, so keeping it is a copy."""

    linker: LinkerState = LinkerState()
    """What the linker remembers."""
    frames: tuple[FrameNodes, ...] = ()
    """All frames so far, each with its nodes and the arcs to them."""


@dataclass
class NetworkFlow:
    """Minimum-cost network flow over the whole drive: exact, and all rows come at the end.

    Which detections are cars, which belong together and where tracks begin is decided at once;
    weak tracks are dropped, and gaps filled (see `fill_gaps`).
    """

    tracker: Tracker
    """Gives the components, see `Linker.tracker`; its association is not used."""
    flow_costs: FlowCosts = FlowCosts()
    """What nodes, links, gaps and births cost."""
    acceleration_std: float = ConstantVelocity.acceleration_std
    """Std of the acceleration in the smoother that fills gaps, m/s^2; more: filled paths bend
    more."""
    state: NetworkFlowState = field(default_factory=NetworkFlowState)
    """The whole memory; assign it to go back."""

    def step(self, frame: Frame) -> Tracks:
        """Nothing yet."""
        linker, frame_nodes = Linker(self.tracker, self.flow_costs)(self.state.linker, frame)
        self.state = NetworkFlowState(linker, (*self.state.frames, frame_nodes))
        return no_rows(self.tracker)

    def finish(self) -> Tracks:
        """All rows of the drive, in the order of frames; the frames are forgotten."""
        frames, camera, paths = self.state.frames, self.tracker.camera, self.paths()
        self.state = replace(self.state, frames=())
        parts = [NO_ROWS]
        for track_id, path in paths.items():
            parts.append(fill_gaps(frames, path, track_id, camera, self.acceleration_std))
        rows = Tracks.concatenate(parts)
        rows = rows.select(np.lexsort((rows.ids, rows.frames)))
        car_filter = self.tracker.car_filter
        if car_filter is None:
            return rows
        filtered = filter_whole_tracks(self.tracker, car_filter, frames, paths)
        return with_cars(rows, smoothed_cars(car_filter, frames, filtered))

    def paths(self) -> dict[int, Int[Array, " k"]]:
        """The cheapest tracks through all frames so far: of each id its nodes, increasing."""
        frames = self.state.frames
        node_costs = np.concatenate([np.zeros(0), *(frame.node_costs for frame in frames)])
        births = np.full(len(node_costs), self.flow_costs.birth)
        flow = cheapest_flow(node_costs, births, arcs_of(frames))
        used = flow.used.nonzero()[0]
        tracks = flow.tracks[used]
        return {
            track_id: used[tracks == track]
            for track_id, track in enumerate(np.unique(tracks).tolist())
        }

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
        """Forget everything."""
        self.state = NetworkFlowState()
