"""Odometry, calibration, timing, weather."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from mot_sim.simulation.sensors import (
    WEATHERS,
    Autocorrelation,
    Detector,
    Miscalibration,
    Odometry,
    Timing,
    find_profile,
    in_weather,
)
from tests.mot_sim.simulation.sensors.sights import CAMERA, STEP, crowd
from tracker.errors import BadConfig, UnknownName
from tracker.geometry import homogeneous
from tracker.types import Detections, Sequence

SLOW = Autocorrelation((1.0,), (1.0,))


def straight(count: int = 100) -> np.ndarray:
    """A metre forward a frame."""
    return np.array([homogeneous(np.eye(3), np.array([0.0, 0.0, float(i)])) for i in range(count)])


def drive(count: int = 50) -> RecordedSequence:
    frames = np.arange(count)
    boxes = np.tile([10.0, 10.0, 20.0, 20.0], (count, 1)) + frames[:, None]
    log = DetectionLog(frames, Detections(boxes, np.ones(count)))
    return RecordedSequence("d", CAMERA, count, log, frames, straight(count))


def test_odometry_without_noise_gives_the_very_same_poses() -> None:
    poses = straight()
    assert Odometry()(poses, 1, STEP) is poses
    assert Odometry(0.1, 0.1, 0.1, 0.1)(poses, 1, STEP, 0.0) is poses


def test_scale_drift_and_dropouts_do_what_they_say() -> None:
    poses = straight()
    assert Odometry(scale=0.05)(poses, 1, STEP)[-1, 2, 3] == pytest.approx(99 * 1.05)
    drifted = Odometry(drift=0.05, autocorrelation=SLOW)(poses, 1, STEP)
    assert abs(drifted[-1, 0, 3]) > 0.1
    lost = Odometry(dropouts=0.3, dropout_autocorrelation=SLOW)(straight(3000), 1, STEP)
    still = (np.diff(lost[:, 2, 3]) == 0.0).mean()
    assert still == pytest.approx(0.3, abs=0.1)


def test_odometry_says_honestly_how_far_off_it_is() -> None:
    poses = straight(3000)
    noisy = Odometry(drift=0.1, slip=0.03)
    cov = noisy.motion_cov(poses, STEP)
    assert cov is not None
    believed = noisy(poses, 1, STEP)
    motions, true = (np.linalg.inv(each[1:]) @ each[:-1] for each in (believed, poses))
    off = motions @ np.linalg.inv(true)
    assert np.sqrt(cov[4, 4]) == pytest.approx(np.std(off[:, 0, 2]), rel=0.1)
    assert np.sqrt(cov[2, 2]) == pytest.approx(np.std(off[:, 2, 3]), rel=0.1)
    assert np.count_nonzero(cov) == 2
    assert Odometry(dropouts=0.5).motion_cov(poses, STEP) is None  # it does not know
    assert noisy.motion_cov(poses[:1], STEP) is None


def test_the_believed_camera_is_off_by_what_was_asked() -> None:
    assert Miscalibration().believed(CAMERA, 1) is CAMERA
    cameras = [Miscalibration(0.02, 0.01, 0.05).believed(CAMERA, seed) for seed in range(200)]
    focal = np.log([camera.K[0, 0] / CAMERA.K[0, 0] for camera in cameras])
    assert np.std(focal) == pytest.approx(0.02, rel=0.2)
    assert np.std([c.height for c in cameras]) == pytest.approx(0.05, rel=0.25)
    uphill = Miscalibration(slope=0.02).believed(CAMERA, 1)
    assert uphill.road_normal[2] == pytest.approx(np.sin(0.02), abs=1e-6) or uphill.road_normal[
        2
    ] == pytest.approx(-np.sin(0.02), abs=1e-6)


def test_a_loose_mount_moves_all_boxes_of_a_frame_alike() -> None:
    sightings = crowd(5, 50)
    loose = Miscalibration(vibration=0.002)
    moved = loose.shake(sightings.boxes, sightings.frames, CAMERA, 1, STEP) - sightings.boxes
    rise = moved[:, 1].reshape(50, 5)
    np.testing.assert_allclose(rise, rise[:, :1] * np.ones(5), atol=1e-9)
    assert rise.std() == pytest.approx(0.002 * CAMERA.K[1, 1], rel=0.3)
    assert loose.shake(sightings.boxes, sightings.frames, CAMERA, 1, STEP, 0.0) is sightings.boxes


def test_frames_are_dropped_at_their_rate_and_the_first_comes() -> None:
    frames = Timing(drops=0.2, autocorrelation=SLOW).delivered(5000, 1, STEP)
    assert frames[0] == 0
    assert len(frames) / 5000 == pytest.approx(0.8, abs=0.05)
    assert (Timing().delivered(50, 1, STEP) == np.arange(50)).all()


def test_time_stamps_are_off_but_go_forward() -> None:
    stamps = Timing(jitter=0.05).stamps(np.arange(500), 1, STEP)
    assert (np.diff(stamps) > 0.0).all()
    assert (stamps != 0.1 * np.arange(500)).any()
    assert (Timing().stamps(np.arange(5), 1, STEP) == 0.1 * np.arange(5)).all()


def test_a_late_detector_tells_of_frames_that_are_past() -> None:
    timed = Timing(latency=0.2)(drive(), 1)
    assert isinstance(timed, Sequence)
    frames = list(timed)
    assert len(frames) == len(timed) == 50
    assert not len(frames[1].detections)
    assert frames[7].detections.boxes[0, 0] == 15.0


def test_a_dropped_frame_leaves_the_others_as_they_are() -> None:
    whole, holey = list(drive()), list(Timing(drops=0.3)(drive(), 1))
    assert len(holey) < 50
    for frame in holey:
        assert (frame.detections.boxes == whole[frame.index].detections.boxes).all()


def test_a_detector_that_skips_frames_did_not_look_at_them() -> None:
    whole, skipping = list(drive()), list(Timing(every=3)(drive(), 1))
    assert len(skipping) == 50
    assert [frame.index for frame in skipping if frame.detections is not None] == [*range(0, 50, 3)]
    assert (skipping[9].detections.boxes == whole[9].detections.boxes).all()


def test_weather_makes_things_worse_and_clear_skies_change_nothing() -> None:
    profile = find_profile("rrc")
    assert in_weather(profile, "clear") == profile
    sightings = crowd(200, 20, height=30.0)
    profile = replace(profile, suppression=None)  # the crowd's boxes lie one upon the other

    def objects(name: str) -> int:
        sensed = Detector(in_weather(profile, name)).sense(sightings, 1, CAMERA)
        return int((sensed.provenance.sources == "object").sum())

    assert all(objects(name) < objects("clear") for name in set(WEATHERS) - {"clear", "glare"})
    assert WEATHERS["glare"](profile).misses.shared == 0.5
    with pytest.raises(UnknownName, match="Did you mean 'rain'"):
        in_weather(profile, "rainy")


@pytest.mark.parametrize(
    "make",
    [
        lambda: Odometry(drift=-1.0),
        lambda: Odometry(dropouts=2.0),
        lambda: Miscalibration(focal=-0.1),
        lambda: Timing(drops=1.1),
        lambda: Timing(jitter=-0.1),
        lambda: Timing(every=0),
    ],
)
def test_what_no_sensor_does_is_refused(make) -> None:
    with pytest.raises(BadConfig):
        make()
