"""Search areas, the pairs inside them, and the distance that decides ties."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.samples import (
    AWAY,
    HEIGHT,
    IMAGE,
    LEVEL,
    PITCHED,
    beliefs_at,
    cars,
    locked,
    outlines,
    pairing_of,
)
from tracker.beliefs import Beliefs
from tracker.costs.gating import project_cuboids
from tracker.geometry import transform
from tracker.types import Camera, Cuboids

RIGHT_BORDER, LOWER_BORDER = IMAGE[0] - 1.0, IMAGE[1] - 1.0


def long_region(x: float, z: float, length: float, width: float = 2.0) -> Cuboids:
    return Cuboids(np.array([[x, 0.0, z]]), np.array([AWAY]), np.array([[length, 1.5, width]]))


@pytest.mark.parametrize("camera", [LEVEL, PITCHED], ids=["level", "pitched"])
def test_search_areas_of_cuboids_ahead_are_their_outlines_in_the_image(camera: Camera) -> None:
    ahead = cars((0.0, 15.0), (-3.0, 30.0), (9.0, 12.0))
    clipped = camera.clip_boxes(outlines(ahead, camera))
    np.testing.assert_allclose(project_cuboids(ahead, camera), clipped, atol=1e-9)


def test_cuboids_behind_the_camera_have_no_search_area() -> None:
    behind = cars((0.0, -10.0), (3.0, -3.0), (0.0, -1.96))
    np.testing.assert_array_equal(project_cuboids(behind, LEVEL), np.zeros((3, 4)))


def test_a_region_that_passes_the_camera_on_the_right_reaches_the_right_border() -> None:
    """Its front at z = 10 m, x = 2 m is at u = 620 + 700 * 2 / 10; its rear is behind us."""
    for length in (8.0, 15.0, 40.0):
        area = project_cuboids(long_region(3.0, 10.0 - 0.5 * length, length), LEVEL)[0]
        np.testing.assert_allclose(area[[0, 2, 3]], [760.0, RIGHT_BORDER, LOWER_BORDER])
        assert area[1] == pytest.approx(187 + 710 * (HEIGHT - 1.5) / 10.0)


def test_a_region_that_passes_the_camera_on_the_left_reaches_the_left_border() -> None:
    area = project_cuboids(long_region(-3.0, 0.0, 20.0), LEVEL)[0]
    np.testing.assert_allclose(area[[0, 2, 3]], [0.0, 480.0, LOWER_BORDER])


def test_a_region_around_the_camera_covers_the_road() -> None:
    area = project_cuboids(long_region(0.0, 0.0, 20.0, width=10.0), LEVEL)[0]
    np.testing.assert_allclose(area[[0, 2, 3]], [0.0, RIGHT_BORDER, LOWER_BORDER])


@given(
    st.floats(-15, 15), st.floats(-10, 40), st.floats(-4, 4), st.floats(0.5, 30), st.floats(0.5, 9)
)
def test_search_areas_hold_every_corner_that_the_camera_sees(x, z, yaw, length, width) -> None:
    region = Cuboids(np.array([[x, 0.0, z]]), np.array([yaw]), np.array([[length, 1.5, width]]))
    area = project_cuboids(region, PITCHED)[0]
    assert (area[:2] <= area[2:]).all()
    corners_cam = transform(PITCHED.T_cam_road, region.corners()[0])
    seen = PITCHED.project(corners_cam[corners_cam[:, 2] > 1.0])
    inside = ((seen > 0) & (seen < [RIGHT_BORDER, LOWER_BORDER])).all(axis=1)
    assert (seen[inside] >= area[:2] - 1e-6).all()
    assert (seen[inside] <= area[2:] + 1e-6).all()


def test_only_boxes_that_meet_the_search_area_are_paired() -> None:
    expected = beliefs_at((-8.0, 20.0), (0.0, 20.0), (8.0, 20.0), std=0.2)
    observed = beliefs_at((0.1, 20.0), (8.1, 20.0))
    rows, columns = pairing_of(expected, observed).pairs
    assert list(zip(rows.tolist(), columns.tolist(), strict=True)) == [(1, 0), (2, 1)]


def test_boxes_that_only_touch_the_search_area_are_not_paired() -> None:
    expected, observed = beliefs_at((0.0, 20.0), std=0.0), beliefs_at((0.0, 20.0))
    area = pairing_of(expected, observed).search_areas[0]
    observed.boxes[0] = [area[2], area[1], area[2] + 30.0, area[3]]
    assert len(pairing_of(expected, observed).pairs[0]) == 0
    observed.boxes[0, 0] -= 0.01
    assert len(pairing_of(expected, observed).pairs[0]) == 1


def test_boxes_above_or_below_the_search_area_are_not_paired() -> None:
    expected, observed = beliefs_at((0.0, 20.0)), beliefs_at((0.0, 20.0), (0.0, 20.0))
    observed.boxes[:, 1::2] += [[-150.0], [120.0]]
    assert len(pairing_of(expected, observed).pairs[0]) == 0


def test_wider_regions_never_lose_a_pair() -> None:
    places = [(x, 20.0) for x in (-6.0, -3.0, 0.0, 3.0, 6.0)]
    sets = []
    for sigmas in (0.0, 1.0, 3.0):
        rows, columns = pairing_of(beliefs_at(*places), beliefs_at(*places), sigmas).pairs
        sets.append(set(zip(rows.tolist(), columns.tolist(), strict=True)))
    assert sets[0] <= sets[1] <= sets[2]
    assert len(sets[0]) < len(sets[2])


def test_a_region_behind_the_camera_is_paired_with_nothing() -> None:
    expected = beliefs_at((0.0, 20.0))
    expected.cuboids.base[0, 2] = -10.0
    pairing = pairing_of(expected, beliefs_at((0.0, 20.0), (2.0, 10.0)))
    assert len(pairing.pairs[0]) == 0


def test_the_image_distance_is_0_for_the_expected_box_and_grows_to_1() -> None:
    expected = beliefs_at(*[(0.0, 20.0)] * 3, std=9.0)
    observed = beliefs_at((0.0, 20.0))
    diagonal = np.hypot(*(observed.boxes[0, 2:] - observed.boxes[0, :2]))
    expected.boxes[1] += [diagonal, 0.0, diagonal, 0.0]
    expected.boxes[2] += [0.0, 1e6, 0.0, 1e6]
    distance = pairing_of(expected, observed).image_distance
    np.testing.assert_allclose(distance, [0.0, 0.5, 1.0], atol=1e-3)


def test_a_pairing_leaves_its_tables_as_they_were() -> None:
    expected, observed = locked(beliefs_at((0.0, 20.0))), locked(beliefs_at((0.0, 21.0)))
    pairing = pairing_of(expected, observed)
    assert len(pairing.pairs[0]) == 1
    assert pairing.boxes_in_image.shape == (1, 4)
    assert len(pairing.observed_regions) == len(pairing.expected_regions) == 1


@pytest.mark.parametrize(("n", "m"), [(0, 2), (2, 0), (0, 0)])
def test_nothing_against_something_has_no_pairs(n: int, m: int) -> None:
    some = beliefs_at((0.0, 20.0), (3.0, 20.0))
    nothing = Beliefs.empty()
    pairing = pairing_of(some if n else nothing, some if m else nothing)
    assert pairing.shape == (n, m)
    assert len(pairing.pairs[0]) == len(pairing.pairs[1]) == 0
    assert pairing.image_distance.shape == (0,)
    assert project_cuboids(Cuboids.empty(), LEVEL).shape == (0, 4)
