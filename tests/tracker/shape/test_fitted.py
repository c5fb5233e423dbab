"""What a fit says, and how it becomes columns of detections."""

import numpy as np
import pytest

from tests.tracker.samples import LEVEL
from tests.tracker.shape.drawn import MODEL, draw
from tracker.errors import BadDetections
from tracker.shape import FittedCars, ShapeFit, no_car_fits
from tracker.types import Detections

BOXES = np.tile([0.0, 0.0, 10.0, 10.0], (3, 1))


def three() -> FittedCars:
    """Two good fits, and between them a car of which nothing was seen."""
    cars = draw(3, hide=False)
    cars.keypoints[1, :, 2] = 0.0
    return ShapeFit(MODEL)(cars.keypoints, LEVEL)


def test_the_pose_is_the_axis_angle_vector_of_the_yaw() -> None:
    fitted = three()
    np.testing.assert_array_equal(fitted.pose[0], [0.0, fitted.yaw[0], 0.0])
    assert np.isnan(fitted.pose[1]).any()


def test_cuboids_and_the_covariance_of_eq_6_are_views_of_the_columns() -> None:
    fitted = three()
    np.testing.assert_array_equal(fitted.cuboids.base, fitted.base)
    np.testing.assert_array_equal(fitted.pose_cov, fitted.cov[:, 2:, 2:])


def test_detections_get_the_columns_and_nan_where_a_fit_is_not_trusted() -> None:
    fitted = three()
    detections = fitted.onto(Detections.of(BOXES))
    for name in ("yaw", "size", "shape", "pose_cov"):
        column = getattr(detections, name)
        assert np.isnan(column[1]).all()
        np.testing.assert_array_equal(column[::2], getattr(fitted, name)[::2])
    np.testing.assert_array_equal(detections.boxes, BOXES)


def test_a_car_as_likely_turned_round_keeps_its_size_and_tells_no_heading() -> None:
    cars = draw(40, sigma=2.0)
    fitted = ShapeFit(MODEL, min_turned_gap=1e6)(cars.keypoints, LEVEL)
    assert fitted.fits.any()
    assert not fitted.trusted.any()
    detections = fitted.onto(Detections.of(np.tile(BOXES[:1], (40, 1))))
    for column in (detections.yaw, detections.shape, detections.pose_cov):
        assert column is not None
        assert np.isnan(column).all()
    np.testing.assert_array_equal(np.isfinite(detections.size).all(axis=1), fitted.fits)


def test_another_number_of_boxes_is_refused() -> None:
    with pytest.raises(BadDetections, match="3 fits for 2 boxes"):
        three().onto(Detections.of(BOXES[:2]))


def test_a_box_with_too_few_points_is_not_judged() -> None:
    unknown = FittedCars.unknown(2, 5)
    assert not no_car_fits(unknown).any()
    assert no_car_fits(unknown.select([])).shape == (0,)
