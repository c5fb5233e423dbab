"""Errors of cuboids by hand: place, heading, size, speed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.metrics.cuboid_errors import CuboidErrors, cuboid_errors, ground_speeds
from tests.mot_sim.metrics.cuboid_cases import AHEAD, SIZE, scene
from tracker.errors import BadTracks
from tracker.types import CarEstimates, Tracks

STANDING = np.tile(np.eye(4), (30, 1, 1))


def found_at(truth: Tracks, rows: list[tuple]) -> Tracks:
    """Output whose boxes are the labels', with cuboids of its own."""
    return scene(rows).replaced(boxes=truth.boxes)


def errors_of(truth: list[tuple], found: list[tuple], **more: object) -> CuboidErrors:
    labels = scene(truth)
    return cuboid_errors(labels, found_at(labels, found), 30, **more)  # type: ignore[arg-type]


def test_a_cuboid_too_far_is_off_along_the_ray():
    errors = errors_of([(0, 0, 6.0, 8.0)], [(0, 5, 12.0, 16.0)])
    assert errors.distance[0] == pytest.approx(10.0)
    assert errors.radial[0] == pytest.approx(10.0)
    assert errors.lateral[0] == pytest.approx(0.0)
    assert errors.centre[0] == pytest.approx(10.0)
    assert (errors.truth_ids[0], errors.output_ids[0]) == (0, 5)


def test_a_cuboid_beside_the_ray_is_off_to_the_right():
    errors = errors_of([(0, 0, 0.0, 20.0)], [(0, 0, 0.5, 20.0)])
    assert (errors.lateral[0], errors.radial[0]) == (0.5, 0.0)


@pytest.mark.parametrize(
    ("yaw", "over_30", "over_90"),
    [(AHEAD, 0.0, 0.0), (-AHEAD, 1.0, 1.0), (0.0, 1.0, 0.0), (AHEAD + 2 * np.pi, 0.0, 0.0)],
)
def test_headings_are_wrong_beyond_30_degrees_and_backwards_beyond_90(
    yaw: float, over_30: float, over_90: float
):
    numbers = errors_of([(0, 0, 0.0, 20.0)], [(0, 0, 0.0, 20.0, yaw - 0.001)]).numbers()
    assert numbers["heading_over_30"] == over_30
    assert numbers["heading_over_90"] == over_90


def test_cars_are_grouped_by_what_they_do():
    rows = [(f, 0, 0.0, 10.0 + 1.5 * f) for f in range(21)]  # 15 m/s our way
    rows += [(f, 1, 5.0, 30.0, -AHEAD) for f in range(21)]  # parked, facing us
    rows += [(f, 2, -9.0, 30.0, 0.3) for f in range(21)]  # parked across
    rows.sort(key=lambda row: row[:2])
    errors = errors_of(rows, rows, Ts_world_road=STANDING)
    counts = {name: int(mask.sum()) for name, mask in errors.groups().items()}
    assert counts == {"all": 63, "moving": 21, "parked": 42, "oncoming": 21, "turned": 21}
    assert errors.speed[errors.truth_ids == 0] == pytest.approx(15.0)
    assert errors.numbers()["parked_over_1mps"] == 0.0


def test_a_parked_car_that_seems_to_move_is_seen():
    parked = [(f, 0, 0.0, 20.0) for f in range(21)]
    creeping = [(f, 0, 0.0, 20.0 + 0.2 * f) for f in range(21)]  # 2 m/s
    numbers = errors_of(parked, creeping, Ts_world_road=STANDING).numbers()
    assert numbers["parked_over_1mps"] == 1.0
    assert numbers["parked_drift"] == pytest.approx(2.0)


def with_estimates(found: Tracks, speed: float, std: float, known: float) -> Tracks:
    """Output that states the same std of everything."""
    count = len(found)
    means = np.tile([0.0] * 4 + [speed] + [0.0] * 3, (count, 1))
    covs = np.tile(np.eye(8) * std**2, (count, 1, 1))
    return found.replaced(estimates=CarEstimates(means, covs, np.full(count, known)))


def test_stated_speeds_go_before_those_of_the_places():
    parked = [(f, 0, 0.0, 20.0) for f in range(21)]
    creeping = [(f, 0, 0.0, 20.0 + 0.2 * f) for f in range(21)]
    truth = scene(parked)
    found = with_estimates(found_at(truth, creeping), 0.5, 1.0, 0.9)
    numbers = cuboid_errors(truth, found, 30, STANDING).numbers()
    assert numbers["parked_over_1mps"] == 0.0
    assert numbers["parked_drift"] == pytest.approx(2.0)


def test_errors_are_held_against_the_stated_covariance():
    rows = [(0, car, 8.0 * car - 16.0, 20.0) for car in range(4)]
    off = [(0, 0, -15.5, 20.0), (0, 1, -8.0, 21.5), (0, 2, 0.0, 24.0), (0, 3, 8.0, 20.0, -AHEAD)]
    truth = scene(rows)
    found = with_estimates(found_at(truth, off), 0.0, 1.0, 0.8)
    errors = cuboid_errors(truth, found, 30, STANDING)
    np.testing.assert_allclose(errors.stated.centre, [0.25, 2.25, 16.0, 0.0])
    np.testing.assert_allclose(errors.stated.radial_std, 1.0)
    numbers = errors.numbers()
    assert numbers["centre_inside_1_sigma"] == 0.5
    assert numbers["centre_inside_2_sigma"] == 0.75
    assert numbers["centre_nees"] == pytest.approx(18.5 / 4)
    assert numbers["heading_inside_2_sigma"] == 1.0  # the backwards one is the chance's business
    assert (numbers["heading_known"], numbers["heading_known_true"]) == (0.8, 0.75)
    assert numbers["heading_known_brier"] == pytest.approx(0.75 * 0.04 + 0.25 * 0.64)
    assert numbers["size_nees"] == pytest.approx(0.0)


def test_output_that_states_nothing_is_not_judged_by_it():
    numbers = errors_of([(0, 0, 0.0, 20.0)], [(0, 0, 0.0, 20.0)]).numbers()
    for name in ("centre_nees", "speed_inside_1_sigma", "heading_known", "heading_known_brier"):
        assert np.isnan(numbers[name])


def test_without_the_cameras_motion_no_speed_is_known():
    rows = [(f, 0, 0.0, 20.0) for f in range(3)]
    errors = errors_of(rows, rows)
    assert np.isnan(errors.speed).all()
    assert not errors.moving.any()
    assert not errors.parked.any()
    assert np.isnan(errors.numbers()["parked_over_1mps"])


def test_the_cameras_own_motion_is_taken_out():
    poses = STANDING.copy()
    poses[:, 2, 3] = np.arange(30.0)  # 10 m/s ahead
    parked = scene([(f, 0, 2.0, 40.0 - f) for f in range(21)])
    np.testing.assert_allclose(ground_speeds(parked, poses, 10.0), 0.0, atol=1e-12)


def test_rows_of_one_frame_only_have_no_speed():
    assert np.isnan(ground_speeds(scene([(3, 0, 0.0, 20.0)]), STANDING, 10.0)).all()
    assert ground_speeds(scene([]), STANDING, 10.0).shape == (0,)


def test_sizes_are_compared_by_length_height_and_width():
    larger = (SIZE[0] + 0.4, SIZE[1] - 0.1, SIZE[2] + 0.2)
    errors = errors_of([(0, 0, 0.0, 20.0)], [(0, 0, 0.0, 20.0, AHEAD, *larger)])
    np.testing.assert_allclose(errors.size, [[0.4, -0.1, 0.2]])
    numbers = errors.numbers()
    assert numbers["height_error"] == pytest.approx(0.1)


def test_what_is_not_known_is_left_out_and_counted():
    truth = [(0, 0, -4.0, 20.0), (0, 1, 4.0, 20.0)]
    found = [(0, 0, -4.0, 21.0), (0, 1, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan)]
    numbers = errors_of(truth, found).numbers()
    assert (numbers["cuboid_known"], numbers["matched_rows"]) == (0.5, 2)
    assert numbers["centre_median"] == pytest.approx(1.0)
    assert numbers["within_2m"] == 1.0
    assert numbers["heading_over_30"] == 0.0


def test_nothing_matched_is_nothing_known():
    numbers = errors_of([], []).numbers()
    assert numbers["matched_rows"] == 0
    assert np.isnan(numbers["centre_median"])
    assert np.isnan(numbers["iou_3d"])


def test_errors_are_shown_by_distance():
    truth = [(0, 0, 0.0, 5.0), (0, 1, 4.0, 25.0), (0, 2, -4.0, 49.9)]
    ranges = errors_of(truth, truth).by_distance()
    assert [(name, len(part)) for name, part in ranges] == [
        ("0-10 m", 1), ("10-20 m", 0), ("20-30 m", 1), ("30-50 m", 0), ("50-80 m", 1)
    ]  # fmt: skip


def test_results_without_cuboids_are_named():
    truth = scene([(0, 0, 0.0, 20.0)])
    with pytest.raises(BadTracks, match="output: 1 rows, and none with a cuboid"):
        cuboid_errors(truth, truth.replaced(cuboids=None), 30)


@given(
    x=st.floats(-30.0, 30.0), z=st.floats(3.0, 60.0),
    dx=st.floats(-3.0, 3.0), dz=st.floats(-3.0, 3.0),
)  # fmt: skip
def test_radial_and_lateral_make_up_the_distance(x: float, z: float, dx: float, dz: float):
    errors = errors_of([(0, 0, x, z)], [(0, 0, x + dx, z + dz)])
    places, found = errors.from_above()
    np.testing.assert_allclose(places, [[x, z]], atol=1e-9)
    np.testing.assert_allclose(found, [[x + dx, z + dz]], atol=1e-9)
    assert np.hypot(errors.radial, errors.lateral)[0] == pytest.approx(errors.centre[0], abs=1e-9)
