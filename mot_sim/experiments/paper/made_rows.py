"""Trackers over synthetic drives, pooled over scenes and seeds, in pairs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.experiments.sweep.design import Design
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.running import sweep
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.tuning.measuring import Progress
from mot_sim.tables import Interval, limits_of
from tracker.errors import BadConfig


@dataclass(frozen=True)
class SyntheticBenchmark:
    """Synthetic drives that trackers are compared on; all trackers share the recorded traffic."""

    folder: Path
    """Folder of the sweeps, where recorded drives and finished trials are kept."""
    scenes: tuple[str, ...] = ("intersection",)
    """Names of the scenes."""
    seeds: int = 50
    """Drives per scene, with seeds from 0 on; 1 or more. More make the intervals narrower."""
    frames: int = 100
    """Frames per drive, at 10 Hz; 1 or more."""
    jobs: int = 1
    """Processes on this machine; -1: one per core."""

    def run(
        self,
        profile: str,
        contenders: Sequence[TrackerSpec],
        rules: str,
        tell: Progress,
        settings: Mapping[str, Level] | None = None,
    ) -> "PairedScores":
        """All trackers on all drives, seen through a profile (a name, or a file).

        settings: of other axes, the same for all. Raises BadConfig for a tracker that fails on
        a drive.
        """
        values: dict[str, list[Mapping[str, Any]]] = {each.name: [] for each in contenders}
        for scene in self.scenes:
            design = Design(
                {"scene.profile": (profile,)}, tuple(contenders), scene, self.seeds,
                frames=self.frames, rules=rules, fixed=dict(settings or {}),
            )  # fmt: skip
            table = sweep(design, self.folder, jobs=self.jobs, extend=True, progress=tell)
            for row in table.to_pylist():
                if row["error"] is not None:
                    raise BadConfig(
                        f"{row['tracker']} on {scene}, seed {row['seed']}: {row['error']}"
                    )
                values[row["tracker"]].append(row)
        return PairedScores(values)


@dataclass(frozen=True, eq=False)
class PairedScores:
    """Scores of several trackers on the same drives."""

    rows: Mapping[str, Sequence[Mapping[str, Any]]]
    """The rows of the sweeps' tables by the tracker's name; every tracker has the same order of
    drives."""

    def values(self, tracker: str, metric: str) -> Float[Array, " n"]:
        """A metric of every drive."""
        return np.array([float(row[metric]) for row in self.rows[tracker]])

    def mean(self, tracker: str, metric: str) -> Interval:
        """The mean over drives, with its interval."""
        return Interval.of(self.values(tracker, metric), limits_of(metric))

    def less(self, tracker: str, other: str, metric: str) -> Interval:
        """The mean of the differences to another tracker, drive by drive."""
        less = self.values(tracker, metric) - self.values(other, metric)
        return Interval.of(less, limits_of(metric, is_difference=True))

    def cut(self, tracker: str, other: str, metric: str) -> float | None:
        """By which part of the other's sum this one's is smaller; None of nothing."""
        total = float(self.values(other, metric).sum())
        return 1.0 - float(self.values(tracker, metric).sum()) / total if total else None
