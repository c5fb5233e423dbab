"""The drawn world agrees with the exact truth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.report import draw_detections, draw_tracks, draw_world
from mot_sim.report.carbody import car_faces
from mot_sim.report.colours import colour_of_id
from mot_sim.rig import Rig
from mot_sim.traffic.roads import Roads, rectangle
from mot_sim.traffic.world import World
from mot_sim.truth import frame_truth
from tracker.types import Detections, Tracks

ROADS = Roads((rectangle("asphalt", (-50.0, 200.0), (-4.0, 4.0)),))
RIG = Rig.kitti()


def world_of(*cars: tuple[float, float, float], size=(4.2, 1.5, 1.8)) -> World:
    poses = np.array(cars, dtype=float).reshape(-1, 3)
    n = len(poses)
    return World(
        0.0, np.arange(n), poses[:, 0], poses[:, 1], poses[:, 2], np.zeros(n),
        np.tile(np.array(size), (n, 1)), np.zeros(3), np.array([4.4, 1.45, 1.8]),
    )  # fmt: skip


def changed_pixels(world: World, rig: Rig) -> np.ndarray:
    """Where the world looks other than without its cars."""
    return (draw_world(world, rig, ROADS) != draw_world(world_of(), rig, ROADS)).any(axis=2)


@settings(max_examples=15)
@given(st.floats(9, 50), st.floats(-5, 5), st.floats(-3.1, 3.1), st.booleans())
def test_a_car_is_drawn_inside_its_exact_box(x, y, heading, is_van) -> None:
    world = world_of((x, y, heading), size=(5.2, 2.3, 2.0) if is_van else (4.2, 1.5, 1.8))
    rig = Rig.kitti(pitch=0.01, roll=0.01)
    truth = frame_truth(world, rig, 0)
    rows, columns = np.nonzero(changed_pixels(world, rig))
    left, top, right, bottom = truth.tracks.boxes[0]
    pad = 2.0 + 0.07 * (right - left)  # the shadow is a little larger than the car
    assert left - pad <= columns.min() <= left + pad + 2
    assert right - pad - 2 <= columns.max() <= right + pad
    assert top - 2 <= rows.min() <= top + 0.25 * (bottom - top) + 2
    assert abs(rows.max() - bottom) <= pad + 2


def test_a_car_behind_us_is_not_drawn() -> None:
    assert not changed_pixels(world_of((-10.0, 0.0, 0.0)), RIG).any()


def test_a_car_beside_us_is_cut_at_the_near_plane_without_lines_through_the_picture() -> None:
    changed = changed_pixels(world_of((1.5, 3.0, 0.0)), RIG)
    assert changed.any()
    assert not changed[:, :1000].any()
    assert not changed[:150].any()


def test_the_nearer_car_covers_the_farther() -> None:
    pair = draw_world(world_of((30.0, 0.0, 0.0), (12.0, 0.0, np.pi / 2)), RIG, ROADS)
    swapped = world_of((12.0, 0.0, np.pi / 2))
    alone = draw_world(
        World(0.0, np.array([1]), swapped.x, swapped.y, swapped.heading, swapped.speed,
              swapped.size, swapped.ego, swapped.ego_size), RIG, ROADS,
    )  # fmt: skip
    inside = np.s_[215:290, 560:660]
    assert (pair[inside] == alone[inside]).all()


def test_the_sky_is_above_and_the_road_below() -> None:
    image = draw_world(world_of(), RIG, ROADS).astype(int)
    assert image.shape == (375, 1242, 3)
    assert image[5, 600, 2] > image[5, 600, 0] + 40
    assert np.ptp(image[370, 600]) < 20


def test_every_face_of_a_car_lies_inside_its_cuboid() -> None:
    for is_van in (False, True):
        for face in car_faces(is_van):
            assert (np.abs(face.corners[:, :2]) <= 0.5 + 1e-9).all()
            assert (face.corners[:, 2] >= -1e-9).all()
            assert (face.corners[:, 2] <= 1.0 + 1e-9).all()


def test_tracks_have_the_colours_of_their_ids() -> None:
    image = np.zeros((375, 1242, 3), np.uint8)
    tracks = Tracks(np.zeros(1, np.int64), np.array([4]), np.array([[100.0, 100, 200, 150]]))
    draw_tracks(image, tracks)
    assert tuple(image[150, 150]) == colour_of_id(4)
    assert not image[120, 150].any()


@pytest.mark.parametrize("corner", [(0.0, 0.0), (1230.0, 360.0)])
def test_labels_stay_in_the_image(corner) -> None:
    image = np.zeros((375, 1242, 3), np.uint8)
    u, v = corner
    tracks = Tracks(np.zeros(1, np.int64), np.array([123]), np.array([[u, v, u + 11.0, v + 14.0]]))
    draw_tracks(image, tracks)
    colour = colour_of_id(123)
    assert (image == colour).all(axis=2).sum() > 200


def test_nothing_detected_and_nobody_tracked_draw_nothing() -> None:
    image = np.zeros((20, 30, 3), np.uint8)
    draw_detections(image, Detections.empty())
    draw_tracks(image, Tracks.empty())
    assert not image.any()
