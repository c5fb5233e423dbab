"""Trackers by name over sequences, from Python."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import DetectionLog, RecordedSequence
from mot_sim.evaluation.run_folder import RunFolder, SequenceStatistics
from mot_sim.evaluation.runs import Recipe, parse_costs, track_sequence, track_sequences
from tests.tracker.motion_check.test_motion_check import frames_of, moved, straight
from tests.tracker.samples import LEVEL
from tracker import Camera, Delayed, Detections, Tracks
from tracker.association import ASSOCIATIONS, Greedy
from tracker.costs import COSTS
from tracker.errors import BadConfig, BadFile, OutputExists
from tracker.geometry import invert

CAMERA = Camera.mounted(
    np.array([[700.0, 0.0, 600.0], [0.0, 700.0, 180.0], [0.0, 0.0, 1.0]]), (1242, 375), 1.65
)


def drive(name: str, frame_count: int = 3) -> RecordedSequence:
    """A drive that sees one car, standing still, in every frame, with all cues."""
    boxes = np.tile([500.0, 200.0, 560.0, 240.0], (frame_count, 1))
    frames = np.arange(frame_count)
    looks = {"yaw": np.zeros(frame_count), "shape": np.zeros((frame_count, 2))}
    looks["descriptor"] = np.zeros((frame_count, 3))
    log = DetectionLog(frames, Detections(boxes, np.ones(frame_count), **looks))
    return RecordedSequence(name, CAMERA, frame_count, log, frames)


def test_a_recipe_changes_only_what_it_names() -> None:
    plain, changed = Recipe().build(CAMERA), Recipe("default", {"volume": 2.0}, "greedy")
    tracker = changed.build(CAMERA)
    assert [(weight, type(cost)) for weight, cost in tracker.costs] == [(2.0, COSTS["volume"])]
    assert isinstance(tracker.associate, Greedy)
    assert tracker.associate.max_cost == plain.associate.max_cost
    assert tracker.lifecycle == plain.lifecycle


@pytest.mark.parametrize("associate", ASSOCIATIONS)
@pytest.mark.parametrize("cost", COSTS)
def test_every_cost_and_association_can_be_chosen_by_name(cost: str, associate: str) -> None:
    tracks, counts = track_sequence(
        Recipe("paper", {cost: 1.0}, associate).build(CAMERA), drive("a")
    )
    assert tracks.ids.tolist() == [0, 0, 0]
    assert (counts.frames, counts.detections, counts.rows, counts.ids) == (3, 3, 3, 1)


def test_weights_are_read_as_the_command_line_writes_them() -> None:
    assert parse_costs("volume=0.6, reprojection = 0.4") == {"volume": 0.6, "reprojection": 0.4}
    assert parse_costs("volume") == {"volume": 1.0}
    with pytest.raises(BadConfig, match="above 0"):
        Recipe(costs={"volume": 0.0})


def test_every_sequence_gets_a_tracker_of_its_own() -> None:
    seen = []
    run = track_sequences(
        [drive("a"), drive("b")], Recipe().build, progress=lambda *args: seen.append(args)
    )
    assert {name: tracks.ids.tolist() for name, tracks in run.tracks.items()} == {
        "a": [0, 0, 0],
        "b": [0, 0, 0],
    }
    assert seen == [("a", 1), ("a", 2), ("a", 3), ("b", 1), ("b", 2), ("b", 3)]


def test_a_drive_without_frames_gives_no_rows(tmp_path: Path) -> None:
    with RunFolder.open(tmp_path / "out", {}, ["a"]) as folder:
        run = track_sequences([drive("a", 0)], Recipe().build, folder)
    assert len(run.tracks["a"]) == 0
    assert (tmp_path / "out" / "a.txt").read_text() == ""
    assert track_sequences([], Recipe().build).frames_per_second is None


def test_an_entered_folder_takes_back_what_it_made_when_nothing_is_finished(
    tmp_path: Path,
) -> None:
    counts = SequenceStatistics(0, 0, 0, 0, 0.0)

    def fail_after(finished: list[str]) -> None:
        with RunFolder.open(tmp_path / "a" / "b", {}, ["x", "y"]) as folder:
            for name in finished:
                folder.add(name, Tracks.empty(), counts)
            assert (tmp_path / "a" / "b" / "run.json").is_file()
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_after([])
    assert not (tmp_path / "a").exists()
    with pytest.raises(RuntimeError):
        fail_after(["x"])
    assert (tmp_path / "a" / "b" / "x.txt").is_file()
    with pytest.raises(OutputExists, match="--resume"):
        RunFolder.open(tmp_path / "a" / "b", {}, ["x", "y"])
    again = RunFolder.open(tmp_path / "a" / "b", {}, ["x", "y"], resume=True)
    assert again.finished == {"x": counts}


@pytest.mark.parametrize("associate", ["hungarian", "window"])
def test_boxes_that_contradict_the_motion_are_logged_once_and_kept(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, associate: str
) -> None:
    frames = moved(frames_of(straight), invert)
    log = DetectionLog(
        np.repeat([frame.index for frame in frames], [len(frame.found) for frame in frames]),
        Detections.concatenate([frame.found for frame in frames]),
    )
    poses = [np.eye(4)]
    for frame in frames[1:]:
        assert frame.T_now_before is not None
        poses.append(poses[-1] @ invert(frame.T_now_before))
    wrong = RecordedSequence(
        "wrong", LEVEL, len(frames), log, np.arange(len(frames)), np.array(poses)
    )
    folder = RunFolder.open(tmp_path / "run", {}, ["wrong", "a"])
    with folder:
        run = track_sequences([wrong, drive("a")], Recipe(associate=associate).build, folder)
    told = run.counts["wrong"].contradiction
    assert told is not None
    assert "world-to-camera" in told
    assert [record.message for record in caplog.records] == [f"wrong: {told}"]
    assert run.counts["a"].contradiction is None
    again = RunFolder.open(tmp_path / "run", {}, ["wrong", "a"], resume=True)
    assert again.finished["wrong"].contradiction == told
    assert again.finished["a"].contradiction is None


def test_a_contradiction_that_is_no_text_is_refused(tmp_path: Path) -> None:
    with RunFolder.open(tmp_path / "run", {}, ["a"]) as folder:
        track_sequences([drive("a")], Recipe().build, folder)
    path = tmp_path / "run" / "run.json"
    path.write_text(path.read_text().replace('"contradiction": null', '"contradiction": 3'))
    with pytest.raises(BadFile, match="contradiction is 3"):
        RunFolder.open(tmp_path / "run", {}, ["a"], resume=True)


def test_a_lag_makes_a_window_of_the_tracker() -> None:
    window = Recipe(lag=4).build(CAMERA)
    assert isinstance(window, Delayed)
    assert window.lag == 4
    tracks, _ = track_sequence(window, drive("a"))
    assert tracks.estimates is not None
    with pytest.raises(BadConfig, match="lag -1"):
        Recipe(lag=-1)
    with pytest.raises(BadConfig, match="only the window"):
        Recipe(associate="network_flow", lag=4)
