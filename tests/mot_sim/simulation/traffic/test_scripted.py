"""Scripted traffic: routes with arcs, exact distances, cars that come and go."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mot_sim.simulation.traffic import Route, Script, Scripted
from tracker.errors import BadConfig
from tracker.geometry import wrap_angle

RNG = np.random.default_rng(0)
CORNER = Route([(0.0, 0.0), (10.0, 0.0), (10.0, 20.0)], radius=4.0)
points = st.lists(
    st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=2, max_size=6, unique=True
)


def pose(route: Route, distance: float) -> np.ndarray:
    return route.at(np.array([distance]))[0]


def test_a_right_angle_is_a_quarter_of_a_circle() -> None:
    arc = 4.0 * np.pi / 2
    assert CORNER.length == pytest.approx(6.0 + arc + 16.0)
    np.testing.assert_allclose(pose(CORNER, 6.0), (6, 0, 0), atol=1e-12)
    half = 4.0 * np.sqrt(0.5)
    np.testing.assert_allclose(
        pose(CORNER, 6.0 + arc / 2), (6 + half, 4 - half, np.pi / 4), atol=1e-12
    )
    np.testing.assert_allclose(pose(CORNER, 6.0 + arc), (10, 4, np.pi / 2), atol=1e-12)


def test_a_route_leads_from_its_first_to_its_last_way_point_and_straight_on() -> None:
    np.testing.assert_allclose(pose(CORNER, 0.0)[:2], (0, 0))
    np.testing.assert_allclose(pose(CORNER, CORNER.length)[:2], (10, 20))
    np.testing.assert_allclose(pose(CORNER, -3.0), (-3, 0, 0))
    np.testing.assert_allclose(pose(CORNER, CORNER.length + 5.0), (10, 25, np.pi / 2))


def test_corners_shrink_where_the_legs_are_short() -> None:
    route = Route([(0.0, 0.0), (10.0, 0.0), (10.0, 2.0), (20.0, 2.0)], radius=50.0)
    np.testing.assert_allclose(pose(route, route.length)[:2], (20, 2), atol=1e-9)
    np.testing.assert_allclose(pose(route, 9.0), (9, 0, 0), atol=1e-9)


@given(points, st.floats(0.5, 20), st.floats(-10, 300))
def test_a_metre_of_route_is_a_metre_of_road_along_the_heading(waypoints, radius, start) -> None:
    try:
        route = Route(waypoints, radius)
    except BadConfig:
        assume(False)
    step = 1e-4
    a, b = route.at(np.array([start, start + step]))
    moved, turned = b[:2] - a[:2], abs(b[2] - a[2])
    assume(turned < 0.2)  # an arc of less than a millimetre is a corner
    np.testing.assert_allclose(np.hypot(*moved), step, rtol=0.02)
    direction = np.arctan2(moved[1], moved[0])
    assert abs(wrap_angle(direction - 0.5 * (a[2] + b[2]))) < 1e-3


@given(points)
def test_routes_end_where_they_should(waypoints) -> None:
    try:
        route = Route(waypoints)
    except BadConfig:
        assume(False)
    np.testing.assert_allclose(pose(route, route.length)[:2], waypoints[-1], atol=1e-6)


def test_no_distances_have_no_poses() -> None:
    assert CORNER.at(np.zeros(0)).shape == (0, 3)


def test_distance_is_the_exact_integral_of_the_speed() -> None:
    car = Script(CORNER, [(1.0, 0.0), (5.0, 10.0), (7.0, 10.0)], start=3.0)
    assert car.distance(1.0) == 3.0
    assert car.distance(3.0) == pytest.approx(3.0 + 5.0)
    assert car.distance(5.0) == pytest.approx(3.0 + 20.0)
    assert car.distance(9.0) == pytest.approx(3.0 + 20.0 + 40.0)
    assert car.speed(3.0) == pytest.approx(5.0)


def test_worlds_are_a_tenth_of_a_second_apart_and_ids_stay() -> None:
    straight = Route([(0.0, 0.0), (100.0, 0.0)])
    late = Script(straight, [(0.0, 5.0)], start=20.0, begin=0.2)
    leaving = Script(straight, [(0.0, 10.0)], start=98.5)
    traffic = Scripted([leaving, late], Script(straight, [(0.0, 1.0)]))
    states = [traffic.reset(RNG)] + [traffic.step() for _ in range(3)]
    assert [state.time for state in states] == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert [state.ids.tolist() for state in states] == [[0], [0], [1], [1]]
    assert states[2].x.tolist() == pytest.approx([21.0])
    assert states[3].ego.tolist() == pytest.approx([0.3, 0.0, 0.0])
    assert traffic.reset(RNG).time == 0.0


def test_cars_stand_where_their_routes_have_them() -> None:
    bent = Route([(0.0, 0.0), (40.0, 0.0), (40.0, 30.0)])
    cars = [Script(bent, [(0.0, 4.0), (9.0, 9.0)], start=3.0 * number) for number in range(5)]
    for time in (0.0, 0.7, 5.0):
        state = Scripted(cars, cars[2]).at(time)
        poses = np.stack((state.x, state.y, state.heading), axis=1)
        expected = [bent.at(np.array([car.distance(time)]))[0] for car in cars]
        assert np.array_equal(poses, np.array(expected)[state.ids])
        assert np.array_equal(state.ego, expected[2])


def test_an_empty_road_is_a_world() -> None:
    state = Scripted([], Script(CORNER, [(0.0, 1.0)])).reset(RNG)
    assert len(state) == 0
    assert state.footprint().shape == (0, 4, 2)
    assert state.ego_footprint().shape == (4, 2)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Route([(0.0, 0.0)]), "two or more"),
        (lambda: Route([(0.0, 0.0), (np.nan, 0.0)]), "finite"),
        (lambda: Route([(0.0, 0.0), (0.0, 0.0)]), "same point"),
        (lambda: Route([(0.0, 0.0), (9.0, 0.0), (0.0, 0.0)]), "turn back"),
        (lambda: Route([(0.0, 0.0), (9.0, 0.0)], radius=0.0), "radius"),
        (lambda: Script(CORNER, []), "speeds"),
        (lambda: Script(CORNER, [(1.0, 2.0), (1.0, 3.0)]), "increasing"),
        (lambda: Script(CORNER, [(1.0, -2.0)]), "negative"),
        (lambda: Script(CORNER, [(1.0, 2.0)], size=(4.0, 0.0, 1.0)), "size"),
    ],
)
def test_scripts_that_cannot_be_are_refused(make, message) -> None:
    with pytest.raises(BadConfig, match=message):
        make()
