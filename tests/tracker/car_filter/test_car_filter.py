"""The state of cars behind their boxes: exact parts against their references, and made drives."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from tests.tracker.samples import LEVEL, PITCHED, outlines
from tracker.car_filter import CarFilter, CarMotion, CarStates, EdgeModel, RoadMemory, RoadModel
from tracker.car_filter.edges import hidden_edges
from tracker.car_filter.estimates import estimate
from tracker.car_filter.motion import RoadStep
from tracker.car_filter.projection import project_boxes
from tracker.car_filter.road_memory import SeenBases
from tracker.car_filter.roughness import RoughnessModel
from tracker.errors import BadConfig
from tracker.geometry import homogeneous, wrap_angle
from tracker.types import Camera, CarEstimates, Cuboids, Detections

MEAN = np.array([0.0, 0.0, 20.0, -1.2, 6.0, *np.log([4.0, 1.5, 1.7]), 0.1])
NO_COV = np.zeros((6, 6))
NO_BOXES = np.zeros((0, 4))


def random_states(count: int) -> np.ndarray:
    rng = np.random.default_rng(4)
    states = np.tile(MEAN, (count, 1))
    states[:, :3] += rng.uniform((-8.0, -0.2, -8.0), (8.0, 0.2, 20.0), (count, 3))
    states[:, 3] = rng.uniform(-3.0, 3.0, count)
    states[:, 5:8] += rng.normal(0.0, 0.1, (count, 3))
    return states


def moving(states: np.ndarray, covs: np.ndarray) -> CarStates:
    """One hypothesis a car, in the second column: it moves."""
    log_weights = np.tile([-np.inf, 0.0], (len(states), 1))
    return CarStates(states[:, None].repeat(2, 1), covs[:, None].repeat(2, 1), log_weights)


def cuboids_of(states: np.ndarray) -> Cuboids:
    return Cuboids(states[:, :3], states[:, 3], np.exp(states[:, 5:8]))


def box_jacobian(states: np.ndarray, camera: Camera) -> np.ndarray:
    """By central differences."""
    jacobian = np.empty((len(states), 4, 9))
    for column in range(9):
        step = np.zeros(9)
        step[column] = 1e-6
        ahead, behind = (project_boxes(states + way * step, camera)[0] for way in (1.0, -1.0))
        jacobian[:, :, column] = (ahead - behind) / 2e-6
    return jacobian


@pytest.mark.parametrize("camera", [LEVEL, PITCHED])
def test_a_projected_car_fills_the_outline_of_its_cuboid(camera: Camera) -> None:
    states = random_states(60)
    expected = outlines(cuboids_of(states), camera)
    inside = (expected[:, 0] > 0.0) & (expected[:, 2] < camera.far_corner[0])
    states, expected = states[inside], expected[inside]
    assert len(states) > 40
    boxes, jacobian = project_boxes(states, camera)
    np.testing.assert_allclose(boxes, expected, atol=1e-9)
    np.testing.assert_allclose(jacobian, box_jacobian(states, camera), atol=1e-4)


def test_of_a_car_beyond_the_image_border_the_part_inside_is_expected() -> None:
    """A long side that crosses the left border: its lower edge there, by similar triangles."""
    states = np.array([[-4.0, 0.0, 4.5, -np.pi / 2, 0.0, *np.log([4.0, 1.5, 1.6]), 0.0]])
    boxes, _ = project_boxes(states, LEVEL)
    K = LEVEL.K
    at_border = 3.2 * K[0, 0] / K[0, 2]  # depth where the near side, x = -3.2, is seen at u = 0
    assert 2.5 < at_border < 6.5
    assert boxes[0, 3] == pytest.approx(K[1, 2] + K[1, 1] * LEVEL.height / at_border)
    assert boxes[0, 0] < 0.0
    nearer = states - [0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]  # no part inside: still finite
    assert np.isfinite(project_boxes(nearer, LEVEL)[0]).all()


@pytest.mark.parametrize("camera", [LEVEL, PITCHED])
def test_of_cars_beyond_the_image_border_the_derivatives_are_those_of_the_parts(
    camera: Camera,
) -> None:
    states = random_states(300) - 12.0 * np.eye(9)[2]
    states = states[states[:, 2] > 4.0]  # no corner is behind the camera
    boxes, jacobian = project_boxes(states, camera)
    cut = (boxes[:, 0] < 0.0) | (boxes[:, 2] > camera.far_corner[0])
    assert cut.sum() > 30
    expected = box_jacobian(states[cut], camera)
    np.testing.assert_allclose(jacobian[cut], expected, rtol=1e-4, atol=1e-2)


def test_the_covariance_follows_the_derivatives_of_the_motion() -> None:
    motion = CarMotion(acceleration_std=0.0, turn_std=0.0, drift_std=0.0, yaw_rate_std=0.0)
    size_cov = 0.01 * np.eye(3)
    T_road = homogeneous(np.array([[0.995, 0.0, 0.0998], [0.0, 1.0, 0.0], [-0.0998, 0.0, 0.995]]))
    T_road[:3, 3] = 0.3, 0.01, -1.2
    shared = RoadStep(T_road, 0.1, 0.1, (0.0, 0.0), 1.0, np.log([4.0, 1.5, 1.6]), size_cov)
    states = random_states(30)
    states[:, 4] = np.abs(states[:, 4])
    rng = np.random.default_rng(1)
    root = rng.normal(size=(30, 9, 9)) * 0.1
    covs = root @ root.transpose(0, 2, 1)

    def go(at: np.ndarray) -> np.ndarray:
        return motion(moving(at, covs), shared, NO_COV, LEVEL).means[:, 1]

    F = np.empty((30, 9, 9))
    for column in range(9):
        step = np.zeros(9)
        step[column] = 1e-5
        F[:, :, column] = (go(states + step) - go(states - step)) / 2e-5
    later = motion(moving(states, covs), shared, NO_COV, LEVEL).covs[:, 1]
    np.testing.assert_allclose(motion.transitions(states, shared), F, rtol=1e-5, atol=1e-7)
    expected = F @ covs @ F.transpose(0, 2, 1)
    distance = np.hypot(*go(states)[:, :3:2].T)
    expected[:, 1, 1] += (1.0 - np.exp(-0.2 / motion.off_road_time)) * motion.off_road_var(distance)
    expected[:, 5:8, 5:8] += (1.0 - np.exp(-0.2 / motion.size_time)) * size_cov
    np.testing.assert_allclose(later, expected, rtol=1e-5, atol=1e-7)


def test_an_update_with_small_innovations_equals_filterpys() -> None:
    states, edges = random_states(20), EdgeModel(border=0.0)
    rng = np.random.default_rng(2)
    root = rng.normal(size=(20, 9, 9)) * 0.2
    covs = root @ root.transpose(0, 2, 1) + 0.01 * np.eye(9)
    expected, H = project_boxes(states, LEVEL)
    boxes = expected + rng.normal(0.0, 1.0, (20, 4))
    variances = np.tile([4.0, 9.0, 16.0, 25.0], (20, 1))
    after = CarFilter(edges=edges)._update(moving(states, covs), boxes, variances, LEVEL).states
    for row in range(20):
        kalman = KalmanFilter(dim_x=9, dim_z=4)
        kalman.x, kalman.P = states[row].copy(), covs[row].copy()
        innovation = boxes[row] - expected[row]
        kalman.update(H[row] @ states[row] + innovation, R=np.diag(variances[row]), H=H[row])
        np.testing.assert_allclose(after.means[row, 1], kalman.x, rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(after.covs[row, 1], kalman.P, rtol=1e-6, atol=1e-8)


def drive(
    places: np.ndarray, yaws: np.ndarray, ego_step: float, size: tuple[float, float, float]
) -> tuple[CarEstimates, RoadMemory]:
    """What is believed of a car at the end of a drive along z in which its boxes are perfect."""
    flat = CarFilter(road=RoadModel(slope_std=0.0))
    T_now_before = homogeneous(t=np.array([0.0, 0.0, -ego_step]))
    states, memory = CarStates.empty(), RoadMemory()
    for index, (place, yaw) in enumerate(zip(places, yaws, strict=True)):
        base = np.array([[place[0], 0.0, place[1] - index * ego_step]])
        box = LEVEL.clip_boxes(outlines(Cuboids(base, np.array([yaw]), np.array([size])), LEVEL))
        if index == 0:
            start = np.array([[place[0], 0.0, place[1] * 1.04]])
            states = flat.start(memory, start, Detections.of(box), box, LEVEL)
            continue
        states, memory, *_ = flat.predict(states, memory, T_now_before, NO_COV, 0.1, LEVEL)
        states, memory, _ = flat.update(states, memory, Detections.of(box), box, 0.1, LEVEL)
    return flat.estimate(states, memory), memory


@pytest.mark.unchecked  # many frames of one shape
@pytest.mark.parametrize("size", [(4.3, 1.6, 1.7), (3.6, 1.4, 1.55)])
def test_a_parked_car_that_is_passed_is_placed_and_measured(
    size: tuple[float, float, float],
) -> None:
    count = 46
    seen, _ = drive(np.tile([4.0, 45.0], (count, 1)), np.full(count, -np.pi / 2), 0.8, size)
    mean = seen.means[0]
    assert np.hypot(mean[0] - 4.0, mean[2] - (45.0 - 0.8 * (count - 1))) < 0.3
    assert mean[4] < 0.2
    assert abs(np.cos(mean[3] + np.pi / 2)) > np.cos(np.radians(8.0))
    np.testing.assert_allclose(np.exp(mean[5:8]), size, rtol=0.08)


@pytest.mark.parametrize(("yaw", "speed"), [(-np.pi / 2, 12.0), (np.pi / 2, 9.0), (0.0, 6.0)])
def test_a_moving_car_is_placed_with_its_heading_and_speed(yaw: float, speed: float) -> None:
    count, size = 30, (3.9, 1.51, 1.61)
    way = np.array([np.cos(yaw), -np.sin(yaw)])
    start = np.array([-3.0, 40.0]) - way * (15.0 if yaw > 0.0 else 0.0)
    start = np.array([-9.0, 25.0]) if yaw == 0.0 else start
    start = np.array([-4.0, 55.0]) if yaw > 0.0 else start
    places = start + way * speed * 0.1 * np.arange(count)[:, None]
    seen, memory = drive(places, np.full(count, yaw), 0.6, size)
    mean = seen.means[0]
    end = places[-1] - np.array([0.0, 0.6 * (count - 1)])
    assert np.hypot(*(mean[:3:2] - end)) < 0.06 * np.hypot(*end)
    assert abs(wrap_angle(mean[3] - yaw)) < np.radians(12.0)
    assert abs(mean[4] - speed) < 0.15 * speed
    assert seen.heading_known[0] > 0.95
    deviation = mean[:3:2] - end
    assert deviation @ np.linalg.solve(seen.covs[0, :3:2, :3:2], deviation) < 9.0
    learned = memory.traffic.sum(axis=0)
    assert (learned[0] > 0.5) == (yaw < 0.0)
    assert (learned[1] > 0.5) == (yaw > 0.0)


def test_the_rear_of_a_car_that_never_moved_is_not_known_for_certain() -> None:
    count = 20
    seen, _ = drive(
        np.tile([-4.0, 40.0], (count, 1)), np.full(count, np.pi / 2), 0.8, (4.0, 1.5, 1.6)
    )
    assert 0.5 <= seen.heading_known[0] < 0.95


def test_an_edge_behind_a_nearer_box_is_hidden_and_others_are_not() -> None:
    boxes = np.array([[100.0, 100.0, 200.0, 160.0]])
    before_left = np.array([[60.0, 110.0, 130.0, 200.0]])
    behind = np.array([[60.0, 80.0, 130.0, 140.0]])
    aside = np.array([[260.0, 110.0, 330.0, 200.0]])
    np.testing.assert_array_equal(hidden_edges(boxes, before_left), [[True, False, False, False]])
    assert not hidden_edges(boxes, behind).any()
    assert not hidden_edges(boxes, np.concatenate((aside, boxes))).any()


def test_the_image_border_cuts_only_cars_that_go_on_beyond_it() -> None:
    """Of a car that is expected to go on beyond the border the left edge tells nothing."""
    states = random_states(1)
    box, cov = project_boxes(states, LEVEL)[0], 0.01 * np.eye(9)[None]
    cut = CarFilter(edges=EdgeModel(border=box[0, 0] + 50.0))
    for shift, is_told in ((20.0, False), (-20.0, True)):
        boxes = box + [[shift, 0.0, 0.0, 0.0], [1.5 * shift, 0.0, 0.0, 0.0]]
        before = moving(states.repeat(2, 0), cov.repeat(2, 0))
        means = cut._update(before, boxes, np.full((2, 4), 400.0), LEVEL).states.means[:, 1]
        assert (np.abs(means[0] - means[1]).max() > 1e-3) == is_told


def test_a_car_that_may_be_turned_to_either_side_is_stated_to_be() -> None:
    means, weights = np.tile(MEAN, (1, 16, 1)), np.zeros((1, 16))
    means[0, :3, 3] = 0.7, -0.7, 0.7 - np.pi  # the last one faces backwards
    weights[0, :3] = 0.5, 0.3, 0.2
    states = CarStates(means, np.tile(0.01 * np.eye(9), (1, 16, 1, 1)), np.zeros((1, 16)))
    found = estimate(states, weights)
    assert found.means[0, 3] == pytest.approx(0.7)
    assert found.covs[0, 3, 3] == pytest.approx(0.01 + 0.3 / 0.8 * 1.4**2)
    assert found.heading_known[0] == pytest.approx(0.8)
    flat = CarFilter(stated_covariance=2.0, stated_floor=(0.1, 0.2))
    assert flat.stated(found, RoadMemory()).covs[0, 4, 4] == pytest.approx(2.0 * 0.01 + 0.2**2)


def test_the_road_falls_where_boxes_of_cars_stand_lower() -> None:
    road, slope = RoadModel(repetition=1.0), 0.02
    base = np.array([[x, slope * z, z] for x, z in ((-4.0, 30.0), (0.0, 35.0), (4.0, 40.0))])
    cuboids = Cuboids(base, np.full(3, -np.pi / 2), np.tile([0.1, 1.5, 1.6], (3, 1)))
    memory = RoadMemory()
    for _ in range(30):
        memory, _ = road.predict(memory, np.eye(4), 0.1)
        boxes = outlines(cuboids, LEVEL)
        bases = SeenBases.of(boxes, np.ones(3), np.zeros((3, 4), bool), LEVEL)
        memory = road.update(memory, bases, np.full(3, 1.5))
    assert memory.slope == pytest.approx(slope, abs=0.002)
    turned, before = road.predict(memory, np.eye(4), 0.0)
    assert turned.slope == pytest.approx(memory.slope) == before


@pytest.mark.parametrize(("off", "is_flat"), [(0.0, True), (0.008, False)])
def test_exact_boxes_far_away_tell_a_flat_road(off: float, is_flat: bool) -> None:
    """off: how far bases lie off the road per metre of distance, up and down in turns."""
    model, memory = RoughnessModel(), RoadMemory()
    z = np.array([20.0, 45.0, 60.0, 70.0])
    for index in range(40):
        base = np.stack([z - 45.0, off * z * (-1) ** (index + np.arange(4)), z], axis=1)
        cuboids = Cuboids(base, np.full(4, -np.pi / 2), np.tile([0.1, 1.6, 1.6], (4, 1)))
        seen = outlines(cuboids, LEVEL), np.ones(4), np.zeros((4, 4), bool)
        bases = SeenBases.of(*seen, LEVEL)
        memory = model.update(model.predict(memory, 0.1), bases, 1.5)
    assert model(memory) < 0.05 if is_flat else model(memory) > 0.95
    later = model.predict(memory, 1000.0)
    assert model(later) == pytest.approx(model(RoadMemory()))  # forgotten


@pytest.mark.parametrize(("name", "share"), [("moving_share", 0.0), ("switch", 1.5)])
def test_shares_that_are_no_probabilities_are_refused(name: str, share: float) -> None:
    with pytest.raises(BadConfig, match=name):
        CarFilter(**{name: share})
    with pytest.raises(BadConfig, match="flat_share"):
        RoughnessModel(flat_share=share - 0.1 if share == 0.0 else share)


def test_without_ego_motion_a_speed_is_as_uncertain_as_the_cameras_own() -> None:
    place = np.array([[3.0, 0.0, 25.0]])
    car = Cuboids(place, np.array([-np.pi / 2]), np.array([[4.0, 1.5, 1.7]]))
    box = outlines(car, LEVEL)
    found = Detections(box, np.ones(1))
    stds = []
    for unknown in (0.0, 1.0):  # m in a frame
        flat = CarFilter(road=RoadModel(slope_std=0.0))
        states = flat.start(RoadMemory(), place, found, box, LEVEL)
        motion_cov = np.diag([0.0, 0.0, unknown**2, 0.0, 0.0, 0.0])
        predicted = flat.predict(states, RoadMemory(), np.eye(4), motion_cov, 0.1, LEVEL)
        estimates = flat.estimate(predicted.states, predicted.memory)
        stds.append(np.sqrt(np.diagonal(estimates.covs[0])))
    assert stds[0][4] < 7.0
    assert stds[1][4] > 9.9  # 1 m in 0.1 s, along the view
    assert stds[1][2] > stds[0][2]
    assert stds[1][6] == pytest.approx(stds[0][6])
