"""The scene from above."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.report.colours import EGO, colour_of_id
from mot_sim.report.topview import TopView, road_contacts, trails_until
from mot_sim.rig import Rig
from mot_sim.traffic import Roads, Route, Script, Scripted
from mot_sim.truth import boxes_around, clip_to_image, project_edges
from tests.mot_sim.truth.worlds import truth_of

RIG = Rig.kitti()
VIEW = TopView(Roads(), origin=(-10.0, -20.0), scale=5.0, size=(400, 200))


def drive(frame_count: int = 12):
    """We follow a car 15 m ahead and 1 m to the right, both at 5 m/s."""
    ego = Script(Route([(0.0, 0.0), (90.0, 0.0)]), [(0.0, 5.0)])
    lead = Script(Route([(15.0, 1.0), (90.0, 1.0)]), [(0.0, 5.0)])
    traffic = Scripted([lead], ego)
    return [traffic.at(0.1 * frame) for frame in range(frame_count)]


def contacts_of(worlds):
    tracks = truth_of(*worlds, rig=RIG).tracks
    assert tracks.cuboids is not None
    boxes = boxes_around(project_edges(tracks.cuboids, RIG.camera))
    tracks = replace(tracks, boxes=clip_to_image(boxes, RIG.camera)[0])
    return road_contacts(tracks, RIG, {frame: world.ego for frame, world in enumerate(worlds)})


def test_world_x_is_to_the_right_and_world_y_down() -> None:
    np.testing.assert_allclose(VIEW.pixels(np.array([[0.0, 0.0], [1, 0], [0, 1]])),
                               [[50, 100], [55, 100], [50, 105]])  # fmt: skip


def test_an_exact_box_meets_the_road_at_the_cars_rear() -> None:
    worlds = drive()
    for frame, point in contacts_of(worlds)[0].items():
        rear = worlds[frame].x[0] - 0.5 * worlds[frame].size[0, 0]
        np.testing.assert_allclose(point[0], rear, atol=1e-6)
        assert point[1] == pytest.approx(1.0, abs=0.15)


def test_boxes_cut_by_the_border_have_no_place() -> None:
    traffic = Scripted([Script(Route([(1.5, 3.0), (9.0, 3.0)]), [(0.0, 0.0)])],
                       Script(Route([(0.0, 0.0), (9.0, 0.0)]), [(0.0, 0.0)]))  # fmt: skip
    assert contacts_of([traffic.at(0.0)]) == {}


def test_trails_end_a_second_after_the_last_sight() -> None:
    contacts = {3: {frame: np.array([float(frame), 0.0]) for frame in range(5)}}
    assert trails_until(contacts, 4, 3)[3][:, 0].tolist() == [2.0, 2.5, 3.0]
    assert 3 in trails_until(contacts, 13, 20)
    assert trails_until(contacts, 14, 20) == {}
    assert trails_until({}, 14, 20) == {}


def test_the_panel_shows_us_and_the_tracks() -> None:
    worlds = drive()
    image = VIEW.draw(worlds[-1], RIG, trails_until(contacts_of(worlds), 11, 25))
    assert image.shape == (200, 400, 3)
    u, v = np.round(VIEW.pixels(worlds[-1].ego[None, :2])[0]).astype(int)
    assert tuple(image[v, u]) == EGO
    assert (image == colour_of_id(0)).all(axis=2).sum() > 50


def test_an_empty_road_is_drawn() -> None:
    traffic = Scripted([], Script(Route([(0.0, 0.0), (9.0, 0.0)]), [(0.0, 0.0)]))
    assert VIEW.draw(traffic.at(0.0), RIG, {}).shape == (200, 400, 3)
