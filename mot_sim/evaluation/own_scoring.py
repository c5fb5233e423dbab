"""Results against truth of one's own: tables of boxes with ids, or folders of MOTChallenge."""

import configparser
import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Int
from numpy import ndarray as Array

from mot_sim.datasets import DETECTORS, tracks_of_boxes
from mot_sim.datasets.boxes import BOX_FILES, box_files
from mot_sim.evaluation.scoring import result_files
from mot_sim.files.text import read_table, what_is_there
from mot_sim.metrics import Evaluation, Scores, combine, evaluate, motchallenge_scores
from mot_sim.metrics.doubts import doubts_of
from tracker.errors import BadConfig, BadFile, DatasetNotFound
from tracker.types import MOT_CLASSES, Tracks

MOTCHALLENGE = "motchallenge"

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class MotTruth:
    """The labels of a drive of MOTChallenge."""

    tracks: Tracks
    """All of them; frames count from 0."""
    classes: Int[Array, " n"]
    """MOT16's class of each; the scored one where the file has no such column (MOT15)."""
    counted: Bool[Array, " n"]
    """Which are to be considered: `conf` is not 0."""
    frame_count: int
    """seqLength of seqinfo.ini."""


def score_against(results: Path, truth: Path, rules: str, kind: str) -> Evaluation:
    """The scores of result files against truth of one's own, for one class of TRACKED_KINDS.

    truth: a file of boxes with ids or a folder of such files, NAME.csv, NAME.json or NAME.txt (see
    `read_box_table`), scored by `rules`; or a folder of MOTChallenge, NAME/gt/gt.txt with
    NAME/seqinfo.ini, scored by its own rules. results: such files of boxes with ids as well, of
    NAME.txt also in a folder `data`, see `result_files`. Raises DatasetNotFound for truth or
    results that are not there, BadFile for what cannot be read.
    """
    found = _found_results(results)
    if truth.is_dir() and any(truth.glob("*/gt/gt.txt")):
        if rules not in ("trackeval", MOTCHALLENGE):
            raise BadConfig(f"--rules {rules}: a folder of MOTChallenge goes by its own rules")
        return _by_motchallenge(found, truth, kind)
    if rules == MOTCHALLENGE:
        raise DatasetNotFound(f"{truth}: no NAME/gt/gt.txt, as MOTChallenge's folders have it")
    truths = _tables(truth)
    contests = {}
    for name, path in _paired(found, truths, results, truth).items():
        labels, output = tracks_of_boxes(path), tracks_of_boxes(found[name])
        last = max(int(each.frames.max(initial=-1)) for each in (labels, output))
        contests[name] = labels, output, last + 1
    evaluation = evaluate(contests, rules, kind)
    for name, contest in contests.items():
        for doubt in doubts_of(*contest, kind):
            log.warning("%s: %s", name, doubt)
    return evaluation


def _found_results(results: Path) -> dict[str, Path]:
    """The files of results by name; DatasetNotFound for none."""
    if results.is_file() and results.suffix in BOX_FILES:
        return {results.stem: results}
    return box_files(results, "results") or result_files(results)


def _tables(truth: Path) -> dict[str, Path]:
    """The files of boxes that are meant, by name."""
    if truth.is_file():
        return {truth.stem: truth}
    files = box_files(truth, "truth")
    if not files:
        what = what_is_there(truth, "no NAME.csv, NAME.json, NAME.txt or NAME/gt/gt.txt in it")
        raise DatasetNotFound(f"{truth}: {what}; give boxes with ids")
    return files


def _paired(
    found: dict[str, Path], truths: dict[str, Path], results: Path, truth: Path
) -> dict[str, Path]:
    """The truth of every drive that has results; one file of each are a pair whatever their names.

    A drive without results is warned of.
    """
    if truth.is_file() and len(found) == 1:
        return dict(zip(found, truths.values(), strict=True))
    both = {name: path for name, path in truths.items() if name in found}
    if not both:
        raise DatasetNotFound(
            f"{results}: has results of {', '.join(found)}, but {truth} has the truth of "
            f"{', '.join(truths)}: name them alike"
        )
    for name in truths:
        if name not in both:
            log.warning("no results for %s, which has truth: not in the sum", name)
    return both


def _by_motchallenge(found: dict[str, Path], truth: Path, kind: str) -> Evaluation:
    """By MOTChallenge's rules."""
    homes = {path.parent.parent.name: path for path in sorted(truth.glob("*/gt/gt.txt"))}
    missing = [name for name in homes if name not in found]
    if missing:
        raise DatasetNotFound(
            f"no results for {', '.join(missing)}: MOTChallenge scores all drives of a folder; "
            f"there are results of {', '.join(found)}"
        )
    scores: dict[str, Scores] = {}
    for name, path in homes.items():
        labels = read_mot_truth(path, kind)
        output = tracks_of_boxes(found[name])
        scores[name] = motchallenge_scores(
            labels.tracks, labels.classes, labels.counted, output, labels.frame_count, kind
        )
    return Evaluation(MOTCHALLENGE, kind, scores, combine(list(scores.values())))


def read_mot_truth(path: Path, kind: str = "Pedestrian") -> MotTruth:
    """NAME/gt/gt.txt, and the length in NAME/seqinfo.ini. Raises BadFile for bad rows."""
    info = path.parent.parent / "seqinfo.ini"
    parser = configparser.ConfigParser()
    try:
        parser.read_string(info.read_text())
        frame_count = parser.getint("Sequence", "seqLength")
    except (OSError, ValueError, configparser.Error) as error:
        reason = str(error).split("\n")[0]
        raise BadFile(f"{info}: no seqLength below [Sequence]: {reason}") from None
    form = DETECTORS["motchallenge"]  # the score is called conf there
    table = read_table(path, form.names, form.delimiter)
    boxes = form.boxes(table)
    inverted = np.asarray((boxes[:, 2:] < boxes[:, :2]).any(axis=1))
    table.reject(inverted, "a side below 0", form.box_columns)
    frames = table.frames(frame_count, first=form.first_frame)
    has_classes = len(table.rows.dtype.names or ()) > len(form.columns) + 1
    classes = (
        table.integers("more1", 1, "classes are those of MOT16")
        if has_classes and len(table)
        else np.full(len(table), MOT_CLASSES[kind])
    )
    tracks = Tracks(frames, table.integers("id", 0), boxes)
    return MotTruth(tracks, classes, table.finite(["score"])[:, 0] != 0.0, frame_count)
