"""What is left out before its mesh is made is never seen, and hides nobody."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.envs.rollouts import same
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene import Rollout
from mot_sim.simulation.scenery import Spheres
from mot_sim.simulation.scenery.culling import may_be_seen
from mot_sim.simulation.scenery.props import DETAIL_LEVELS
from mot_sim.simulation.scenery.scenery import R_world_piece
from mot_sim.simulation.truth import annotate_frame
from tracker.geometry import invert
from tracker.types import Camera

RIG = Rig.kitti(pitch=0.02, roll=0.01)
EGO = np.array([4.0, -3.0, 0.7])
T_cam_world = invert(RIG.T_world_cam(EGO))
NEAR = 0.3


@pytest.mark.parametrize("name", ["intersection", "highway", "crossing"])
def test_truth_with_what_may_hide_a_car_is_that_with_all_that_is_seen(name: str) -> None:
    rollout = Rollout.of(find_scene(name, frames=31), 1)
    fewer = 0
    for frame in (0, 17, 30):
        state = rollout.traffic_states[frame]
        every = rollout.scenery.seen_from(state.ego, rollout.scene.rig.camera_in(state))
        hiding = rollout.scenery_in(state)
        fewer += len(every) - len(hiding)
        truths = [annotate_frame(state, rollout.scene_meshes, frame, None, one)
                  for one in (every, hiding)]  # fmt: skip
        assert same(*truths)
    assert fewer > 0


@pytest.mark.parametrize("name", ["town", "merge"])
def test_the_mesh_of_a_piece_lies_in_its_box_at_every_level(name: str) -> None:
    scenery = Rollout.of(find_scene(name, frames=2), 2).scenery
    for row in range(0, len(scenery.pieces), 17):
        low, high = scenery.boxes[row].min(axis=0), scenery.boxes[row].max(axis=0)
        for detail in range(DETAIL_LEVELS):
            points = scenery.mesh(row, detail).vertices @ R_world_piece.T
            points[:, :2] += scenery.origins[row]
            assert (points >= low - 1e-9).all()
            assert (points <= high + 1e-9).all()


@pytest.mark.parametrize("name", ["town", "merge"])
def test_every_house_lies_in_its_box_at_every_level(name: str) -> None:
    scenery = Rollout.of(find_scene(name, frames=2), 2).scenery
    assert len(scenery.houses) > 3
    for house, box in zip(scenery.houses, scenery.house_boxes, strict=True):
        low, high = box.min(axis=0), box.max(axis=0)
        for detail in range(DETAIL_LEVELS):
            points = house.make(detail).corners.reshape(-1, 3) * (1.0, 1.0, -1.0)
            assert (points >= low).all()
            assert (points <= high).all()


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_box_passes_of_which_a_point_is_in_the_image_or_before_a_car(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low = np.append(rng.uniform(-60.0, 60.0, 2), -20.0)
    size = np.append(rng.uniform(0.5, 40.0, 2), 20.0)
    pick = np.indices((2, 2, 2)).reshape(3, 8).T
    box = low + pick * size
    points = low + rng.random((400, 3)) * size
    seen = points @ T_cam_world[:3, :3].T + T_cam_world[:3, 3]
    seen = seen[seen[:, 2] > NEAR]
    pixels = RIG.camera.project(seen)
    inside = ((pixels > -0.5) & (pixels < np.array(RIG.camera.image_size) - 0.5)).all(axis=1)
    passes = may_be_seen(box[None], T_cam_world, RIG.camera, NEAR)
    assert passes[0] or not inside.any()
    centre, radius = np.array([rng.uniform(-30.0, 30.0), 0.0, rng.uniform(2.0, 80.0)]), 2.0
    car = Spheres(centre[None], np.array([radius]))
    u = RIG.camera.project(centre[None])[0, 0]
    hides = inside & (np.abs(pixels[:, 0] - u) < 1.0) & (seen[:, 2] < centre[2])
    in_image = 0.0 <= u <= RIG.camera.image_size[0]
    passes = may_be_seen(box[None], T_cam_world, RIG.camera, NEAR, car)
    assert passes[0] or not (in_image and hides.any())


def test_what_lies_behind_the_camera_or_behind_all_cars_is_left_out() -> None:
    pick = np.indices((2, 2, 2)).reshape(3, 8).T
    level, ego = Rig.kitti(), np.zeros(3)
    T = invert(level.T_world_cam(ego))
    boxes = np.array([[x, -1.0, -3.0] + pick * (2.0, 2.0, 3.0) for x in (-9.0, 10.0, 60.0)])
    car = Spheres(np.array([[0.0, 1.0, 30.0]]), np.array([2.5]))
    assert may_be_seen(boxes, T, level.camera, NEAR).tolist() == [False, True, True]
    assert may_be_seen(boxes, T, level.camera, NEAR, car).tolist() == [False, True, False]
    nobody = Spheres(np.zeros((0, 3)), np.zeros(0))
    assert not may_be_seen(boxes, T, level.camera, NEAR, nobody).any()
    assert len(may_be_seen(boxes[:0], T, level.camera, NEAR, car)) == 0


def test_a_camera_with_skew_leaves_out_only_what_lies_behind_it() -> None:
    K = np.array([[700.0, 3.0, 600.0], [0.0, 700.0, 180.0], [0.0, 0.0, 1.0]])
    camera = Camera.mounted(K, (1242, 375), 1.65)
    T = invert(Rig(camera).T_world_cam(np.zeros(3)))
    pick = np.indices((2, 2, 2)).reshape(3, 8).T
    boxes = np.array([[x, 90.0, -3.0] + pick * (2.0, 2.0, 3.0) for x in (-9.0, 10.0)])
    assert may_be_seen(boxes, T, camera, NEAR).tolist() == [False, True]
