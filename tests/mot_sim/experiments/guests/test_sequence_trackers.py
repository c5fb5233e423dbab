"""Trackers over whole drives: ours, the baselines and guests."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import RecordedSequence
from mot_sim.experiments.guests import (
    BASELINES,
    ExternalSequenceTracker,
    ExternalTrackerFailed,
    OwnTracker,
    SequenceTracker,
    find_sequence_tracker,
)
from mot_sim.experiments.guests.sequence_trackers import UNTIMED_FRAMES
from tests.mot_sim.experiments.guests.conftest import CAMERA, truth_of
from tests.mot_sim.experiments.guests.programs import guest
from tracker import Tracker, Tracks
from tracker.errors import BadConfig, OutputExists, UnknownName
from tracker.types import Detections, Frame


@pytest.mark.parametrize("name", ["default", "paper", "iou", "iou-greedy"])
def test_our_own_are_contestants(name: str, drives: list[RecordedSequence]) -> None:
    contestant = find_sequence_tracker(name)
    assert isinstance(contestant, SequenceTracker)
    outcome = contestant.track(drives)
    assert list(outcome.tracks) == ["a", "b"]
    for drive in drives:
        truth, tracks = truth_of(drive), outcome.tracks[drive.name]
        assert tracks.frames.tolist() == truth.frames.tolist()
        assert len(set(tracks.ids.tolist())) == 2
    assert outcome.seconds is not None
    assert all(seconds > 0.0 for seconds in outcome.seconds.values())
    assert 0.2 < outcome.min_score < 0.9


def test_kernels_are_loaded_before_the_clock_runs(
    drives: list[RecordedSequence], monkeypatch: pytest.MonkeyPatch
) -> None:
    seen, step = [], Tracker.step

    def watched(tracker: Tracker, frame: Frame) -> Tracks:
        seen.append(frame.index)
        return step(tracker, frame)

    monkeypatch.setattr(Tracker, "step", watched)
    outcome = find_sequence_tracker("paper").track(drives)
    first, second = (list(range(len(drive))) for drive in drives)
    assert len(first) < UNTIMED_FRAMES
    assert seen == [*first, *first, *second]
    assert outcome.tracks["a"].ids.min() == 0


def test_a_guest_is_a_contestant(drives: list[RecordedSequence], programs: Path) -> None:
    contestant = find_sequence_tracker("good", {"good": guest(programs, "good")})
    assert isinstance(contestant, SequenceTracker)
    outcome = contestant.track(drives)
    for drive in drives:
        truth, tracks = truth_of(drive), outcome.tracks[drive.name]
        np.testing.assert_allclose(tracks.boxes, truth.boxes)
        assert (tracks.ids == truth.ids - 7).all()
    assert outcome.seconds == {"a": 0.5, "b": 0.5}


def test_the_exchanged_files_stay_where_they_are_wanted(
    drives: list[RecordedSequence], programs: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "kept"
    ExternalSequenceTracker(guest(programs, "good"), folder).track(drives)
    kept = sorted(str(path.relative_to(folder)) for path in folder.rglob("*.*"))
    assert kept == [
        "detections/a.txt", "detections/b.txt", "detections/sequences.json",
        "results/a.txt", "results/b.txt", "results/seconds.json",
    ]  # fmt: skip
    with pytest.raises(OutputExists):
        ExternalSequenceTracker(guest(programs, "good"), folder).track(drives)


def test_a_crash_is_told_with_stderr(drives: list[RecordedSequence], programs: Path) -> None:
    with pytest.raises(ExternalTrackerFailed, match="guest crashes: exit status 1") as caught:
        ExternalSequenceTracker(guest(programs, "crashes")).track(drives)
    assert caught.value.stderr.startswith("reading the boxes")
    assert caught.value.stderr.endswith("ValueError: no such weights")


def test_rubbish_is_told_with_its_line_and_stderr(
    drives: list[RecordedSequence], programs: Path
) -> None:
    with pytest.raises(
        ExternalTrackerFailed, match=r"guest rubbish: .*a\.txt:9: frame beyond"
    ) as caught:
        ExternalSequenceTracker(guest(programs, "rubbish", "9 1 5 5 9 9 0.5")).track(drives)
    assert caught.value.stderr == "all well"


def test_two_drives_of_one_name_are_refused(drives: list[RecordedSequence], programs: Path) -> None:
    with pytest.raises(BadConfig, match="two drives are named 'a'"):
        ExternalSequenceTracker(guest(programs, "good")).track([drives[0], drives[0]])


def test_an_unknown_tracker_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownName, match=r"unknown tracker 'oc_sort'.*Did you mean 'oc-sort'"):
        find_sequence_tracker("oc_sort")


def test_the_baseline_matches_by_overlap_from_frame_to_frame_alone() -> None:
    tracker = BASELINES["iou"](CAMERA)

    def step(index: int, *boxes: tuple[float, float, float, float]) -> list[int]:
        seen = Detections.of(boxes, np.full(len(boxes), 0.9))
        return tracker.step(Frame(index, 0.1 * index, seen)).ids.tolist()

    assert step(0, (500.0, 190.0, 560.0, 230.0)) == [0]
    assert step(1, (530.0, 190.0, 590.0, 230.0)) == [0]  # IoU 1 / 3
    assert step(2, (564.0, 190.0, 624.0, 230.0)) == [1]  # IoU 26 / 94 = 0.28
    assert step(3) == []
    assert step(4, (564.0, 190.0, 624.0, 230.0)) == [2]  # no memory


def test_the_baselines_are_not_told_how_the_camera_moved(drives: list[RecordedSequence]) -> None:
    seen = []

    class Watching(type(BASELINES["iou"](CAMERA))):  # type: ignore[misc]
        def step(self, frame: Frame) -> object:
            seen.append((frame.T_now_before is None, frame.motion_cov is None))
            return super().step(frame)

    moving = RecordedSequence(
        "m", CAMERA, 4, drives[0].log, np.arange(4), np.tile(np.eye(4), (4, 1, 1)), np.eye(6)
    )
    made = BASELINES["iou"](CAMERA)
    for uses_motion in (False, True):
        watching = Watching(**{name: getattr(made, name) for name in made.__dataclass_fields__})
        OwnTracker("w", lambda *_, w=watching: w, uses_motion).track([moving])
    assert seen[:4] == [(True, True)] * 4
    assert seen[5:] == [(False, False)] * 3
