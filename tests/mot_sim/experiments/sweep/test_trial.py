"""A trial: tracked, checked, scored; trackers that go wrong are named and never scored."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings, TrialSequence, drive_of
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.sweep.trial import run_trial
from mot_sim.metrics import evaluate_sequence
from tests.mot_sim.experiments.small import BARE
from tracker import Tracker, Tracks

ODD = "tests.mot_sim.experiments.odd"


def drive_under(folder: Path, **axes: float | str) -> TrialSequence:
    settings = {"scene.frames": 6, **BARE}
    settings |= {name.replace("__", "."): level for name, level in axes.items()}
    conditions = Conditions.of("crossing", settings)
    return drive_of(conditions, Recordings(folder).truth(conditions, 0), 0)


def test_a_trial_scores_what_the_tracker_gives(swept: tuple[Path, pa.Table]) -> None:
    drive = drive_under(swept[0])
    outcome = run_trial(TrackerSpec("default"), drive)
    tracker = Tracker.default(drive.sequence.camera)
    output = Tracks.concatenate([tracker.step(frame) for frame in drive.sequence])
    assert outcome.error is None
    assert outcome.scores == evaluate_sequence(drive.truth, output, 6).numbers()
    assert outcome.frames == 6
    assert outcome.cpu_seconds > 0.0


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("Raises", "frame 2: ZeroDivisionError: no car at all"),
        ("Leaves", "frame 0: SystemExit: 3"),
        ("GivesNaN", "frame 0: boxes that are not finite, of ids [4]"),
        ("Twice", "frame 0: ids that stand twice in a frame: [7]"),
        ("WrongShape", "frame 0: wrong shape: ids (2,), frames (2,), boxes (2, 5)"),
        ("Negative", "frame 0: ids below 0: [-1]"),
        ("Late", "frame 0: rows of another frame: [-1]"),
        (
            "GivesNothing",
            "frame 0: the tracker gave a NoneType, not Tracks: give",
        ),
    ],
)
def test_a_tracker_that_goes_wrong_is_named_and_has_no_scores(
    swept: tuple[Path, pa.Table], name: str, told: str
) -> None:
    outcome = run_trial(TrackerSpec("odd", f"{ODD}:{name}"), drive_under(swept[0]))
    assert str(outcome.error).startswith(told)
    assert outcome.scores == {}
    assert outcome.frames == (3 if name == "Raises" else 1)


def test_a_tracker_that_decides_later_is_asked_for_the_rest(swept: tuple[Path, pa.Table]) -> None:
    drive = drive_under(swept[0])
    now = run_trial(TrackerSpec("now", f"{ODD}:built"), drive)
    later = run_trial(TrackerSpec("later", f"{ODD}:Later"), drive)
    assert later.error is None
    assert later.scores == now.scores
    twice = run_trial(TrackerSpec("later", f"{ODD}:Later", {"twice": True}), drive)
    assert twice.error is not None
    assert twice.error.startswith("in the end: ids that stand twice in a frame: [")


def test_a_tracker_with_update_is_tracked_and_may_change_its_copy(
    swept: tuple[Path, pa.Table],
) -> None:
    drive = drive_under(swept[0])
    outcome = run_trial(TrackerSpec("odd", f"{ODD}:Updates"), drive)
    assert outcome.error is None
    assert outcome.scores["CLR_TP"] > 0
    assert outcome.scores["IDSW"] > 0  # everybody is new in every frame
    assert all(np.isfinite(frame.detections.boxes).all() for frame in drive.sequence)


def boxes_of(drive: TrialSequence) -> np.ndarray:
    return np.concatenate([frame.detections.boxes for frame in drive.sequence])


def test_levels_share_their_draws(swept: tuple[Path, pa.Table]) -> None:
    clean = {f"detector__{kind}": 0.0 for kind in ("misses", "clutter", "score_noise")}
    exact, one, two = (
        boxes_of(drive_under(swept[0], **clean, detector__jitter=level, **{"border__snap": 0.0}))
        for level in (0.0, 1.0, 2.0)
    )
    inside = (one > 1.0).all(axis=1) & (two > 1.0).all(axis=1) & (two[:, 2] < 1240)
    inside &= (two[:, 3] < 373) & (one[:, 2] < 1240) & (exact[:, 2] < 1240) & (exact[:, 0] > 1)
    middle = [0.5 * (boxes[inside, 0] + boxes[inside, 2]) for boxes in (exact, one, two)]
    assert inside.sum() >= 5
    assert np.abs(middle[1] - middle[0]).max() > 0.1
    np.testing.assert_allclose(middle[2] - middle[0], 2.0 * (middle[1] - middle[0]), atol=1e-9)


def test_a_lower_frame_rate_delivers_and_scores_fewer_frames(
    swept: tuple[Path, pa.Table],
) -> None:
    half = drive_under(swept[0], rig__frame_rate=5.0)
    frames = list(half.sequence)
    assert [frame.index for frame in frames] == [0, 2, 4]
    assert [frame.time for frame in frames] == pytest.approx([0.0, 0.2, 0.4])
    assert set(half.truth.frames.tolist()) <= {0, 2, 4}
    assert len(half.truth) < len(drive_under(swept[0]).truth)


def test_camera_and_motion_errors_reach_the_tracker(swept: tuple[Path, pa.Table]) -> None:
    right = drive_under(swept[0])
    wrong = drive_under(swept[0], rig__pitch_error_deg=1.0, odometry__scale=0.5)
    np.testing.assert_array_equal(boxes_of(right), boxes_of(wrong))
    assert not np.allclose(right.sequence.camera.T_cam_road, wrong.sequence.camera.T_cam_road)
    motions = [[frame.T_now_before for frame in drive.sequence][1] for drive in (right, wrong)]
    assert motions[0] is not None
    assert motions[1] is not None
    shift = [np.linalg.norm(T[:3, 3]) for T in motions]
    assert shift[1] == pytest.approx(1.5 * shift[0])


def test_a_trial_scores_cuboids_when_it_is_asked_to(swept: tuple[Path, pa.Table]) -> None:
    drive = drive_under(swept[0])
    outcome = run_trial(TrackerSpec("default"), drive, spatial=True)
    tracker = Tracker.default(drive.sequence.camera)
    output = Tracks.concatenate([tracker.step(frame) for frame in drive.sequence])
    expected = drive.spatial_scores(output).numbers()
    assert outcome.error is None
    assert outcome.scores["centre_median"] == expected["centre_median"]
    assert outcome.scores["MOTA3D@2m"] == expected["MOTA3D@2m"]
    known = {name for name, value in expected.items() if not np.isnan(value)}
    assert outcome.scores.keys() >= known
    assert not {name for name, value in expected.items() if np.isnan(value)} & outcome.scores.keys()


def test_the_true_cuboids_are_perfect_output(swept: tuple[Path, pa.Table]) -> None:
    drive = drive_under(swept[0])
    cars = drive.truth.ids >= 0
    numbers = drive.spatial_scores(drive.truth.select(cars)).numbers()
    assert numbers["centre_median"] == 0.0
    assert numbers["MOTA3D@0.7"] == 1.0
    assert numbers["heading_over_30"] == 0.0


def test_a_tracker_without_cuboids_cannot_be_scored_in_3d(swept: tuple[Path, pa.Table]) -> None:
    spec = TrackerSpec.parse(f"flat={ODD}:Boxes")
    outcome = run_trial(spec, drive_under(swept[0]), spatial=True)
    assert outcome.error is not None
    assert "scoring: BadTracks: output:" in outcome.error
    assert run_trial(spec, drive_under(swept[0])).error is None
