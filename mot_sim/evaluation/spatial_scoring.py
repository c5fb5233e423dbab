"""Results against labels in 3D: a folder of result files, or results in memory."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mot_sim.datasets import KittiSequence, find_root, kitti_sequence, read_cuboid_results
from mot_sim.datasets.kitti.ego import oxts_path
from mot_sim.evaluation.scoring import WHOLE, pick_results, rows_in_frames
from mot_sim.evaluation.splits import Split
from mot_sim.metrics.cuboid_doubts import doubts_of_cuboids
from mot_sim.metrics.cuboid_overlap import Criterion
from mot_sim.metrics.spatial import CRITERIA, SpatialScores, spatial_scores
from tracker.errors import BadConfig, BadFile, DatasetNotFound
from tracker.geometry import invert
from tracker.types import Tracks

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class SpatialEvaluation:
    """The scores in 3D of every sequence that has labels, and of all together."""

    sequences: dict[str, SpatialScores]
    """The scores of each sequence, by its name."""
    combined: SpatialScores
    """The scores of all of them as one data set."""
    unlabelled: tuple[str, ...] = ()
    """The sequences that have no labels."""

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and lists, ready for JSON."""
        return {
            "sequences": {name: scores.as_dict() for name, scores in self.sequences.items()},
            "combined": self.combined.as_dict(),
        }


def parse_criteria(text: str) -> tuple[Criterion, ...]:
    """What makes a match, from `.25,.5,2m`. Raises BadConfig."""
    criteria = tuple(Criterion.parse(word) for word in text.split(","))
    if len({each.name for each in criteria}) < len(criteria):
        raise BadConfig(f"3D thresholds {text!r}: write each once")
    return criteria


def score_in_3d(
    drives: Sequence[KittiSequence],
    results: Mapping[str, Tracks],
    criteria: Sequence[Criterion] = CRITERIA,
    kind: str = "Car",
) -> SpatialEvaluation:
    """The scores in 3D of results in memory, whose cuboids stand in the drives' road frames.

    A drive's motion, where it has one, tells which cars move. Raises DatasetNotFound when no
    drive has labels, BadFile for labels without cuboids.
    """
    scores: dict[str, SpatialScores] = {}
    for drive in drives:
        truth = drive.truth
        if truth is None:
            continue
        if len(truth) and truth.cuboids is None:
            raise BadFile(
                f"{drive.label_path}: no label has a cuboid (h w l x y z rotation_y), so nothing "
                "can be scored in 3D; score it in 2D"
            )
        road = None
        if drive.Ts_world_cam is not None:
            road = drive.Ts_world_cam @ invert(drive.camera.T_road_cam)
        scores[drive.name] = spatial_scores(
            truth, rows_in_frames(results[drive.name], drive), drive.frame_count, road,
            drive.frame_rate, criteria, kind,
        )  # fmt: skip
        for doubt in doubts_of_cuboids(scores[drive.name].errors):
            log.warning("%s: %s", drive.name, doubt)
    unlabelled = tuple(drive.name for drive in drives if drive.name not in scores)
    if not scores:
        raise DatasetNotFound(f"no labels for {', '.join(unlabelled)}: nothing can be scored")
    return SpatialEvaluation(scores, SpatialScores.combine(list(scores.values())), unlabelled)


def score_folder_in_3d(
    folder: Path,
    root: Path | str | None = None,
    sequences: str | None = None,
    criteria: Sequence[Criterion] = CRITERIA,
    kind: str = "Car",
    ego: str | None = None,
    split: Split = WHOLE,
) -> SpatialEvaluation:
    """The scores in 3D of a folder of result files, whose cuboids stand in camera 0.

    sequences: see `pick_results`. split: which frames of them count. ego: a name of EGO, which
    tells which cars move; None: OXTS of the sequences that have it. Raises BadFile for results
    without cuboids, and as `read_cuboid_results` and `score_in_3d`.
    """
    files = pick_results(folder, root, sequences, split)
    drives = []
    for name in files:
        chosen = ego
        if chosen is None:
            has_oxts = oxts_path(find_root(root), "training", name).is_file()
            chosen = "oxts" if has_oxts else "none"
            if not has_oxts:
                log.warning("%s: no oxts/, so nobody knows which cars move: --ego NAME", name)
        drives.append(split.part(kitti_sequence(root, name, None, ego=chosen)))
    results = {
        drive.name: read_cuboid_results(files[drive.name], drive.T_road_label, drive.frame_count)
        for drive in drives
    }
    return score_in_3d(drives, results, criteria, kind)
