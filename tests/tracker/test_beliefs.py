"""Lifting boxes to the road (eq. 2 with its covariance), and the regions around beliefs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.samples import (
    AWAY,
    CAR,
    HEIGHT,
    LEVEL,
    PITCHED,
    beliefs_at,
    cars,
    locked,
    outlines,
)
from tracker.beliefs import MAX_CONTACT_DEPTH, MIN_DEPTH, Beliefs, Lift
from tracker.geometry import road_contact, rotation_x
from tracker.types import Camera, Detections

# Its bottom centre, 70 px right of and 71 px below the principal point, touches the road at
# z = 1.65 m * 710 / 71 = 16.5 m and x = 1.65 m.
BOX = np.array([[650.0, 200.0, 730.0, 258.0]])
PLAIN = Lift()
EXACT = Lift(pitch_std=0.0, height_std=0.0)


def lifted(
    box: np.ndarray, lift: Lift = PLAIN, score: float = 1.0, camera: Camera = LEVEL, **cues
) -> Beliefs:
    return lift(Detections(box, np.full(len(box), score), **cues), camera)


@pytest.mark.parametrize(
    ("yaw", "behind"),
    [
        (-np.pi / 2, 0.5 * 3.9),
        (np.pi / 2, 0.5 * 3.9),
        (0.0, 0.5 * 1.63),
        (-np.pi / 4, 0.5 * (3.9 + 1.63) * np.sqrt(0.5)),
    ],
)
def test_the_centre_lies_behind_the_contact_by_half_the_yawed_extent(yaw, behind) -> None:
    by_default, by_cue = lifted(BOX, Lift(yaw=yaw)), lifted(BOX, yaw=np.array([yaw]))
    along_the_ray = [1.65 + 0.1 * behind, 0.0, 16.5 + behind]
    np.testing.assert_allclose(by_default.cuboids.base, [along_the_ray], atol=1e-9)
    np.testing.assert_allclose(by_cue.cuboids.base, [along_the_ray], atol=1e-9)
    assert by_cue.cuboids.yaw[0] == yaw
    np.testing.assert_array_equal(by_cue.boxes, BOX)


def test_a_measured_size_takes_the_place_of_the_mean_car() -> None:
    truck = lifted(BOX, size=np.array([[10.0, 3.5, 2.5]]))
    np.testing.assert_allclose(truck.cuboids.base, [[1.65 + 0.5, 0.0, 16.5 + 5.0]], atol=1e-9)
    np.testing.assert_array_equal(truck.cuboids.size, [[10.0, 3.5, 2.5]])


def test_a_cue_that_was_not_measured_leaves_the_mean_car_in_its_row() -> None:
    yaw, size = np.array([np.nan, 0.0]), np.array([[9.0, 3.0, 2.0], [np.nan] * 3])
    both = lifted(np.tile(BOX, (2, 1)), yaw=yaw, size=size)
    assert both.cuboids.yaw.tolist() == [AWAY, 0.0]
    np.testing.assert_array_equal(both.cuboids.size, [[9.0, 3.0, 2.0], CAR])
    assert np.isfinite(both.cuboids.base).all()


@pytest.mark.parametrize("camera", [LEVEL, PITCHED], ids=["level", "pitched"])
@pytest.mark.parametrize("place", [(0.0, 15.0), (3.0, 25.0), (-6.0, 40.0)])
def test_a_seen_car_is_lifted_to_where_it_stands(camera: Camera, place) -> None:
    belief = lifted(outlines(cars(place), camera), camera=camera)
    # The bottom of the box is the near corner's; its middle is not quite the near face's.
    np.testing.assert_allclose(belief.cuboids.base[0, ::2], place, rtol=0.03, atol=0.3)
    assert belief.cuboids.base[0, 1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("camera", [LEVEL, PITCHED], ids=["level", "pitched"])
def test_the_covariance_is_that_of_a_monte_carlo_of_eq_2(camera: Camera) -> None:
    lift, n, rng = Lift(edge_std=0.02, pitch_std=0.002), 200_000, np.random.default_rng(3)
    bottom = np.array([690.0, 270.0])
    box = np.array([[640.0, 210.0, 740.0, 270.0]])
    pixels = bottom + rng.normal(0.0, 0.02 * 60.0, (n, 2))
    nods, heaves = rng.normal(0.0, 0.002, n), rng.normal(0.0, lift.height_std, n)
    rays = camera.rays_road(pixels)
    c, s = np.cos(nods), np.sin(nods)
    turned = np.stack(
        (rays[:, 0], c * rays[:, 1] - s * rays[:, 2], s * rays[:, 1] + c * rays[:, 2])
    )
    np.testing.assert_allclose(turned[:, 0], rotation_x(nods[0]) @ rays[0])
    contacts = np.concatenate(
        [road_contact(turned.T[i : i + 1], HEIGHT + heaves[i]) for i in range(2000)]
    )[:, ::2]
    everything = (turned / turned[1] * (HEIGHT + heaves))[::2].T
    np.testing.assert_allclose(everything[:2000], contacts)
    sampled = np.cov(everything.T)
    ours = lifted(box, lift, camera=camera).cov[0, :2, :2]
    # 200,000 samples leave 0.3 %; the rest is the curvature that the linearisation leaves out.
    np.testing.assert_allclose(ours, sampled, rtol=0.04, atol=0.04 * sampled.max() * 0.1)


@pytest.mark.parametrize(("score", "factor"), [(1.0, 1.0), (0.5, 1.5), (0.0, 2.0), (7.0, 1.0)])
def test_sigma_doubles_from_score_1_to_score_0(score: float, factor: float) -> None:
    sure, doubtful = lifted(BOX, EXACT), lifted(BOX, EXACT, score=score)
    np.testing.assert_allclose(doubtful.cov[0, :2, :2], factor**2 * sure.cov[0, :2, :2])
    # A metre of depth is f h / Z^2 pixels; the box is 58 pixels high.
    by_hand = 16.5**2 / (710 * 1.65) * 0.03 * 58.0
    assert np.sqrt(sure.cov[0, 1, 1]) == pytest.approx(by_hand)


def test_the_velocity_is_unknown_with_the_prior_of_the_lift() -> None:
    belief = lifted(BOX, Lift(speed_std=(2.0, 5.0)))
    np.testing.assert_array_equal(belief.velocity, [[0.0, 0.0]])
    np.testing.assert_array_equal(belief.cov[0, 2:], [[0, 0, 4, 0], [0, 0, 0, 25]])


@pytest.mark.parametrize(
    ("top", "depth"),
    [(74.0, 710 * 1.5 / 300), (300.0, 1.65 * 710 / 187), (-800.0, 1.0)],
    ids=["by its height", "no further than the border's contact", "no nearer than NEAR"],
)
def test_a_box_cut_by_the_lower_border_is_placed_by_its_height(top, depth) -> None:
    cut = lifted(np.array([[570.0, top, 670.0, 374.0]]))  # its centre is the image's: x = 0
    assert cut.cuboids.base[0, 2] == pytest.approx(max(depth, MIN_DEPTH) + 0.5 * CAR[0], rel=0.02)
    assert np.sqrt(cut.cov[0, 1, 1]) == pytest.approx(
        np.hypot(0.5 * max(depth, MIN_DEPTH), 1), rel=0.02
    )


def test_a_box_that_ends_above_the_horizon_is_placed_by_its_height() -> None:
    above = lifted(np.array([[600.0, 110.0, 640.0, 150.0]]))
    depth = 710 * 1.5 / 40
    assert above.cuboids.base[0, 2] == pytest.approx(depth + 0.5 * CAR[0])
    assert above.cuboids.base[0, 1] < 0.0  # it hangs above the road
    assert np.isfinite(above.cov).all()


def test_a_box_that_ends_just_below_the_horizon_is_not_beyond_what_a_pixel_can_tell() -> None:
    far = lifted(np.array([[600.0, 186.5, 602.0, 188.0]]))
    assert far.cuboids.base[0, 2] <= MAX_CONTACT_DEPTH + CAR[0]


def test_the_boxs_height_pulls_the_depth_between_both() -> None:
    lift = Lift(use_box_height=True)
    by_road, fused = lifted(BOX), lifted(BOX, lift)
    z_road, z_height = 16.5, 710 * 1.5 / 58
    var_road = by_road.cov[0, 1, 1]
    var_height = z_height**2 * (2 * lift.edge_std**2 + lift.car_size_std**2)
    by_hand = (z_road / var_road + z_height / var_height) / (1 / var_road + 1 / var_height)
    assert z_road < by_hand < z_height
    assert fused.cuboids.base[0, 2] == pytest.approx(by_hand + 0.5 * CAR[0])
    assert 1 / fused.cov[0, 1, 1] == pytest.approx(1 / var_road + 1 / var_height)


def test_the_height_of_a_cut_box_is_not_fused_a_second_time() -> None:
    cut = np.array([[570.0, 200.0, 670.0, 374.0]])
    plain, fused = lifted(cut), lifted(cut, Lift(use_box_height=True))
    np.testing.assert_allclose(fused.cuboids.base, plain.cuboids.base)
    np.testing.assert_allclose(fused.cov, plain.cov)


@given(
    st.tuples(st.floats(-200, 1400), st.floats(-200, 500)),
    st.tuples(st.floats(0, 600), st.floats(0, 500)),
    st.floats(-1, 2),
    st.booleans(),
)
def test_every_box_is_lifted_to_a_finite_place_with_a_positive_covariance(
    corner, sides, score, use_box_height
) -> None:
    box = np.array([[*corner, corner[0] + sides[0], corner[1] + sides[1]]])
    belief = lifted(box, Lift(use_box_height=use_box_height), score)
    assert np.isfinite(belief.cuboids.base).all()
    assert belief.cuboids.base[0, 2] >= MIN_DEPTH
    assert use_box_height or belief.cuboids.base[0, 2] <= MAX_CONTACT_DEPTH + CAR[0]
    np.testing.assert_allclose(belief.cov, belief.cov.transpose(0, 2, 1), rtol=1e-9)
    assert np.linalg.eigvalsh(belief.cov[0]).min() > 0.0


def test_lifting_leaves_its_input_as_it_was_and_no_boxes_lift_to_nothing() -> None:
    boxes = np.array([[570.0, 200.0, 670.0, 374.0], [600, 110, 640, 150], *BOX])
    detections = Detections(boxes, np.ones(3), yaw=np.zeros(3), size=np.tile(CAR, (3, 1)))
    Lift(use_box_height=True)(locked(detections), LEVEL)
    assert len(Lift()(Detections.empty(), LEVEL)) == 0


def test_a_region_is_stretched_along_and_across_the_car_by_its_doubt() -> None:
    belief = beliefs_at((0.0, 20.0), (0.0, 20.0))
    belief.cov[:, 0, 0], belief.cov[:, 1, 1] = 1.0, 4.0
    belief.cuboids.yaw[1] = 0.0
    away, across = belief.region(1.5).size
    np.testing.assert_allclose(away, CAR + 3.0 * np.array([2.0, 0.0, 1.0]))
    np.testing.assert_allclose(across, CAR + 3.0 * np.array([1.0, 0.0, 2.0]))


def test_a_region_follows_a_slanted_doubt_in_the_axes_of_the_car() -> None:
    """Doubt only along the direction (1, -1) of (x, z): forward for a car with yaw pi/4."""
    belief = beliefs_at((0.0, 20.0), yaw=np.pi / 4)
    belief.cov[0, :2, :2] = 9.0 * np.array([[0.5, -0.5], [-0.5, 0.5]])
    np.testing.assert_allclose(
        belief.region(1.0).size, [CAR + np.array([6.0, 0.0, 0.0])], atol=1e-6
    )


@given(st.floats(-4, 4), st.floats(0.0, 4.0), st.floats(0.0, 4.0))
def test_regions_contain_the_cuboid_and_grow_with_sigmas(yaw, fewer, more) -> None:
    belief = beliefs_at((1.0, 20.0), yaw=yaw)
    small, large = sorted((fewer, more))
    sizes = [belief.region(s).size for s in (0.0, small, large)]
    np.testing.assert_allclose(sizes[0], belief.cuboids.size)
    assert (sizes[0] <= sizes[1]).all()
    assert (sizes[1] <= sizes[2]).all()


def test_nothing_has_no_region() -> None:
    assert len(Beliefs.empty().region(1.0)) == 0


def test_what_is_only_assumed_of_a_car_is_no_part_that_was_measured() -> None:
    boxes = np.array([[600.0, 180.0, 650.0, 220.0]] * 2)
    plain = Lift()(Detections.of(boxes, np.ones(2)), LEVEL)
    part = Lift().measured_part(plain)
    assert np.isnan(part.yaw).all()
    assert np.isnan(part.size).all()
    np.testing.assert_array_equal(part.base, plain.cuboids.base)
    size = np.array([[4.2, 1.4, 1.7], [np.nan] * 3])
    given = Detections.of(boxes, np.ones(2), yaw=np.array([0.3, np.nan]), size=size)
    part = Lift().measured_part(Lift()(given, LEVEL))
    np.testing.assert_array_equal(part.yaw, [0.3, np.nan])
    np.testing.assert_array_equal(part.size, size)
