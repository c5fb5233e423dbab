"""The camera's turn, corrected by what the boxes agree on."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, Car, drive
from tracker import Tracker
from tracker.camera_rotation_filter import CameraRotationFilter
from tracker.ego_motion import compensate_ego_motion
from tracker.errors import BadConfig
from tracker.geometry import homogeneous, rotation_x, rotation_y
from tracker.multi_frame import NetworkFlow

DEGREE = float(np.radians(1.0))
STREET = [Car(-9.0, 40.0), Car(-4.0, 25.0), Car(3.5, 30.0), Car(8.0, 45.0), Car(0.0, 50.0)]
OPEN = np.diag(np.square([0.01, 0.01, 0.01, DEGREE, DEGREE, 1e-4]))


def forward(time: float) -> tuple[float, float, float]:
    """The ego car drives at 8 m/s."""
    return 0.0, 8.0 * time, 0.0


def one_step(yaw: float, pitch: float = 0.0):
    """Expected and detected boxes of a step whose turn is stated wrongly by this much."""
    first, second = drive(STREET, forward, 2).frames
    wrong = homogeneous(rotation_y(yaw) @ rotation_x(pitch)) @ second.T_now_before
    before = Tracker.default(LEVEL).lift(first.detections, LEVEL)
    expected = compensate_ego_motion(before, LEVEL, wrong, np.zeros((6, 6)))
    return expected.boxes, second.detections.boxes, wrong, second.T_now_before


def angles(T: np.ndarray) -> np.ndarray:
    """Yaw and pitch of a motion."""
    return np.array([np.arctan2(T[0, 2], T[2, 2]), np.arctan2(-T[1, 2], T[2, 2])])


@pytest.mark.parametrize(
    ("yaw", "pitch"), [(1.0, 0.0), (-2.2, 0.0), (0.0, 0.9), (1.5, -1.1), (0.0, 0.0)]
)
def test_a_turn_that_is_stated_wrongly_is_corrected(yaw: float, pitch: float) -> None:
    expected, detected, wrong, right = one_step(yaw * DEGREE, pitch * DEGREE)
    found, cov = CameraRotationFilter()(expected, detected, wrong, OPEN, LEVEL)
    np.testing.assert_allclose(angles(found), angles(right), atol=0.12 * DEGREE)
    assert cov[4, 4] < 0.1 * OPEN[4, 4]
    assert cov[3, 3] < 0.1 * OPEN[3, 3]
    np.testing.assert_array_equal(np.diag(cov)[:3], np.diag(OPEN)[:3])


def test_a_car_that_moves_on_its_own_does_not_turn_the_camera() -> None:
    expected, detected, wrong, right = one_step(DEGREE)
    detected[1, ::2] += 25.0
    found, _ = CameraRotationFilter()(expected, detected, wrong, OPEN, LEVEL)
    np.testing.assert_allclose(angles(found), angles(right), atol=0.2 * DEGREE)


def test_only_what_the_covariance_leaves_open_is_corrected() -> None:
    expected, detected, wrong, _ = one_step(DEGREE, 0.5 * DEGREE)
    level = OPEN.copy()
    level[3, 3] = 1e-8
    found, cov = CameraRotationFilter()(expected, detected, wrong, level, LEVEL)
    assert angles(found)[1] == pytest.approx(0.5 * DEGREE, abs=1e-6)
    assert cov[3, 3] == level[3, 3]


def test_a_turn_known_to_within_a_pixel_is_left_alone() -> None:
    known = np.diag(np.square([0.02, 0.02, 0.05, 5e-4, 5e-4, 5e-4]))  # KITTI's GPS/IMU
    assert not CameraRotationFilter().is_uncertain(known, LEVEL)
    assert CameraRotationFilter().is_uncertain(OPEN, LEVEL)


@pytest.mark.parametrize("nothing", ["expected", "detected", "near"])
def test_where_nothing_can_be_compared_the_motion_stays(nothing: str) -> None:
    expected, detected, wrong, _ = one_step(DEGREE)
    if nothing == "expected":
        expected = expected[:0]
    elif nothing == "detected":
        detected = detected[:0]
    else:
        detected = detected + 5000.0
    found, cov = CameraRotationFilter()(expected, detected, wrong, OPEN, LEVEL)
    np.testing.assert_array_equal(found, wrong)
    np.testing.assert_array_equal(cov, OPEN)


def shaken():
    """A drive of six seconds whose odometry is off by a degree and a half a frame, and says so."""
    rng = np.random.default_rng(8)
    frames = []
    for frame in drive(STREET, lambda time: (0.0, 2.0 * time, 0.0), 60).frames:
        if frame.T_now_before is not None:
            turn = homogeneous(rotation_y(float(1.5 * DEGREE * rng.normal())))
            frame = replace(frame, T_now_before=turn @ frame.T_now_before, motion_cov=OPEN)  # noqa: PLW2901
        frames.append(frame)
    return frames


def test_the_tracker_keeps_its_cars_though_the_odometry_is_bad() -> None:
    with_it, without = (
        Tracker.default(LEVEL),
        replace(Tracker.default(LEVEL), camera_rotation_filter=None),
    )
    kept, lost = (
        {int(name) for frame in shaken() for name in tracker.step(frame).ids}
        for tracker in (with_it, without)
    )
    assert len(kept) == len(STREET)
    assert len(lost) > len(STREET)


def test_the_network_flow_corrects_the_turn_as_well() -> None:
    made = NetworkFlow(Tracker.default(LEVEL))
    for frame in shaken():
        made.step(frame)
    assert len(set(made.finish().ids.tolist())) == len(STREET)


@pytest.mark.parametrize(
    "wrong", [{"min_pixels": 0.0}, {"jitter": (-1.0, 0.1)}, {"jitter": (0.0, 0.0)}]
)
def test_numbers_that_cannot_be_are_refused(wrong) -> None:
    with pytest.raises(BadConfig, match="CameraRotationFilter"):
        CameraRotationFilter(**wrong)
