"""Keypoints in, shape and pose out."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tracker.samples import LEVEL, PITCHED, locked
from tests.tracker.shape.drawn import MODEL, Drawn, draw, keypoints_of
from tracker.errors import BadConfig, BadDetections
from tracker.geometry import wrap_angle
from tracker.shape import (
    KEYPOINTS_14,
    CarModel,
    FittedCars,
    ShapeBasis,
    ShapeFit,
    load_prior,
    metric,
    no_car_fits,
)
from tracker.shape.fit import MAX_CARS_AT_ONCE

FIT = ShapeFit(MODEL)


def worst(fitted: FittedCars, cars: Drawn) -> float:
    """The largest error of all: yaw (rad), place (m), coefficients."""
    parts = (wrap_angle(fitted.yaw - cars.yaw), fitted.base - cars.base, fitted.shape - cars.shape)
    return max(float(np.abs(part).max()) for part in parts)


def assert_equal(some: FittedCars, others: FittedCars, atol: float = 0.0) -> None:
    for column in fields(some):
        ours, theirs = getattr(some, column.name), getattr(others, column.name)
        np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=atol)


@pytest.mark.parametrize("camera", [LEVEL, PITCHED])
def test_without_noise_it_is_exact_to_a_millionth(camera) -> None:
    cars = draw(60, camera=camera, hide=False)
    assert worst(replace(FIT, sigma=1e-6)(cars.keypoints, camera), cars) < 1e-6


@settings(max_examples=15)
@given(st.integers(0, 10_000))
def test_whatever_the_car_and_its_pose_exact_points_give_it_back(seed: int) -> None:
    cars = draw(3, seed=seed, hide=False)
    assert worst(replace(FIT, sigma=1e-6)(cars.keypoints, LEVEL), cars) < 1e-6


def test_the_error_shrinks_with_the_stated_sigma() -> None:
    """Prior and data are both in likelihood units: halved noise, halved error, to the end."""
    errors = []
    for sigma in (1e-1, 1e-2, 1e-3):
        cars = draw(40, sigma=sigma, hide=False)
        fitted = replace(FIT, sigma=sigma)(cars.keypoints, LEVEL)
        errors.append(float(np.median(np.abs(fitted.shape - cars.shape))))
    assert errors[0] > 5.0 * errors[1] > 25.0 * errors[2]


def test_with_two_pixels_of_noise_and_a_third_missing_pose_and_shape_come_out() -> None:
    cars = draw(400, sigma=2.0, missing=0.3)
    fitted = FIT(cars.keypoints, LEVEL)
    has = fitted.seen >= 4
    assert has.mean() > 0.98
    off = np.degrees(np.abs(wrap_angle(fitted.yaw - cars.yaw)))[has]
    assert np.median(off) < 3.0
    assert (off > 90.0).mean() <= 0.01
    away = np.linalg.norm((fitted.base - cars.base)[has][:, ::2], axis=1) / cars.base[has, 2]
    assert np.median(away) < 0.03
    for column in range(3):
        alike = np.corrcoef(fitted.shape[has, column], cars.shape[has, column])[0, 1]
        assert alike > 0.8
    assert fitted.trusted[has].mean() > 0.95


def test_the_stated_doubt_is_the_real_one() -> None:
    cars = draw(400, sigma=2.0, missing=0.3)
    fitted = FIT(cars.keypoints, LEVEL)
    rows = np.flatnonzero(fitted.seen >= 6)
    off = np.column_stack((
        (fitted.base - cars.base)[:, ::2], wrap_angle(fitted.yaw - cars.yaw),
        fitted.shape - cars.shape,
    ))  # fmt: skip
    ratio = off[rows] / np.sqrt(np.diagonal(fitted.cov[rows], axis1=1, axis2=2))
    robust = 1.48 * np.median(np.abs(ratio), axis=0)
    assert ((robust > 0.7) & (robust < 1.3)).all()
    assert 0.8 < np.median(fitted.residual[rows]) < 1.1


def test_every_car_is_fitted_as_if_it_were_alone() -> None:
    cars = draw(MAX_CARS_AT_ONCE + 7, sigma=2.0, missing=0.3)
    together = FIT(cars.keypoints, LEVEL)
    rows = np.array([0, MAX_CARS_AT_ONCE - 1, MAX_CARS_AT_ONCE, MAX_CARS_AT_ONCE + 6])
    for row in rows.tolist():
        alone = FIT(cars.keypoints[row : row + 1], LEVEL)
        assert_equal(alone, together.select(slice(row, row + 1)), atol=1e-4)
    order = np.random.default_rng(0).permutation(len(cars.yaw))
    assert_equal(FIT(cars.keypoints[order], LEVEL), together.select(order), atol=1e-4)


def test_it_is_pure_and_leaves_its_inputs_as_they_were() -> None:
    keypoints = locked(draw(5, sigma=2.0).keypoints)
    assert_equal(FIT(keypoints, LEVEL), FIT(keypoints, LEVEL))


def test_no_cars_give_no_rows() -> None:
    fitted = FIT(np.zeros((0, 36, 3)), LEVEL)
    assert len(fitted) == 0
    assert fitted.shape.shape == (0, 5)
    assert fitted.cov.shape == (0, 8, 8)
    assert fitted.pose.shape == (0, 3)


def test_three_visible_points_are_no_fit_and_four_are_one() -> None:
    cars = draw(2, hide=False)
    cars.keypoints[0, 3:, 2] = 0.0
    cars.keypoints[1, 4:, 2] = 0.0
    fitted = FIT(cars.keypoints, LEVEL)
    np.testing.assert_array_equal(fitted.seen, [3, 4])
    assert not fitted.trusted[0]
    for column in ("shape", "yaw", "size", "base", "cov", "residual"):
        assert np.isnan(getattr(fitted, column)[0]).all()
        assert np.isfinite(getattr(fitted, column)[1]).all()


@pytest.mark.parametrize("nothing", [0.0, -0.3, np.nan, 0.05])
def test_without_confidence_nothing_is_seen(nothing: float) -> None:
    cars = draw(3, hide=False)
    cars.keypoints[:, :, 2] = nothing
    fitted = FIT(cars.keypoints, LEVEL)
    assert (fitted.seen == 0).all()
    assert np.isnan(fitted.yaw).all()
    assert not fitted.trusted.any()


def test_points_that_are_not_numbers_or_on_the_moon_are_not_seen() -> None:
    cars = draw(3, hide=False)
    cars.keypoints[:, 0, 0], cars.keypoints[:, 1, 1], cars.keypoints[:, 2, 0] = np.nan, np.inf, 1e30
    fitted = replace(FIT, sigma=1e-6)(cars.keypoints, LEVEL)
    np.testing.assert_array_equal(fitted.seen, 33)
    assert worst(fitted, cars) < 1e-6


def test_boxes_without_area_have_no_sigma_and_no_fit() -> None:
    cars = draw(3, hide=False)
    sigmas = np.array([[2.0, 2.0], [0.0, 2.0], [np.nan, 2.0]])
    fitted = FIT(cars.keypoints, LEVEL, sigmas)
    np.testing.assert_array_equal(fitted.trusted, [True, False, False])
    np.testing.assert_array_equal(np.isnan(fitted.yaw), [False, True, True])


@pytest.mark.parametrize(
    "spot",
    [
        lambda rng: np.tile([600.0, 200.0], (36, 1)),
        lambda rng: np.column_stack((np.linspace(0, 1000, 36), np.full(36, 250.0))),
        lambda rng: rng.uniform(-9e4, 9e4, (36, 2)),
        lambda rng: rng.uniform(0, 150, (36, 2)),
    ],
    ids=["one spot", "a line", "far out", "above the horizon"],
)
def test_points_of_no_car_give_finite_numbers_that_are_not_trusted(spot) -> None:
    keypoints = np.column_stack((spot(np.random.default_rng(0)), np.ones(36)))[None]
    fitted = FIT(keypoints, LEVEL)
    assert np.isfinite(fitted.base).all()
    assert np.isfinite(fitted.cov).all()
    assert not fitted.trusted[0]
    assert no_car_fits(fitted, FIT.max_residual)[0]


def test_a_few_wild_points_change_little() -> None:
    cars = draw(60, sigma=1.0, hide=False)
    cars.keypoints[:, [3, 20], :2] += 60.0
    fitted = FIT(cars.keypoints, LEVEL)
    assert np.median(np.abs(np.degrees(wrap_angle(fitted.yaw - cars.yaw)))) < 1.0


def test_less_confidence_is_more_doubt() -> None:
    cars = draw(5, hide=False)
    sure = FIT(cars.keypoints, LEVEL).cov
    cars.keypoints[:, :, 2] = 0.25
    unsure = FIT(cars.keypoints, LEVEL)
    assert (np.diagonal(unsure.cov - sure, axis1=1, axis2=2) > 0.0).all()
    twice = replace(FIT, sigma=4.0)
    cars.keypoints[:, :, 2] = 1.0
    np.testing.assert_allclose(unsure.cov, twice(cars.keypoints, LEVEL).cov, rtol=1e-3, atol=1e-9)


def test_a_prior_of_another_scale_finds_the_size_by_the_road() -> None:
    model = CarModel(metric(load_prior().first(5)), scale_std=0.2)
    shape, base = np.zeros((1, 5)), np.array([[2.0, 0.0, 12.0]])
    keypoints = keypoints_of(model, shape, base, np.array([0.6]), scale=1.15)
    fitted = ShapeFit(model, sigma=1e-4, road_std=1e-3)(keypoints, LEVEL)
    np.testing.assert_allclose(fitted.size, 1.15 * model.size(shape, np.ones(1)), rtol=1e-3)
    np.testing.assert_allclose(fitted.base, base, atol=1e-2)


def test_fourteen_points_of_a_centred_prior_do_as_well() -> None:
    ours = load_prior(points=KEYPOINTS_14).first(4)
    centred = ShapeBasis(ours.points, 0.3 * (ours.mean + (0.1, 0.8, 0.0)), 0.3 * ours.vectors)
    model = CarModel(metric(centred), scale_std=0.1)
    cars = draw(100, sigma=1.0, model=model)
    fitted = ShapeFit(model, sigma=1.0)(cars.keypoints, LEVEL)
    has = fitted.seen >= 5
    off = np.abs(np.degrees(wrap_angle(fitted.yaw - cars.yaw)))[has]
    assert np.median(off) < 3.0


def test_keypoints_of_another_prior_are_refused() -> None:
    with pytest.raises(BadDetections, match=r"the prior has 36 points, so give \(2, 36, 3\)"):
        FIT(np.zeros((2, 14, 3)), LEVEL)
    with pytest.raises(BadDetections, match="2 cars but 1 sigmas"):
        FIT(np.zeros((2, 36, 3)), LEVEL, np.ones((1, 2)))


@pytest.mark.parametrize(
    "bad",
    [
        {"sigma": 0.0}, {"sigma": np.nan}, {"road_std": -1.0}, {"kernel": np.inf},
        {"min_confidence": 0.0}, {"min_confidence": 1.5}, {"hypotheses": 0}, {"max_residual": 0.0},
    ],
)  # fmt: skip
def test_parameters_out_of_range_are_refused(bad) -> None:
    with pytest.raises(BadConfig, match=next(iter(bad))):
        ShapeFit(MODEL, **bad)


def test_clutter_is_told_from_cars() -> None:
    cars = draw(300, sigma=2.0, missing=0.3)
    true = FIT(cars.keypoints, LEVEL)
    assert no_car_fits(true).mean() <= 0.02
    rng = np.random.default_rng(1)
    clutter = cars.keypoints.copy()
    low = np.array([600.0, 150.0])
    clutter[:, :, :2] = low + rng.uniform(0.0, 1.0, clutter[:, :, :2].shape) * (120.0, 80.0)
    assert no_car_fits(FIT(clutter, LEVEL)).mean() > 0.3


def test_a_symmetric_car_may_be_turned_round_and_a_long_bonnet_tells_its_front() -> None:
    turned = MODEL.basis.mean[np.array(FIT.turned)] * [-1.0, 1.0, -1.0]
    alike = CarModel(replace(MODEL.basis, mean=0.5 * (MODEL.basis.mean + turned)))
    boxy = draw(60, sigma=1.0, model=alike)
    plain = draw(60, sigma=1.0)
    unsure = ShapeFit(alike)(boxy.keypoints, LEVEL).turned_gap
    sure = FIT(plain.keypoints, LEVEL).turned_gap
    assert np.median(unsure) < 0.5 * np.median(sure)
    assert np.median(sure) > 5.0


def test_points_without_counterparts_tell_front_and_rear_by_their_names_alone() -> None:
    model = CarModel(load_prior(points=KEYPOINTS_14).first(5))
    cars = draw(5, model=model)
    fitted = ShapeFit(model)(cars.keypoints, LEVEL)
    assert np.isinf(fitted.turned_gap[fitted.seen >= 4]).all()


@pytest.mark.parametrize("gap", [np.nan, np.inf])
def test_a_gap_that_is_no_number_is_refused(gap: float) -> None:
    with pytest.raises(BadConfig, match="min_turned_gap"):
        ShapeFit(MODEL, min_turned_gap=gap)
