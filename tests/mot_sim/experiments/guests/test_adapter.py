"""The program that runs the package `trackers`, with a small stand-in for the package."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from mot_sim.datasets import RecordedSequence
from mot_sim.experiments.guests.exchange import read_guest_results, read_seconds, write_detections
from mot_sim.experiments.guests.register import ADAPTER, GUESTS

SUPERVISION = """
class Detections:
    def __init__(self, xyxy, confidence, class_id, tracker_id=None):
        self.xyxy, self.confidence = xyxy, confidence
        self.class_id, self.tracker_id = class_id, tracker_id
    def __len__(self):
        return len(self.xyxy)
    @classmethod
    def empty(cls):
        import numpy as np
        return cls(np.zeros((0, 4)), np.zeros(0), np.zeros(0, dtype=int))
"""
# Numbers the boxes from -1 on: the first one of a frame belongs to no track.
TRACKERS = """
import numpy as np
class SORTTracker:
    made = 0
    def __init__(self, frame_rate=30.0, first=-1):
        assert frame_rate == 10.0
        self.first = first
    def update(self, detections):
        sum(range(10_000))
        detections.tracker_id = np.arange(len(detections)) + self.first
        return detections
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A folder from which the stand-ins are imported."""
    folder = tmp_path / "package"
    folder.mkdir()
    (folder / "supervision.py").write_text(SUPERVISION)
    (folder / "trackers.py").write_text(TRACKERS)
    return folder


def adapt(package: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    """The program, with the stand-ins in the place of the packages."""
    return subprocess.run(
        [sys.executable, "-P", ADAPTER, *arguments],
        env={"PYTHONPATH": str(package)},
        capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip


def test_rows_of_tracks_are_written_and_the_calls_are_timed(
    drives: list[RecordedSequence], package: Path, tmp_path: Path
) -> None:
    results = tmp_path / "results"
    results.mkdir()
    shown = [drives[0].subset([0, 1, 3]), drives[1]]
    write_detections(shown, 0.0, tmp_path)
    done = adapt(package, "sort", str(tmp_path), str(results))
    assert done.returncode == 0, done.stderr
    tracks = read_guest_results(shown, results)["a"]
    assert tracks.frames.tolist() == [0, 1, 1, 3]
    assert tracks.ids.tolist() == [0, 0, 1, 0]
    assert tracks.boxes[0].tolist() == [700.0, 190.0, 760.0, 230.0]
    assert tracks.scores is not None
    assert tracks.scores.tolist() == [0.9, 0.9, 0.2, 0.9]
    seconds = read_seconds(shown, results)
    assert seconds is not None
    assert all(0.0 < each < 1.0 for each in seconds.values())


def test_parameters_reach_the_tracker_and_wrong_ones_are_named(
    drives: list[RecordedSequence], package: Path, tmp_path: Path
) -> None:
    write_detections(drives, 0.3, tmp_path)
    done = adapt(package, "sort", str(tmp_path), str(package), "first=5")
    assert done.returncode == 0, done.stderr
    assert (package / "a.txt").read_text().startswith("0 5 500.0 ")
    wrong = adapt(package, "sort", str(tmp_path), str(package), "frist=5")
    assert wrong.returncode == 1
    assert "sort has no parameter 'frist'; it has frame_rate, first" in wrong.stderr


def test_it_imports_nothing_of_ours() -> None:
    imported = [
        line.split()[1]
        for line in Path(ADAPTER).read_text().splitlines()
        if line.startswith(("import ", "from "))
    ]
    assert "json" in imported
    assert not {name.partition(".")[0] for name in imported} & {"mot_sim", "tracker", "scenes"}


def test_every_guest_of_the_package_is_known_to_the_program() -> None:
    code = "import json, runpy, sys; print(json.dumps(runpy.run_path(sys.argv[1])['CLASSES']))"
    done = subprocess.run(
        [sys.executable, "-c", code, ADAPTER],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert set(json.loads(done.stdout)) == set(GUESTS)


def test_live_it_answers_frame_by_frame(package: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-P", ADAPTER, "sort", "live", "first=3"],
        env={"PYTHONPATH": str(package)},
        input="10.0\n[[1, 2, 3, 4, 0.5]]\n[]\n[[1, 2, 3, 4, 0.5], [5, 6, 7, 8, 0.25]]\n",
        capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert [json.loads(line) for line in done.stdout.splitlines()] == [
        [[3, 1.0, 2.0, 3.0, 4.0, 0.5]],
        [],
        [[3, 1.0, 2.0, 3.0, 4.0, 0.5], [4, 5.0, 6.0, 7.0, 8.0, 0.25]],
    ]
