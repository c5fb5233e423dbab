"""Trackers in processes of their own: what they do there is named, and ends with them."""

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mot_sim.__main__ import main
from mot_sim.experiments.sweep.running import sweep
from mot_sim.experiments.sweep.store import SweepFolder
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.foreign.isolation import (
    IsolatedTracker,
    Isolation,
    TrackerStopped,
    close_tracker,
    steps_of,
)
from mot_sim.simulation.rig import Rig
from tests.mot_sim.experiments.guests.test_processes import is_alive
from tests.mot_sim.experiments.small import BARE, numbers, small_design, trial_files
from tests.mot_sim.foreign.misbehaving import KINDS, NOTE
from tracker import Detections, Frame, Tracker
from tracker.errors import BadConfig

HERE = "tests.mot_sim.foreign.misbehaving"
CAMERA = Rig.kitti().camera
LIMITS = Isolation(time_limit=60.0, memory_limit=300.0)
FRAMES = [
    Frame(i, 0.1 * i, Detections.of([[10.0, 20, 90, 80]]) if i != 2 else Detections.empty())
    for i in range(5)
]


def spec(name: str) -> TrackerSpec:
    limits = replace(LIMITS, time_limit=1.0) if name == "Hangs" else LIMITS
    return replace(TrackerSpec.parse(f"{name}={HERE}:{name}"), isolation=limits)


def forty_trials(jobs: int, folder: Path | None = None) -> list[dict[str, Any]]:
    """Eight trackers at five points; each misbehaves at the one without any detections."""
    design = small_design(
        axes={"detector.misses": (1e6,), "odometry.drift": (0.0, 0.1, 0.2, 0.3)},
        mode="one_at_a_time", fixed={**BARE, "detector.clutter": 0.0}, seeds=1, frames=5,
        trackers=tuple(spec(kind) for kind in KINDS),
    )  # fmt: skip
    return numbers(sweep(design, folder, jobs=jobs)).to_pylist()


def test_of_forty_trials_the_eight_that_misbehave_are_named_and_nothing_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    note = tmp_path / "pid"
    monkeypatch.setenv(NOTE, str(note))
    rows = forty_trials(1, tmp_path / "sweep")
    failed = {row["tracker"]: row["error"] for row in rows if row["error"] is not None}
    assert (len(rows), sum(row["error"] is None for row in rows)) == (40, 32)
    assert failed.keys() == KINDS.keys()
    for kind, told in KINDS.items():
        assert failed[kind].startswith(told)
    assert all(row["HOTA"] > 0.0 for row in rows if row["error"] is None)
    for _ in range(100):
        if not is_alive(int(note.read_text())):
            break
        time.sleep(0.02)
    else:
        pytest.fail("a copy outlives its tracker")
    kept = SweepFolder(tmp_path / "sweep")
    said = [kept.read(path.stem) for path in trial_files(kept.path)]
    assert "no licence" in {one.output for one in said if one is not None}


@pytest.mark.slow
def test_the_table_is_the_same_for_two_jobs() -> None:
    assert forty_trials(2) == forty_trials(1)


@pytest.mark.slow
def test_a_tracker_that_kills_its_worker_does_not_end_the_sweep() -> None:
    killer = replace(spec("IsKilled"), isolation=Isolation("none"))
    design = small_design(
        axes={"detector.misses": (1e6,), "odometry.drift": (0.0,)}, mode="one_at_a_time",
        seeds=2, frames=5, fixed={**BARE, "detector.clutter": 0.0}, trackers=(killer,),
    )  # fmt: skip
    rows = sweep(design, jobs=2).to_pylist()
    assert [row["error"] for row in rows] == [
        *["the process of the trial died, and died again"] * 2, None, None,
    ]  # fmt: skip


def test_a_copy_that_a_tracker_makes_of_itself_changes_nothing() -> None:
    tracker = spec("Copies").start(CAMERA)
    assert isinstance(tracker, IsolatedTracker)
    came: list[int] = []
    answers = list(steps_of(tracker, FRAMES, lambda frame: came.append(frame.index)))
    assert [len(each) for each in answers] == [1, 1, 0, 1, 1]
    assert came == [0, 1, 2, 3, 4]
    assert tracker.cpu_seconds > 0.0
    close_tracker(tracker)
    with pytest.raises(Exception, match="stopped before"):
        tracker.step(FRAMES[0])


def test_memory_that_copies_share_is_counted_once() -> None:
    limits = Isolation(memory_limit=100.0)  # less than any process of Python with NumPy holds
    shares = replace(spec("WaitsForCopies"), isolation=limits).start(CAMERA)
    assert len(shares.step(FRAMES[2])) == 0
    close_tracker(shares)
    eats = replace(spec("WaitsForEatingCopies"), isolation=limits).start(CAMERA)
    with pytest.raises(TrackerStopped, match="more than 100 MB"):
        eats.step(FRAMES[2])


def drive_of_one(index: int) -> tuple[int, str]:
    """The process that a tracker runs in for a frame, and what it printed."""
    tracker = spec("Remembers").start(CAMERA)
    assert isinstance(tracker, IsolatedTracker)
    pid = int(tracker.step(replace(FRAMES[0], index=index)).ids[0])
    return pid, close_tracker(tracker)


def test_a_process_serves_one_trial_after_another_until_something_of_one_stays() -> None:
    first, said = drive_of_one(0)
    again, said_again = drive_of_one(0)
    assert again == first
    assert said.split()[:2] == ["made", "0"]
    assert said_again.split()[:2] == ["made", "1"]
    assert said.split()[2] == said_again.split()[2]  # the numbers that it draws
    for left_behind in (7, 8):  # a process, memory
        assert drive_of_one(left_behind)[0] == again
        again, said = drive_of_one(0)
        assert said.split()[:2] == ["made", "0"]


def test_a_process_from_other_circumstances_serves_nobody(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first, _ = drive_of_one(0)
    monkeypatch.setenv("A_SETTING", "other")
    other, said = drive_of_one(0)
    assert (other != first, said.split()[1]) == (True, "0")


def test_ours_give_the_same_rows_in_a_process_of_their_own() -> None:
    spec = replace(TrackerSpec("default"), isolation=Isolation("all"))
    apart = spec.start(CAMERA)
    assert isinstance(apart, IsolatedTracker)
    here = Tracker.default(CAMERA)
    for frame in FRAMES:
        mine, theirs = here.step(frame), apart.step(frame)
        assert mine.ids.tolist() == theirs.ids.tolist()
        assert mine.boxes.tolist() == theirs.boxes.tolist()
    assert isinstance(TrackerSpec("default").start(CAMERA), Tracker)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"time_limit": 0.0}, "--time-limit 0: give seconds above 0"),
        ({"time_limit": -1.0}, "--time-limit -1"),
        ({"memory_limit": 0.0}, "--memory-limit 0: give megabytes above 0"),
        ({"memory_limit": float("nan")}, "--memory-limit nan"),
    ],
)
def test_limits_that_cannot_be_are_refused(given: dict[str, float], told: str) -> None:
    with pytest.raises(BadConfig, match=told):
        Isolation(**given)


SUITE = """
[easy]
about = "an open road"
scene = "crossing"
frames = 5
settings = { "scene.houses" = 0.0, "scene.trees" = 0.0, "scene.furniture" = 0.0 }
bounds = { hota = 0.01 }
"""
LOUD = """
import os
print("weights are loaded")
os.write(1, b"below Python\\n")
class Mine:
    def update(self, boxes, scores):
        print("a frame")
        return [[*box, number] for number, box in enumerate(boxes)]
class Broken:
    def __init__(self):
        raise ModuleNotFoundError("No module named 'torch'")
"""


def test_a_module_that_prints_at_import_is_heard_with_v_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "loud.py").write_text(LOUD)
    (tmp_path / "suites.toml").write_text(SUITE)
    monkeypatch.chdir(tmp_path)
    line = ["stress", "--file", "suites.toml", "--seeds", "1", "--out", "out"]
    assert main([*line, "--trackers", "mine=loud:Mine"]) == 0
    told = capfd.readouterr()
    assert "weights" not in told.out + told.err
    assert "below" not in told.out + told.err
    line[-1] = "again"
    assert main([*line, "-v", "--trackers", "mine=loud:Mine"]) == 0
    told = capfd.readouterr()
    assert "info: mine, seed 0: weights are loaded" in told.err
    assert told.err.count("mine, seed 0: a frame") == 5
    assert "weights" not in told.out


def test_a_constructor_that_raises_fails_its_tracker_and_the_others_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "loud2.py").write_text(LOUD)
    (tmp_path / "suites.toml").write_text(SUITE)
    monkeypatch.chdir(tmp_path)
    line = ["stress", "--file", "suites.toml", "--seeds", "1", "--trackers"]
    names = f"b=loud2:Broken,c={HERE}:CannotBeMade,mine=loud2:Mine"
    for more in ([], ["--no-isolate"]):
        assert main([*line, names, *more]) == 1
        told = capfd.readouterr()
        rows = [row.split()[:3] for row in told.out.splitlines()]
        assert [row for row in rows if row[0] in ("pass", "FAIL")] == [
            ["FAIL", "easy", "b"], ["FAIL", "easy", "c"], ["pass", "easy", "mine"],
        ]  # fmt: skip
        assert "cannot be built: ModuleNotFoundError: No module named 'torch'" in told.err
        assert "cannot be built: RuntimeError: no weights" in told.err
    assert main([*line, "mine=loud2:Mine", "--isolate", "--no-isolate"]) == 2
    assert "exclude each other" in capfd.readouterr().err
