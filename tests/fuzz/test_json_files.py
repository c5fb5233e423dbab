"""Every reader of JSON files: what runs, sweeps and episodes say of themselves."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mot_sim.datasets.boxes import RUN_FILE, tracks_of_boxes
from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from mot_sim.evaluation.run_folder import RunFolder, SequenceStatistics
from mot_sim.experiments.guests.exchange import read_seconds
from mot_sim.experiments.result_file import Made, Result, read_result, write_result
from mot_sim.experiments.sweep.store import SWEEP_FILE, SweepFolder, TrialOutcome
from mot_sim.simulation.episodes import EpisodeFolder
from mot_sim.tables import Table
from tests.fuzz.door import fuzz
from tests.fuzz.mutations import spoiled_json
from tests.fuzz.test_text_files import CAMERA
from tracker.types import Detections, Tracks

SETTINGS = {"detections": "rrc", "ego": "oxts", "nms": 0.5, "note": None}
KEY = "ab" * 16


def run_file(folder: Path) -> Path:
    with RunFolder.open(folder, SETTINGS, ["0000", "0001"]) as run:
        run.add("0000", Tracks.empty(), SequenceStatistics(3, 2, 1, 1, 0.1, stages={"boxes": 0.1}))
    return folder / RUN_FILE


def read_run(path: Path) -> None:
    """Both ways to go on; what `overwrite` removes lies in the folder."""
    for way in ({"resume": True}, {"overwrite": True}):
        found = RunFolder.open(path.parent, SETTINGS, ["0000", "0001"], **way)
        for name in (*found.stale, *found.finished):
            assert found.result(name).resolve().parent == path.parent.resolve()
            found.result(name).is_file()


def episodes_file(folder: Path) -> Path:
    EpisodeFolder.open(folder, SETTINGS, 2, 6).write()
    return folder / "episodes.json"


def read_episodes(path: Path) -> None:
    found = EpisodeFolder.open(path.parent, SETTINGS, 2, 6, overwrite=True)
    assert all(name.isdecimal() for name in found.stale)


def sweep_file(folder: Path) -> Path:
    SweepFolder.open(folder, {"axes": {"a": [1, 2]}, "seeds": 3})
    return folder / SWEEP_FILE


def read_sweep(path: Path) -> None:
    SweepFolder(path.parent).require_same({"axes": {"a": [1, 2]}, "seeds": 3}, extend=False)


def trial_file(folder: Path) -> Path:
    sweep = SweepFolder(folder)
    sweep.write(KEY, TrialOutcome({"HOTA": 0.5, "IDSW": 3}, None, 10, 9, 0.1), {"seed": 1})
    return sweep.trials.path(KEY)


def read_trial(path: Path) -> None:
    """A trial, or nothing: it is run again."""
    outcome = SweepFolder(path.parents[2]).read(KEY)
    assert outcome is None or isinstance(outcome.scores["HOTA"], float)


def seconds_file(folder: Path) -> Path:
    (folder / "seconds.json").write_text(json.dumps({"0000": 1.5}))
    return folder / "seconds.json"


def seconds(path: Path) -> None:
    none = DetectionLog(np.zeros(0, np.int64), Detections.empty())
    drive = RecordedSequence("0000", CAMERA, 4, none, np.arange(4))
    assert (read_seconds([drive], path.parent) or {}).get("0000", 0.0) >= 0.0


def result_file(folder: Path) -> Path:
    table = Table.of("t", "T", ("a", "a low"), ((1.0, None), ("x", 2)))
    return write_result(
        folder, Result("sweep", "S", Made("mot-sim", {"a": "1"}, "c"), (table,), ("a/b.png",))
    )


def coco_file(folder: Path) -> Path:
    entries = [
        {"image_id": 0, "category_id": 3, "bbox": [5, 8, 80.5, 60], "score": 0.9, "track_id": 4},
        {"image_id": 2, "category_id": 1, "bbox": [5, 8, 8, 60], "score": 1e-3, "track_id": 5},
    ]
    names = [{"id": 3, "name": "car"}, {"id": 1, "name": "person"}]
    path = folder / "results.json"
    path.write_text(json.dumps({"categories": names, "annotations": entries}))
    return path


def coco(path: Path) -> None:
    tracks = tracks_of_boxes(path)
    assert np.isfinite(tracks.boxes).all()


def read_results(path: Path) -> None:
    found = read_result(path.parent)
    for name in found.files:
        assert (path.parent / name).resolve().is_relative_to(path.parent.resolve())


DOORS: dict[str, tuple[Callable[[Path], Path], Callable[[Path], Any]]] = {
    "run.json": (run_file, read_run),
    "episodes.json": (episodes_file, read_episodes),
    "sweep.json": (sweep_file, read_sweep),
    "a trial": (trial_file, read_trial),
    "seconds.json": (seconds_file, seconds),
    "result.json": (result_file, read_results),
    "COCO's results": (coco_file, coco),
}


@pytest.mark.parametrize("name", DOORS)
def test_a_bad_json_file_is_read_or_refused(name: str, folder: Path) -> None:
    write, read = DOORS[name]
    path = write(folder)
    fuzz(path, path.read_bytes(), spoiled_json, read)
