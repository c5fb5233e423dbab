"""Results against the labels of a KITTI tree, and which of its sequences are meant."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mot_sim.datasets import (
    KittiSequence,
    available_sequences,
    find_root,
    kitti_sequence,
    read_results,
)
from mot_sim.evaluation.run_folder import root_of_run
from mot_sim.evaluation.splits import Split
from mot_sim.files.text import what_is_there
from mot_sim.metrics import RULES, Evaluation, evaluate
from mot_sim.metrics.doubts import doubts_of
from tracker.errors import DatasetNotFound, UnknownName
from tracker.types import Tracks

ALL_SEQUENCES = "all"
LABELLED_SEQUENCES = ("labelled", "given")  # two words for one choice
WHOLE = Split()

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class ScoredSequences:
    """An evaluation, and what was left out of it."""

    evaluation: Evaluation
    """The scores of the sequences that have labels."""
    unlabelled: tuple[str, ...]
    """The sequences that have none."""


def choose_sequences(
    root: Path | str | None, wanted: str = ALL_SEQUENCES, split: str = "training"
) -> list[str]:
    """The names that `all`, `labelled` or `0000,0005` mean, in order, each once.

    Raises DatasetNotFound for a tree without sequences (or labels, if they are asked for),
    UnknownName for a sequence that is not there.
    """
    found = find_root(root)
    there = available_sequences(found, split)
    if not there:
        raise DatasetNotFound(f"{found / split}/calib: no sequences; give calib/SSSS.txt")
    if wanted == ALL_SEQUENCES:
        return there
    if wanted in LABELLED_SEQUENCES:
        labels = found / split / "label_02"
        named = [name for name in there if (labels / f"{name}.txt").is_file()]
        if not named:
            raise DatasetNotFound(f"{labels}: no labels; name the sequences, or take all")
        return named
    names = sorted({name.strip() for name in wanted.split(",")})
    for name in names:
        if name not in there:
            raise UnknownName.of("sequence", name, there)
    return names


def require_rules(rules: str) -> None:
    """UnknownName when there are no such rules."""
    if rules not in RULES:
        raise UnknownName.of("rules", rules, RULES)


def result_files(folder: Path) -> dict[str, Path]:
    """The result files in a folder, or in its folder `data`, by sequence; or a single file.

    Raises DatasetNotFound for none; it says what lies there instead.
    """
    for place in (folder, folder / "data"):
        files = {path.stem: path for path in sorted(place.glob("*.txt"))}
        if files:
            return files
    if folder.is_file() and folder.suffix == ".txt":
        return {folder.stem: folder}
    raise DatasetNotFound(
        f"{folder}: {what_is_there(folder, 'no results in it')}; results are SSSS.txt, as "
        "`mot-sim track` writes them"
    )


def score_sequences(
    drives: Sequence[KittiSequence],
    results: Mapping[str, Tracks],
    rules: str = "trackeval",
    kind: str = "Car",
) -> ScoredSequences:
    """The scores of results in memory, for one class of `tracker.types.TRACKED_KINDS`.

    Raises DatasetNotFound when no drive has labels.
    """
    require_rules(rules)
    results = {drive.name: rows_in_frames(results[drive.name], drive) for drive in drives}
    truths = {drive.name: (drive.truth, drive.frame_count) for drive in drives}
    contests = {
        name: (truth, results[name], frame_count)
        for name, (truth, frame_count) in truths.items()
        if truth is not None
    }
    unlabelled = tuple(name for name in truths if name not in contests)
    if not contests:
        raise DatasetNotFound(f"no labels for {', '.join(unlabelled)}: nothing can be scored")
    scored = ScoredSequences(evaluate(contests, rules, kind), unlabelled)
    for name, contest in contests.items():
        for doubt in doubts_of(*contest, kind):
            log.warning("%s: %s", name, doubt)
    return scored


def rows_in_frames(tracks: Tracks, drive: KittiSequence) -> Tracks:
    """The rows in the frames that the drive delivers: all of them, or a part."""
    if len(drive) == drive.frame_count:
        return tracks
    return tracks.select(np.isin(tracks.frames, drive.frame_indices))


def pick_results(
    folder: Path,
    root: Path | str | None = None,
    sequences: str | None = None,
    split: Split = WHOLE,
) -> dict[str, Path]:
    """The result files of the training sequences that are meant, by name, in order.

    sequences: see `choose_sequences`; None: those of the split, or those that have results. Raises
    DatasetNotFound for no results at all, and for a sequence that was asked for and has none.
    """
    files = result_files(folder)
    there = choose_sequences(root)
    made_of, scored_on = root_of_run(folder), find_root(root).resolve()
    if made_of is not None and made_of.is_dir() and made_of.resolve() != scored_on:
        log.warning(
            "%s was tracked in %s, but is compared with %s: is --root right?",
            folder, made_of, scored_on,
        )  # fmt: skip
    if split.ranges is not None:
        sequences = ",".join(split.sequences(there))
    names = choose_sequences(root, sequences) if sequences else [n for n in there if n in files]
    missing = [name for name in names if name not in files]
    if missing or not names:
        what = f"no results for {', '.join(missing)}" if missing else "no results of this tree"
        raise DatasetNotFound(f"{folder}: {what}; it has those of {', '.join(files)}")
    if sequences is None:
        for name in sorted(files.keys() - there):
            log.warning("%s is of no sequence of this tree and is left out", files[name])
    return {name: files[name] for name in names}


def read_picked(
    files: Mapping[str, Path], drives: Sequence[KittiSequence], with_cuboids: bool = False
) -> dict[str, Tracks]:
    """The results in the files, checked against the lengths of their drives."""
    return {
        drive.name: read_results(
            files[drive.name], drive.T_road_label if with_cuboids else None, drive.frame_count
        )
        for drive in drives
    }


def score_folder(
    folder: Path,
    root: Path | str | None = None,
    sequences: str | None = None,
    rules: str = "trackeval",
    kind: str = "Car",
    split: Split = WHOLE,
) -> ScoredSequences:
    """The scores of a folder of result files; the training split, for it has the labels.

    sequences: see `pick_results`. split: which frames of them count. Labelled sequences without
    results are warned of, because leaving them out changes the sum.
    """
    require_rules(rules)
    files = pick_results(folder, root, sequences, split)
    drives = [split.part(kitti_sequence(root, name, None, ego="none")) for name in files]
    scored = score_sequences(drives, read_picked(files, drives), rules, kind)
    if sequences is None:
        labelled = choose_sequences(root, LABELLED_SEQUENCES[0])
        unscored = [name for name in labelled if name not in files]
        if unscored:
            log.warning("no results for %s, which have labels: not in the sum", ", ".join(unscored))
    return scored
