"""The program that runs guests, and what it knows of their packages, with small stand-ins."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from mot_sim.datasets import RecordedSequence
from mot_sim.experiments.guests.exchange import read_guest_results, read_seconds, write_detections
from mot_sim.foreign.protocol import LIBRARIES
from mot_sim.foreign.register import ADAPTER, GUESTS

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
# Tracks are numbered from 1 and a pixel behind; the third box's is inside out, and a track of
# yesterday has no living point.
NORFAIR = """
import numpy as np
class Detection:
    def __init__(self, points, scores, data):
        assert points.shape == (2, 2)
        self.points, self.scores, self.data = points, scores, data
class Tracked:
    def __init__(self, number, detection, is_alive=True):
        self.id, self.last_detection = number, detection
        self.live_points = np.full(2, is_alive)
        self.estimate = detection.points - 1.0
class Tracker:
    def __init__(self, distance_function, distance_threshold):
        assert (distance_function, distance_threshold) == ("iou", 0.8)
    def update(self, detections):
        answer = [Tracked(number + 1, each) for number, each in enumerate(detections)]
        for tracked in answer[2:]:
            tracked.estimate = tracked.estimate[::-1]
        return [*answer, Tracked(9, Detection(np.ones((2, 2)), np.ones(2), 1.0), False)]
"""
# Tracks are named in letters, the last box's first.
MOTPY = """
from collections import namedtuple
Track = namedtuple("Track", "id box score class_id")
class Detection:
    def __init__(self, box, score):
        self.box, self.score = box, score
class MultiObjectTracker:
    def __init__(self, dt, model_spec=None):
        assert (dt, model_spec) == (0.1, {"q_var_pos": 10.0})
    def step(self, detections):
        named = [Track("abc"[i], each.box, each.score, None) for i, each in enumerate(detections)]
        return named[::-1]
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A folder from which the stand-ins are imported."""
    folder = tmp_path / "package"
    folder.mkdir()
    (folder / "supervision.py").write_text(SUPERVISION)
    (folder / "trackers.py").write_text(TRACKERS)
    (folder / "norfair.py").write_text(NORFAIR)
    (folder / "motpy.py").write_text(MOTPY)
    return folder


def adapt(package: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    """The program, with the stand-ins in the place of the packages."""
    return subprocess.run(
        [sys.executable, "-P", ADAPTER, *arguments],
        env={"PYTHONPATH": str(package)},
        input="10.0\n",
        capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip


def test_rows_of_tracks_are_written_and_the_calls_are_timed(
    drives: list[RecordedSequence], package: Path, tmp_path: Path
) -> None:
    results = tmp_path / "results"
    results.mkdir()
    shown = [drives[0].subset([0, 1, 3]), drives[1]]
    write_detections(shown, 0.0, tmp_path)
    done = adapt(package, "trackers:SORTTracker", str(tmp_path), str(results))
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
    done = adapt(package, "trackers:SORTTracker", str(tmp_path), str(package), "first=5")
    assert done.returncode == 0, done.stderr
    assert (package / "a.txt").read_text().startswith("0 5 500.0 ")
    wrong = adapt(package, "trackers:SORTTracker", str(tmp_path), str(package), "frist=5")
    assert wrong.returncode == 1
    assert "SORTTracker has no parameter 'frist'; it has frame_rate, first" in wrong.stderr


def test_a_package_that_is_missing_is_told_with_the_cure(package: Path) -> None:
    (package / "norfair.py").write_text("import mot_sim_nowhere\n")
    done = adapt(package, "norfair:Tracker", "live")
    assert done.returncode == 1
    told = f"No module named 'mot_sim_nowhere'; the environment of {sys.executable} is damaged"
    assert done.stderr.startswith(told)
    assert done.stderr.count("\n") == 1


def test_they_import_nothing_of_ours() -> None:
    for path in Path(ADAPTER).parent.glob("*.py"):
        imported = [
            line.split()[1]
            for line in path.read_text().splitlines()
            if line.startswith(("import ", "from "))
        ]
        assert not {name.partition(".")[0] for name in imported} & {"mot_sim", "tracker", "scenes"}


def test_every_guest_has_the_file_of_its_package() -> None:
    packages = {guest.command[3].partition(":")[0] for guest in GUESTS.values()}
    files = {path.stem for path in Path(ADAPTER).parent.glob("*_package.py")}
    assert packages < set(LIBRARIES)
    assert {f"{name}_package" for name in LIBRARIES} == files


def live(package: Path, boxes: str, *arguments: str) -> list[list[list[float]]]:
    """The answers of the program that is told 10 Hz and these boxes, a line a frame."""
    done = subprocess.run(
        [sys.executable, "-P", ADAPTER, *arguments],
        env={"PYTHONPATH": str(package)},
        input=f"10.0\n{boxes}",
        capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


FRAMES = "[[1, 2, 3, 4, 0.5]]\n[]\n[[1, 2, 3, 4, 0.5], [5, 6, 7, 8, 0.25]]\n"


def test_live_it_answers_frame_by_frame(package: Path) -> None:
    assert live(package, FRAMES, "trackers:SORTTracker", "live", "first=3") == [
        [[3, 1.0, 2.0, 3.0, 4.0, 0.5]],
        [],
        [[3, 1.0, 2.0, 3.0, 4.0, 0.5], [4, 5.0, 6.0, 7.0, 8.0, 0.25]],
    ]


def test_norfair_is_given_corners_and_answers_with_what_it_would_draw(package: Path) -> None:
    boxes = "[[1, 2, 3, 4, 0.5], [5, 6, 7, 8, 0.25], [9, 9, 10, 10, 0.75]]\n"
    assert live(package, boxes, "norfair:Tracker", "live", "distance_threshold=0.8") == [
        [[1, 0.0, 1.0, 2.0, 3.0, 0.5], [2, 4.0, 5.0, 6.0, 7.0, 0.25]]
    ]


def test_motpy_is_given_the_time_between_frames_and_its_names_are_numbered(package: Path) -> None:
    setting = 'model_spec={"q_var_pos": 10.0}'
    assert live(package, FRAMES, "motpy:MultiObjectTracker", "live", setting) == [
        [[0, 1.0, 2.0, 3.0, 4.0, 0.5]],
        [],
        [[1, 5.0, 6.0, 7.0, 8.0, 0.25], [0, 1.0, 2.0, 3.0, 4.0, 0.5]],
    ]
