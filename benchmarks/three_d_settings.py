"""Settings of the car filter, chosen on all drives but one and judged on that one.

    python -m benchmarks.three_d_settings --root KITTI [--sequences labelled] [--ego oxts]
                                          [--frames N]

Which box belongs to which track does not depend on the filter: drives are tracked once, by the
network flow, then every setting follows the cars of those tracks, forwards and back. For each drive
the setting is taken that has most centres within 2 m on the others, forwards and back together;
what it reaches on the drive that was left out stands beside what the defaults reach, and beside
back-projected cuboids without the filter. --frames: only the first of each drive.
"""

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path

import numpy as np
from jaxtyping import Int
from numpy import ndarray as Array
from rich.console import Console

from benchmarks.three_d import without_car_filter
from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.evaluation.runs import track_sequence
from mot_sim.evaluation.scoring import choose_sequences
from mot_sim.metrics.cuboid_errors import NEAR, CuboidErrors, cuboid_errors, median, share
from mot_sim.tables import Column, Table
from mot_sim.tables.columns import Row
from tracker import Tracker, Tracks
from tracker.car_filter import CarFilter, CarMotion, EdgeModel, RoadModel
from tracker.geometry import invert
from tracker.multi_frame.car_paths import (
    CarsByFrame,
    filter_whole_tracks,
    filtered_cars,
    smoothed_cars,
    with_cars,
)
from tracker.multi_frame.linking import FrameNodes
from tracker.multi_frame.network_flow import NetworkFlow

DEFAULT = CarFilter()
SETTINGS: dict[str, CarFilter] = {
    "default": DEFAULT,
    "edge_std .038": replace(DEFAULT, edges=EdgeModel(edge_std=0.038)),
    "edge_std .055": replace(DEFAULT, edges=EdgeModel(edge_std=0.055)),
    "evidence 1": replace(DEFAULT, evidence=1.0),
    "tightness .7": replace(DEFAULT, tightness=0.7),
    "max_misfit 6": replace(DEFAULT, max_misfit=6.0),
    "no restarts": replace(DEFAULT, max_misfit=inf),
    "moving_share .45": replace(DEFAULT, moving_share=0.45),
    "yaw_rate_std .05": replace(DEFAULT, motion=CarMotion(yaw_rate_std=0.05)),
    "size_std x .8": replace(DEFAULT, size_std=(0.08, 0.062, 0.054)),
    "size_std x 1.2": replace(DEFAULT, size_std=(0.12, 0.094, 0.082)),
    "slope_std .015": replace(DEFAULT, road=RoadModel(slope_std=0.015)),
    "slope_std .03": replace(DEFAULT, road=RoadModel(slope_std=0.03)),
}


@dataclass(frozen=True, eq=False)
class TrackedDrive:
    """A drive whose tracks are decided."""

    drive: KittiSequence
    """The drive, with labels."""
    tracker: Tracker
    """Gives the camera."""
    nodes: tuple[FrameNodes, ...]
    """Its frames."""
    paths: Mapping[int, Int[Array, " k"]]
    """Of each track its nodes."""
    rows: Tracks
    """The rows of the tracks."""
    without: CuboidErrors
    """The errors of the online tracker without the filter."""

    @classmethod
    def of(cls, drive: KittiSequence) -> "TrackedDrive":
        """Track a drive."""
        tracker = without_car_filter(drive.camera)
        flow = NetworkFlow(tracker)
        for frame in drive:
            flow.step(frame)
        nodes, paths = flow.state.frames, flow.paths()
        online, _ = track_sequence(tracker, drive)
        return cls(drive, tracker, nodes, paths, flow.finish(), errors_of(drive, online))

    def errors(self, car_filter: CarFilter) -> tuple[CuboidErrors, CuboidErrors]:
        """With this filter: forwards, and back."""
        filtered = filter_whole_tracks(self.tracker, car_filter, self.nodes, self.paths)
        there: CarsByFrame = filtered_cars(car_filter, self.nodes, filtered)
        back = smoothed_cars(car_filter, self.nodes, filtered)
        return self._errors(there), self._errors(back)

    def _errors(self, cars: CarsByFrame) -> CuboidErrors:
        return errors_of(self.drive, with_cars(self.rows, cars))


def errors_of(drive: KittiSequence, rows: Tracks) -> CuboidErrors:
    """The errors of rows of a drive with labels."""
    assert drive.truth is not None
    assert drive.Ts_world_cam is not None
    road = drive.Ts_world_cam @ invert(drive.camera.T_road_cam)
    return cuboid_errors(drive.truth, rows, drive.frame_count, road, drive.frame_rate)


# Of each setting and drive: how far centres are off, forwards and back.
Centres = dict[str, dict[str, tuple[Array, Array]]]


def main() -> None:
    """Print the tables as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path)
    parser.add_argument("--sequences", default="labelled")
    parser.add_argument("--ego", default="oxts")
    parser.add_argument("--frames", type=int)
    told = parser.parse_args()
    if told.frames is not None and told.frames < 1:
        parser.error(f"--frames {told.frames}: give 1 or more")
    console = Console(stderr=True)
    drives = {}
    for name in choose_sequences(told.root, told.sequences):
        drive = kitti_sequence(told.root, name, "rrc", told.ego)
        tracked = TrackedDrive.of(drive.subset(drive.frame_indices[: told.frames]))
        if len(tracked.without):
            drives[name] = tracked
    if len(drives) < 2:
        parser.error(f"--sequences {told.sequences}: two drives with cars are needed, one left out")
    centres: Centres = {}
    for setting, car_filter in SETTINGS.items():
        centres[setting] = {}
        for name, tracked in drives.items():
            there, back = tracked.errors(car_filter)
            centres[setting][name] = there.centre, back.centre
        console.print(f"{setting}: done")
    chosen = {name: best_of(centres, left_out=name) for name in drives}
    without = {name: tracked.without.centre for name, tracked in drives.items()}
    print(fold_table(centres, chosen, without).as_markdown())
    print()
    print(setting_table(centres, chosen).as_markdown())


def best_of(centres: Centres, left_out: str) -> str:
    """The setting with most centres within 2 m on the other drives."""
    shares = {
        setting: share(np.concatenate(others(drives, left_out)) <= NEAR)
        for setting, drives in centres.items()
    }
    return max(shares, key=lambda setting: shares[setting])


def others(drives: dict[str, tuple[Array, Array]], left_out: str) -> list[Array]:
    """Both ways of all drives but one."""
    return [way for name, both in drives.items() if name != left_out for way in both]


def fold_table(centres: Centres, chosen: dict[str, str], without: dict[str, Array]) -> Table:
    """A row per drive: by the setting that the others chose, by the defaults, without filter."""
    columns = [Column("left out", "name", "row"), Column("chosen on the others", "text", "chosen")]
    for whose in ("chosen", "default"):
        for way in ("forwards", "back"):
            columns += pair_of_columns(f"{whose}, {way}")
    columns += pair_of_columns("without filter")
    rows: list[Row] = []
    for name, setting in chosen.items():
        ways = (*centres[setting][name], *centres["default"][name], without[name])
        rows.append((name, setting, *(cell for way in ways for cell in pair_of_cells(way))))
    return Table(tuple(columns), tuple(rows))


def setting_table(centres: Centres, chosen: dict[str, str]) -> Table:
    """A row per setting: over all drives, and how many left-out drives it was chosen for."""
    columns = [Column("setting", "name", "row")]
    columns += [*pair_of_columns("forwards"), *pair_of_columns("back")]
    columns.append(Column("chosen for", "count", "folds"))
    rows: list[Row] = []
    for setting, drives in centres.items():
        ways = [np.concatenate([both[way] for both in drives.values()]) for way in (0, 1)]
        cells = (cell for way in ways for cell in pair_of_cells(way))
        rows.append((setting, *cells, list(chosen.values()).count(setting)))
    return Table(tuple(columns), tuple(rows))


def pair_of_columns(title: str) -> list[Column]:
    """Median and share."""
    return [
        Column(f"{title}: centre, m", "value", f"{title}_centre", 2),
        Column("in 2 m", "rate", f"{title}_within_2m", 1),
    ]


def pair_of_cells(centre: Array) -> tuple[float, float]:
    """Median and share of centres within 2 m."""
    return median(centre), share(centre <= NEAR)


if __name__ == "__main__":
    main()
