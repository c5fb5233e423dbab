"""How far scenes are like recorded drives: every statistic of them beside its range over drives."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets import available_sequences, find_root, kitti_sequence
from mot_sim.datasets.camera_files import planar_poses
from mot_sim.datasets.kitti.ego import oxts_path
from mot_sim.simulation.drive_statistics import DRIVE_STATISTICS, MeasuredDrive
from tracker.errors import DatasetNotFound, UnknownName

MIN_DRIVES = 2  # of which a range is made


@dataclass(frozen=True, eq=False)
class ReferenceDrives:
    """Recorded drives that scenes are held against."""

    name: str
    """What they are called in tables."""
    drives: Sequence[MeasuredDrive]
    """The drives, two or more."""
    left_out: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Names of the drives that could not be measured, by the reason."""

    @cached_property
    def values(self) -> dict[str, Float[Array, " d"]]:
        """Every statistic of every drive; NaN where a drive shows nothing of it."""
        return {
            name: np.array([each.of([drive]) for drive in self.drives])
            for name, each in DRIVE_STATISTICS.items()
        }

    @cached_property
    def samples(self) -> dict[str, list[Array]]:
        """The samples of every statistic that has a distribution, of the drives that show some."""
        return {
            name: each.shown(self.drives)
            for name, each in DRIVE_STATISTICS.items()
            if each.summary is not None
        }

    @cached_property
    def usual_gap(self) -> dict[str, float]:
        """Of every statistic, the median gap between one drive and the others; see `gap`."""
        found = {}
        for name, samples in self.samples.items():
            gaps = [gap([one], [other for other in samples if other is not one]) for one in samples]
            found[name] = float(np.median(gaps)) if len(samples) > 1 else float("nan")
        return found


@dataclass(frozen=True)
class StatisticLikeness:
    """One statistic of a scene beside the recorded drives; NaN is what was never to be seen."""

    value: float
    """Of the scene's runs together."""
    median: float
    """Of the recorded drives."""
    low: float
    """The least of a recorded drive."""
    high: float
    """The largest of a recorded drive."""
    outside: float
    """How far the value lies outside the range of the drives, in lengths of it; 0: inside."""
    gap: float
    """Largest difference of the cumulated distributions (Kolmogorov and Smirnov), 0 to 1; NaN for
    what is counted by the minute."""
    usual_gap: float
    """The median of the same between one recorded drive and the others."""


@dataclass(frozen=True)
class Likeness:
    """How like recorded drives a scene is."""

    rows: Mapping[str, StatisticLikeness]
    """By the names of DRIVE_STATISTICS."""

    @property
    def outside(self) -> float:
        """The sum over all statistics of how far they lie outside."""
        return float(np.nansum([each.outside for each in self.rows.values()]))

    @property
    def count_outside(self) -> int:
        """How many statistics lie outside the range of the drives."""
        return sum(int(each.outside > 0.0) for each in self.rows.values())

    @property
    def gap(self) -> float:
        """The mean gap of distributions; NaN without any."""
        known = [each.gap for each in self.rows.values() if np.isfinite(each.gap)]
        return float(np.mean(known)) if known else float("nan")

    @property
    def unknown(self) -> list[str]:
        """The statistics of which the scene shows nothing."""
        return [name for name, each in self.rows.items() if not np.isfinite(each.value)]


def likeness(drives: Sequence[MeasuredDrive], reference: ReferenceDrives) -> Likeness:
    """The runs of a scene, taken together, beside recorded drives."""
    rows = {}
    for name, statistic in DRIVE_STATISTICS.items():
        values = reference.values[name]
        known = values[np.isfinite(values)]
        low, median, high = np.quantile(known, (0.0, 0.5, 1.0)) if len(known) else (np.nan,) * 3
        value = statistic.of(drives)
        apart = usual = float("nan")
        if name in reference.samples:
            apart = gap(statistic.shown(drives), reference.samples[name])
            usual = reference.usual_gap[name]
        rows[name] = StatisticLikeness(
            value,
            float(median),
            float(low),
            float(high),
            outside(value, float(low), float(high)),
            apart,
            usual,
        )
    return Likeness(rows)


def outside(value: float, low: float, high: float) -> float:
    """How many lengths of a range a value lies outside it; of a point, in parts of its size."""
    beyond = max(low - value, value - high, 0.0) if np.isfinite(value) else float("nan")
    length = high - low
    if beyond == 0.0 or not np.isfinite(beyond):
        return beyond
    return beyond / (length if length > 0.0 else max(abs(high), 1.0))


def gap(some: Sequence[Array], others: Sequence[Array]) -> float:
    """Largest difference of two cumulated distributions, in each of which drives count alike.

    NaN where one of them is empty.
    """
    if not some or not others:
        return float("nan")
    places = np.unique(np.concatenate([*some, *others]))
    apart = cumulated(some, places) - cumulated(others, places)
    return float(np.abs(apart).max())


def cumulated(samples: Sequence[Array], places: Array) -> Float[Array, " p"]:
    """The share of the values up to each place, as the mean over drives; NaN without drives."""
    if not samples:
        return np.full(len(places), np.nan)
    shares = [np.searchsorted(np.sort(each), places, side="right") / len(each) for each in samples]
    return np.mean(shares, axis=0)


def kitti_reference(root: Path | str | None = None) -> ReferenceDrives:
    """The sequences of a KITTI tree that have labels and OXTS.

    Raises DatasetNotFound where there is no tree, or fewer than two such sequences in it.
    """
    found, drives = find_root(root), []
    left_out: dict[str, list[str]] = {}
    for name in available_sequences(found):
        labels = found / "training" / "label_02" / f"{name}.txt"
        lacking = [
            path for path in (labels, oxts_path(found, "training", name)) if not path.is_file()
        ]
        if lacking:
            left_out.setdefault(f"no NAME.txt in {lacking[0].parent}", []).append(name)
            continue
        drive = kitti_sequence(found, name, None)
        assert drive.Ts_world_cam is not None
        assert drive.truth is not None
        egos = planar_poses(drive.Ts_world_cam @ drive.camera.T_cam_road)
        drives.append(MeasuredDrive.of_labels(name, egos, drive.truth, drive.Ts_world_cam))
    if len(drives) < MIN_DRIVES:
        said = "".join(f"; {', '.join(names)}: {why}" for why, names in left_out.items())
        raise DatasetNotFound(
            f"{found}: {len(drives)} sequences with labels and OXTS, {MIN_DRIVES} or more are "
            f"needed{said}"
        )
    return ReferenceDrives("KITTI", drives, left_out)


REFERENCES: Mapping[str, Callable[[Path | str | None], ReferenceDrives]] = {
    "kitti": kitti_reference
}


def find_reference(name: str, root: Path | str | None = None) -> ReferenceDrives:
    """The drives of a name of REFERENCES. Raises UnknownName, and what reading them raises."""
    if name not in REFERENCES:
        raise UnknownName.of("reference", name, REFERENCES)
    return REFERENCES[name](root)
