"""Who the cars of a run are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.simulation.cars import Vehicles, VehicleSampler, load_fleet
from mot_sim.simulation.cars.vehicles import keypoint_faces
from mot_sim.simulation.traffic import RecordedTraffic, TrafficState
from tests.mot_sim.simulation.cars.rays import hits
from tracker.errors import BadConfig, UnknownName


def traffic_of(sizes, ids=None, kinds=None) -> RecordedTraffic:
    n = len(sizes)
    state = TrafficState(
        0.0,
        np.arange(n) if ids is None else np.array(ids),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.array(sizes, dtype=float).reshape(-1, 3),
        np.zeros(3),
        np.ones(3),
        kinds=None if kinds is None else np.array(kinds),
    )
    return RecordedTraffic.of([state])


def test_a_car_with_the_size_of_a_model_is_that_model_unstretched() -> None:
    sampler = VehicleSampler(models=6)
    models = sampler.models_of(3)
    vehicles = sampler.sample(traffic_of(models.size[[4, 1, 4]]), seed=3)
    np.testing.assert_array_equal(vehicles.coefficients, models.cars.coefficients[[4, 1, 4]])
    for shape in vehicles.shapes:
        np.testing.assert_allclose(shape.scale, 1.0, atol=1e-12)


def test_a_car_of_another_size_is_the_nearest_shape_stretched_to_it() -> None:
    size = (4.05, 1.52, 1.71)
    vehicles = VehicleSampler().sample(traffic_of([size]), seed=0)
    np.testing.assert_allclose(np.ptp(vehicles.shapes[0].vertices, axis=0), size)
    assert vehicles.bodies.tolist() == ["hatchback"]


@pytest.mark.parametrize(
    ("size", "kind", "body"),
    [
        ((5.4, 2.3, 2.0), "Van", "van"),
        ((4.6, 1.75, 1.9), "Car", "suv"),
        ((5.4, 2.3, 2.0), "", "van"),
    ],
)
def test_the_class_of_the_traffic_decides_who_is_a_van(size, kind, body) -> None:
    vehicles = VehicleSampler().sample(traffic_of([size], kinds=[kind]), seed=0)
    assert (vehicles.bodies[0], vehicles.kinds[0]) == (body, kind or "Van")


def test_one_more_car_changes_no_other_cars_look() -> None:
    sampler, sizes = VehicleSampler(), [(4.4, 1.45, 1.8), (3.7, 1.5, 1.65)]
    few = sampler.sample(traffic_of(sizes, ids=[3, 9]), seed=1)
    many = sampler.sample(traffic_of([sizes[0], (4.9, 1.5, 1.8), sizes[1]], ids=[3, 5, 9]), seed=1)
    assert many.select([0, 2]).paints.tolist() == few.paints.tolist()
    np.testing.assert_array_equal(many.select([0, 2]).coefficients, few.coefficients)


def test_all_look_alikes_have_one_shape_and_one_paint() -> None:
    sampler = VehicleSampler(models=8, alike=1.0)
    models = sampler.models_of(0)
    vehicles = sampler.sample(traffic_of(models.size), seed=0)
    assert len(np.unique(vehicles.coefficients, axis=0)) == 1
    assert len(set(vehicles.paints.tolist())) == 1
    different = VehicleSampler(models=8).sample(
        traffic_of(VehicleSampler(models=8).models_of(0).size), seed=0
    )
    assert len(np.unique(different.coefficients, axis=0)) == 8


def test_another_seed_gives_other_cars() -> None:
    one, other = (VehicleSampler().models_of(seed) for seed in (0, 1))
    assert not np.array_equal(one.size, other.size)
    assert np.array_equal(one.size, VehicleSampler().models_of(0).size)


def test_body_and_paint_can_be_chosen() -> None:
    sampler = VehicleSampler(models=4, body="suv", paint="red")
    vehicles = sampler.sample(traffic_of(sampler.models_of(5).size), seed=5)
    assert set(vehicles.bodies.tolist()) == {"suv"}
    assert set(vehicles.paints.tolist()) == {"red"}


def test_the_models_fit_the_lanes_of_live_traffic() -> None:
    from mot_sim.simulation.traffic.highway import HighwayTraffic

    for seed in range(20):
        models = VehicleSampler().models_of(seed)
        HighwayTraffic("street", sizes=models.size, van_size=models.van_size)


@pytest.mark.parametrize(
    ("wrong", "error", "says"),
    [
        ({"models": 0}, BadConfig, "1 or more"),
        ({"body": "limousine"}, UnknownName, "limousine"),
        ({"paint": "gren"}, UnknownName, "Did you mean 'green'"),
        ({"alike": 1.5}, BadConfig, "1.5"),
        ({"coefficients": 21}, BadConfig, "21"),
    ],
)
def test_what_cannot_be_cast_is_refused(wrong, error, says) -> None:
    with pytest.raises(error, match=says):
        VehicleSampler(**wrong)


def test_nobody_is_cast_for_empty_traffic() -> None:
    vehicles = VehicleSampler().sample(traffic_of([]), seed=0)
    assert len(vehicles) == len(Vehicles.empty()) == 0
    assert vehicles.keypoints.shape == (0, 36, 3)


def test_keypoints_lie_on_the_faces_that_are_named_for_them() -> None:
    car = load_fleet(5).car(load_fleet(5).std * (1.0, -1.0, 0.5, 0.5, -0.5))
    assert car.keypoints is not None
    for point, faces in zip(car.keypoints, keypoint_faces(), strict=True):
        assert len(faces)
        middle = car.vertices[car.faces[faces]].mean(axis=(0, 1))
        # A ray from the middle of the faces to the point meets the car there, or ends at it.
        way = point - middle
        if np.linalg.norm(way) > 1e-3:
            depth, _ = hits(car.vertices[car.faces[faces]], middle - way, 2.0 * way)
            assert len(depth) == 0 or depth.max() <= 2.0


def test_a_keypoint_of_the_tail_faces_who_stands_behind() -> None:
    vehicles = VehicleSampler().sample(traffic_of([(4.4, 1.45, 1.8)]), seed=0)
    from tracker.shape import KEYPOINTS_36

    behind = vehicles.faces_eye(np.array([0]), np.array([[-20.0, -1.6, 0.0]]))[0]
    names = np.array(KEYPOINTS_36)
    assert behind[[i for i, name in enumerate(names) if "taillight" in name]].all()
    assert not behind[[i for i, name in enumerate(names) if "headlight" in name]].any()


@given(st.integers(0, 2**32 - 1), st.integers(0, 5))
def test_keypoints_face_an_eye_that_any_of_their_faces_sees(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    vehicles = VehicleSampler().sample(traffic_of([(4.4, 1.45, 1.8), (5.0, 2.0, 2.0)]), seed=0)
    rows, eyes = rng.integers(0, 2, count), rng.uniform(-20.0, 20.0, (count, 3))
    plain = np.zeros((count, 36), bool)
    for row, point in np.ndindex(count, 36):
        first = sum(len(faces) for faces in keypoint_faces()[:point])
        planes = vehicles.skins[rows[row], first : first + len(keypoint_faces()[point])]
        plain[row, point] = (planes[:, :3] @ eyes[row] > planes[:, 3]).any()
    np.testing.assert_array_equal(vehicles.faces_eye(rows, eyes), plain)
