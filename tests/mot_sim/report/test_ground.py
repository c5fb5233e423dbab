"""A drive as a map."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.datasets import DetectionLog, RecordedSequence
from mot_sim.report.ground import GroundMap
from mot_sim.simulation.episodes import read_episode
from mot_sim.simulation.rig import Rig
from tests.mot_sim.report.small import drive
from tracker.geometry import homogeneous, rotation_y
from tracker.types import Detections

RIG = Rig.kitti(pitch=0.02)


def turning(frames: int = 8) -> RecordedSequence:
    """5 m ahead and a tenth of a radian to the right each frame, in a world of its own."""
    step = homogeneous(rotation_y(0.1), np.array([0.0, 0.0, 5.0]))
    T_road = np.eye(4)
    poses = []
    T_world_road = homogeneous(rotation_y(1.3), np.array([7.0, -2.0, 3.0]))
    for _ in range(frames):
        poses.append(T_world_road @ T_road @ RIG.camera.T_road_cam)
        T_road = T_road @ step
    nothing = DetectionLog(np.zeros(0, np.int64), Detections.empty())
    return RecordedSequence(
        "turning", RIG.camera, frames, nothing, np.arange(frames), np.array(poses)
    )


def test_planar_poses_start_at_the_first_frame_and_turn_right() -> None:
    poses = GroundMap.of(turning(), None).poses
    assert poses is not None
    np.testing.assert_allclose(poses[0], 0.0, atol=1e-9)
    np.testing.assert_allclose(poses[1], [5.0, 0.0, 0.1], atol=1e-9)
    np.testing.assert_allclose(poses[2, :2], [5.0 + 5.0 * np.cos(0.1), 5.0 * np.sin(0.1)])
    np.testing.assert_allclose(poses[:, 2], 0.1 * np.arange(8), atol=1e-9)


def test_a_point_of_the_world_stays_where_it_is_on_the_map() -> None:
    ground = GroundMap.of(turning(), None)
    ahead = np.array([[0.0, 30.0], [2.0, 30.0]])  # x right, z ahead of frame 0
    places = [ground.on_map(ahead, 0)]
    for frame in (1, 3, 6):
        x, y, heading = ground.pose(frame)
        c, s = np.cos(heading), np.sin(heading)
        seen = (places[0] - (x, y)) @ np.array([[-s, c], [c, s]]).T  # right, ahead of us
        places.append(ground.on_map(seen, frame))
    np.testing.assert_allclose(places, [places[0]] * 4, atol=1e-9)
    np.testing.assert_allclose(places[0], [[30.0, 0.0], [30.0, 2.0]], atol=1e-9)


def test_the_camera_on_the_map_agrees_with_the_places() -> None:
    ground = GroundMap.of(turning(), None)
    for frame in (0, 4):
        point_road = np.array([3.0, 0.0, 20.0])
        point_cam = RIG.camera.T_cam_road @ np.append(point_road, 1.0)
        on_map = ground.T_map_cam(frame, RIG.camera) @ point_cam
        np.testing.assert_allclose(on_map[:2], ground.on_map(point_road[::2], frame), atol=1e-9)
        assert on_map[2] == pytest.approx(0.0, abs=1e-9)


def test_covariances_turn_with_the_places() -> None:
    ground = GroundMap.of(turning(), None)
    along = np.array([[[0.0, 0.0], [0.0, 4.0]]])  # 2 m along our view
    np.testing.assert_allclose(ground.cov_on_map(along, 0)[0], [[4.0, 0.0], [0.0, 0.0]],
                               atol=1e-9)  # fmt: skip
    heading = ground.pose(5)[2]
    direction = np.array([np.cos(heading), np.sin(heading)])
    np.testing.assert_allclose(ground.cov_on_map(along, 5)[0] @ direction, 4.0 * direction)


def test_without_poses_every_frame_is_a_map_of_its_own() -> None:
    blind = replace(turning(), Ts_world_cam=None)
    ground = GroundMap.of(blind, None)
    assert ground.poses is None
    np.testing.assert_allclose(ground.pose(5), 0.0)
    assert ground.our_outline(3).shape == (4, 2)
    assert ground.true_outlines(3).shape == (0, 4, 2)


def test_a_simulated_drive_shows_every_car_and_labels_alone_show_the_same_ones() -> None:
    episode = drive()
    world = episode.traffic_states[2]
    ground = GroundMap.of(episode, episode.truth)
    np.testing.assert_allclose(ground.true_outlines(2), world.footprint())
    labelled = replace(ground, worlds=None).true_outlines(2)
    for corners in labelled:
        middles = world.footprint().mean(axis=1)
        assert np.abs(middles - corners.mean(axis=0)).sum(axis=1).min() < 1e-6
    now = episode.truth.select(episode.truth.frames == 2)
    assert len(labelled) == (now.ids >= 0).sum() > 0
    assert not len(GroundMap.of(episode, None).true_outlines(2))


def test_a_recorded_scene_that_nobody_knows_has_no_roads(tmp_path) -> None:
    from mot_sim.simulation.episodes import EpisodeFiles, record_episode

    record_episode(drive().scene, 0, EpisodeFiles(tmp_path, "0000"))
    stored = read_episode(tmp_path, "0000")
    assert GroundMap.of(stored, None).roads.surfaces == ()
