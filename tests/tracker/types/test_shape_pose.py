"""Shape and pose as last measured."""

import numpy as np

from tests.tracker.samples import LEVEL, beliefs_at
from tracker.beliefs import Beliefs, Lift
from tracker.ego_motion import compensate_ego_motion
from tracker.geometry import homogeneous, rotation_y
from tracker.types import Detections
from tracker.types.shape_pose import TURN_RATE_STD, ShapePose

KNOWN = ShapePose(np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([0.1, 0.2]), np.zeros((2, 3, 3)))


def test_it_needs_both_columns_and_takes_a_missing_covariance_for_none() -> None:
    boxes = [[0.0, 0.0, 9.0, 9.0]]
    yaw, shape = np.zeros(1), np.ones((1, 2))
    assert ShapePose.of(Detections.of(boxes)) is None
    assert ShapePose.of(Detections.of(boxes, yaw=yaw)) is None
    found = ShapePose.of(Detections.of(boxes, yaw=yaw, shape=shape))
    assert found is not None
    np.testing.assert_array_equal(found.cov, np.zeros((1, 3, 3)))


def test_with_time_only_the_yaw_gets_doubtful() -> None:
    later = KNOWN.after(2.0)
    assert later.cov[0, 0, 0] == (2.0 * TURN_RATE_STD) ** 2
    assert (later.cov[:, 1:] == 0.0).all()
    np.testing.assert_array_equal(KNOWN.cov, np.zeros((2, 3, 3)))


def test_what_is_not_known_now_is_as_it_was_before() -> None:
    blind = ShapePose(np.array([[np.nan, 0.0], [9.0, 9.0]]), np.array([0.5, 0.6]), KNOWN.cov)
    merged = blind.filled_from(KNOWN)
    np.testing.assert_array_equal(merged.shape, [[1.0, 2.0], [9.0, 9.0]])
    np.testing.assert_array_equal(merged.yaw, [0.1, 0.6])
    assert KNOWN.filled_from(blind) is KNOWN
    assert blind.filled_from(None) is blind


def test_it_turns_with_the_camera() -> None:
    beliefs = beliefs_at((0.0, 20.0))
    turned = compensate_ego_motion(beliefs, LEVEL, homogeneous(rotation_y(0.3)), np.zeros((6, 6)))
    assert turned.shape_pose is not None
    np.testing.assert_allclose(turned.shape_pose.yaw, turned.cuboids.yaw)


def test_parts_that_know_nothing_get_empty_rows_beside_those_that_know() -> None:
    known = beliefs_at((0.0, 20.0))
    boxes = Detections.of([[600.0, 165.0, 660.0, 245.0]])
    unknown = Lift()(boxes, LEVEL)
    both = Beliefs.concatenate((unknown, known, Beliefs.empty()))
    assert both.shape_pose is not None
    np.testing.assert_array_equal(np.isnan(both.shape_pose.yaw), [True, False])
    assert Beliefs.concatenate((unknown, unknown)).shape_pose is None
    assert len(KNOWN.unknown(0)) == 0
