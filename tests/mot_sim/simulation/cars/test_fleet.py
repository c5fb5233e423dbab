"""The fleet: eq. 1 for meshes, keypoints and sizes; draws; sizes that were asked for."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.simulation.cars import BODIES, PAINTS, load_fleet, look_alike_ids, topology
from mot_sim.simulation.cars.build import POPULATION_COUNT
from mot_sim.simulation.cars.design import BODY_SHARES
from tracker.errors import BadConfig, UnknownName
from tracker.shape import KEYPOINTS_14, KEYPOINTS_36, load_prior

FLEET = load_fleet()
SHARES_IN_ORDER = [BODY_SHARES[name] for name in BODIES]
sigmas = st.lists(st.floats(-1.5, 1.5), min_size=5, max_size=5)


def some_cars(fleet_size: int = 5, count: int = 40) -> np.ndarray:
    return load_fleet(fleet_size).sample(5, np.arange(count)).coefficients


def test_no_coefficients_at_all_are_the_mean_car() -> None:
    none = np.zeros(5)
    np.testing.assert_allclose(FLEET.halves(none), FLEET.components.mean, atol=1e-12)
    assert FLEET.car(none).size == pytest.approx((4.4, 1.5, 1.8), abs=0.15)


@pytest.mark.parametrize("count", [1, 5, 12, 20])
def test_keypoints_and_meshes_follow_equation_1_with_the_trackers_prior(count: int) -> None:
    fleet, prior = load_fleet(count), load_prior().first(count)
    cars = some_cars(count)
    np.testing.assert_allclose(fleet.keypoints(cars), prior.shape(cars), atol=1e-9)
    np.testing.assert_allclose(prior.project(fleet.keypoints(cars)), cars, atol=1e-6)
    few = load_prior(points=KEYPOINTS_14).first(count)
    np.testing.assert_allclose(fleet.keypoints_14(cars), few.shape(cars), atol=1e-9)
    twice = fleet.vertices(cars) - fleet.vertices(0.0 * cars)
    half = fleet.vertices(0.5 * cars) - fleet.vertices(0.0 * cars)
    np.testing.assert_allclose(twice, 2.0 * half, atol=1e-9)


def test_the_coefficients_are_uncorrelated_over_the_population() -> None:
    full = load_fleet(20).components
    counts = np.array([round(POPULATION_COUNT * share) for share in SHARES_IN_ORDER])
    second = np.zeros((20, 20))
    for count, mean, root in zip(counts, full.body_means, full.body_roots, strict=True):
        second += (count - 1) * root @ root.T + count * np.outer(mean, mean)
    second /= counts.sum() * np.outer(full.std, full.std)
    np.testing.assert_allclose(second, np.eye(20), atol=0.01)


@settings(max_examples=25, deadline=None)
@given(sigmas)
def test_the_size_is_the_tight_box_on_the_road(steps: list[float]) -> None:
    car = FLEET.car(np.array(steps) * FLEET.std)
    low, high = car.vertices.min(axis=0), car.vertices.max(axis=0)
    np.testing.assert_allclose(car.size, FLEET.size(np.array(steps) * FLEET.std), atol=1e-9)
    np.testing.assert_allclose(high - low, car.size, atol=1e-9)
    np.testing.assert_allclose([low[0] + high[0], high[1], low[2] + high[2]], 0.0, atol=1e-9)


@pytest.mark.parametrize("body", BODIES)
def test_keypoints_lie_on_the_mesh(body: str) -> None:
    car = FLEET.car(FLEET.sample(1, np.arange(1), body).coefficients[0])
    assert car.keypoints is not None
    assert car.keypoints_14 is not None
    for points in (car.keypoints, car.keypoints_14):
        _, distance, _ = trimesh.proximity.closest_point_naive(car.mesh(), points)
        assert distance.max() < 0.02
    assert len(car.keypoints) == len(KEYPOINTS_36)
    np.testing.assert_allclose(car.keypoints[18:], car.keypoints[:18] * (1, 1, -1), atol=1e-12)


@pytest.mark.parametrize("body", BODIES)
def test_drawn_cars_are_closed_meshes(body: str) -> None:
    for coefficients in FLEET.sample(2, np.arange(3), body).coefficients:
        car = FLEET.car(coefficients)
        assert car.mesh().is_watertight
        for piece in range(9):
            assert car.piece(piece).is_watertight
            assert car.piece(piece).volume > 0.0
        box = car.size.prod()
        assert 0.4 * box < car.piece(0).volume < 0.8 * box


def test_one_more_car_changes_no_other() -> None:
    few, many = FLEET.sample(3, np.array([4, 9])), FLEET.sample(3, np.array([1, 9, 4]))
    np.testing.assert_array_equal(few.coefficients[0], many.coefficients[2])
    assert few.paints == (many.paints[2], many.paints[1])
    other = FLEET.sample(4, np.array([4, 9]))
    assert (few.coefficients != other.coefficients).all()


def test_more_coefficients_refine_the_same_cars() -> None:
    ids = np.arange(50)
    few = FLEET.sample(3, ids, "sedan").coefficients
    many = load_fleet(20).sample(3, ids, "sedan").coefficients[:, :5]
    assert (np.abs(few - many).max(axis=1) < 1e-9).mean() > 0.8  # but those that were pulled in


def test_ten_thousand_cars_are_of_the_bodies_and_paints_of_the_street() -> None:
    cars = FLEET.sample(0, np.arange(10_000))
    shares = np.bincount(cars.bodies, minlength=len(BODIES)) / 10_000
    np.testing.assert_allclose(shares, SHARES_IN_ORDER, atol=0.015)
    assert cars.paints.count("black") == pytest.approx(2900, abs=150)
    assert set(cars.paints) == set(PAINTS)
    FLEET.check(cars.coefficients)


def test_no_car_at_all() -> None:
    cars = FLEET.sample(0, np.zeros(0, dtype=np.int64))
    assert cars.coefficients.shape == (0, 5)
    assert FLEET.vertices(cars.coefficients).shape == (0, len(topology().twins), 3)
    assert FLEET.keypoints(cars.coefficients).shape == (0, 36, 3)
    assert FLEET.size(cars.coefficients).shape == (0, 3)


def test_look_alikes_share_shape_and_paint() -> None:
    ids = np.arange(400)
    keys = look_alike_ids(1, ids, 0.25, groups=2)
    alike = keys < 0
    assert set(keys[alike]) == {-1, -2}
    assert alike.mean() == pytest.approx(0.25, abs=0.07)
    np.testing.assert_array_equal(keys[~alike], ids[~alike])
    cars = FLEET.sample(1, keys)
    first = np.flatnonzero(keys == -1)
    assert (cars.coefficients[first] == cars.coefficients[first[0]]).all()
    assert len({cars.paints[row] for row in first}) == 1
    assert (look_alike_ids(1, ids, 0.0) == ids).all()
    assert (look_alike_ids(1, ids, 1.0) == -1).all()


@settings(max_examples=25, deadline=None)
@given(st.floats(3.2, 5.4), st.floats(1.25, 2.1), st.floats(1.5, 2.1))
def test_the_nearest_car_has_exactly_the_size_asked_for(
    length: float, height: float, width: float
) -> None:
    size = np.array([length, height, width])
    car = FLEET.nearest(size)
    np.testing.assert_allclose(car.size, size, atol=1e-9)
    assert car.scale is not None
    assert ((car.scale > 0.8) & (car.scale < 1.25)).all()
    assert abs(car.vertices[:, 1].max()) < 1e-9


def test_the_nearest_car_to_one_of_the_fleet_is_hardly_stretched() -> None:
    size = FLEET.size(0.5 * FLEET.std)
    scale = FLEET.nearest(size).scale
    assert scale is not None
    np.testing.assert_allclose(scale, 1.0, atol=0.01)


@pytest.mark.parametrize("size", [(0.0, 1.5, 1.8), (4.0, -1.0, 1.8), (4.0, np.nan, 1.8)])
def test_a_car_without_size_is_refused(size: tuple[float, ...]) -> None:
    with pytest.raises(BadConfig, match="give length, height, width > 0"):
        FLEET.nearest(np.array(size))
    with pytest.raises(BadConfig, match="give length, height, width > 0"):
        FLEET.car(np.zeros(5)).scaled_to(np.array(size))


def test_coefficients_outside_the_population_are_refused_with_the_range() -> None:
    limit = 4.0 * FLEET.std[2]
    FLEET.check(np.array([[0.0, 0.0, limit, 0.0, 0.0]]))
    with pytest.raises(BadConfig, match=rf"coefficient 2 of car 0 is 9: .* to {limit:g} \(4 stan"):
        FLEET.car(np.array([0.0, 0.0, 9.0, 0.0, 0.0]))
    with pytest.raises(BadConfig, match="coefficient 0 of car 1 is nan"):
        FLEET.check(np.array([[0.0] * 5, [np.nan] * 5]))
    with pytest.raises(BadConfig, match="3 shape coefficients: this fleet takes 5"):
        FLEET.car(np.zeros(3))
    with pytest.raises(BadConfig, match="21 shape coefficients: give 1 to 20"):
        load_fleet(21)
    with pytest.raises(BadConfig, match="share 2 in 1 groups"):
        look_alike_ids(0, np.arange(3), 2.0)


def test_unknown_bodies_are_named_with_the_known_ones() -> None:
    with pytest.raises(UnknownName, match=r"unknown body 'sedn'; known: .*Did you mean 'sedan'"):
        FLEET.sample(0, np.arange(2), "sedn")
