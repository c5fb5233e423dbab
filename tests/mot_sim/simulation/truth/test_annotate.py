"""Ground truth from pixels: boxes, visible fractions, keypoints, occluders."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.simulation.registry import SCENES, find_scene
from mot_sim.simulation.renderers import NO_INSTANCE, MeshInstances, View, find_renderer
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene import Rollout
from mot_sim.simulation.sensors.sightings import Sightings
from mot_sim.simulation.traffic.traffic_state import TrafficState
from mot_sim.simulation.truth import KeypointVisibility, annotate, annotate_frame, occlusion_level
from tests.mot_sim.simulation.cars.rays import hits
from tests.mot_sim.simulation.renderers.shapes import at, box
from tests.mot_sim.simulation.truth.states import RIG, meshes_of, state_of, truth_of
from tracker.shape import KEYPOINTS_36
from tracker.types import Camera

RASTER = find_renderer("raster")


def mesh_box(state: TrafficState, row: int, rig: Rig = RIG) -> np.ndarray:
    """The box around the projected vertices of a car before the camera."""
    scene_meshes = meshes_of(state, rig=rig)
    instances = scene_meshes.instances(state)
    T = instances.T_cam_object[row]
    mesh = instances.meshes[row]
    points = mesh.vertices[np.unique(mesh.faces)]
    pixels = rig.camera.project(points @ T[:3, :3].T + T[:3, 3])
    return np.concatenate((pixels.min(axis=0), pixels.max(axis=0)))


def test_the_box_of_a_car_is_that_of_its_projected_mesh() -> None:
    state = state_of((20.0, 0.5, 0.3), (35.0, -6.0, 2.0))
    truth = truth_of(state)
    for row in range(2):
        np.testing.assert_allclose(truth.tracks.boxes[row], mesh_box(state, row), atol=0.05)
    assert truth.tracks.kinds is not None
    assert truth.tracks.kinds.tolist() == ["Car", "Car"]
    assert (truth.visible == 1.0).all()
    assert (truth.truncation == 0.0).all()
    assert (truth.pixels == truth.amodal_pixels).all()


@pytest.mark.parametrize("pitch", [0.0, 0.04])
def test_boxes_of_visible_cars_equal_their_silhouettes_within_a_pixel(pitch) -> None:
    rig = Rig.kitti(pitch=pitch)
    rng = np.random.default_rng(3)
    compared = 0
    for _ in range(12):
        x = rng.uniform(6, 70, 3) * (1, 1, 1)
        poses = [(x[i], (i - 1) * 0.3 * x[i] + rng.normal(), rng.uniform(-3, 3)) for i in range(3)]
        truth = truth_of(state_of(*poses), rig=rig)
        free = (truth.visible == 1.0) & (truth.truncation == 0.0)
        pixels = truth.visible_boxes + (-0.5, -0.5, 0.5, 0.5)  # to the outer edges of the pixels
        difference = np.abs(pixels - truth.amodal_boxes)[free]
        compared += len(difference)
        assert (difference <= 1.0).all()
    assert compared > 15


def test_pixels_are_those_of_the_rendered_frame() -> None:
    state = state_of((16.0, 0.2, 0.1), (24.0, 1.5, 0.0), (30.0, -2.0, 1.5))
    scene_meshes = meshes_of(state)
    truth = annotate_frame(state, scene_meshes, 0).truth
    drawn = RASTER.render(View(RIG.camera, scene_meshes.instances(state))).instances
    assert truth.pixels.tolist() == [(drawn == number).sum() for number in range(3)]
    assert 0.0 < truth.visible[1] < 1.0


def test_a_car_behind_us_is_not_in_the_truth() -> None:
    assert len(truth_of(state_of((-20.0, 0.0, 0.0)))) == 0


def test_an_empty_world_has_an_empty_truth() -> None:
    truth = truth_of(state_of(), state_of(time=0.1))
    assert len(truth) == 0
    assert truth.keypoints.shape == (0, 36, 2)


def test_a_hidden_car_is_in_the_truth_with_its_occluder() -> None:
    state = state_of((40.0, 0.0, 0.0), (15.0, 0.0, np.pi / 2), size=(4.4, 1.8, 1.8))
    annotated = annotate([state], meshes_of(state))
    truth, occlusions = annotated.truth, annotated.occlusions
    assert truth.visible.tolist() == [0.0, 1.0]
    assert np.isnan(truth.visible_boxes[0]).all()
    assert truth.tracks.occlusion is not None
    assert truth.tracks.occlusion.tolist() == [3, 0]
    assert (occlusions.ids.tolist(), occlusions.occluder_ids.tolist()) == ([0], [1])
    assert occlusions.pixels[0] == truth.amodal_pixels[0]


def test_scenery_hides_cars_and_has_no_row() -> None:
    state = state_of((30.0, 0.0, 0.0))
    wall = MeshInstances(
        (box(1.0, 3.0, 1.8),), at(RIG.camera, -0.9, 12.0)[None], np.array([NO_INSTANCE])
    )
    annotated = annotate_frame(state, meshes_of(state), 0, scenery=wall)
    assert annotated.truth.tracks.ids.tolist() == [0]
    assert 0.05 < annotated.truth.visible[0] < 0.95
    assert annotated.occlusions.occluder_ids.tolist() == [NO_INSTANCE]


@pytest.mark.parametrize(
    ("visible", "level"),
    [(1.0, 0), (0.99, 0), (0.98, 1), (0.6, 1), (0.59, 2), (0.02, 2), (0.01, 3)],
)
def test_visible_fractions_have_kittis_levels(visible, level) -> None:
    assert occlusion_level(np.array([visible])).tolist() == [level]


def test_a_car_that_leaves_the_image_is_truncated_and_its_box_ends_at_the_border() -> None:
    truth = truth_of(state_of((10.0, 7.2, 0.0), (30.0, 0.0, 0.0)))
    assert truth.tracks.boxes[0, 2] == 1241.0
    assert truth.amodal_boxes[0, 2] > 1241.0
    assert 0.05 < truth.truncation[0] < 0.95
    assert truth.tracks.truncation is not None
    assert truth.tracks.truncation.tolist() == [1, 0]


def test_a_car_that_reaches_behind_the_camera_keeps_the_part_before_it() -> None:
    truth = truth_of(state_of((1.8, 2.6, 0.0)))
    assert len(truth) == 1
    assert truth.tracks.boxes[0, 2:].tolist() == [1241.0, 374.0]
    assert truth.truncation[0] > 0.5


@pytest.mark.parametrize("name", SCENES)
def test_boxes_of_fully_visible_cars_are_those_of_their_pixels_in_every_scene(name) -> None:
    rollout = Rollout.of(find_scene(name, frames=57), 1)
    states = [rollout.traffic_states[frame] for frame in range(0, 57, 7)]
    truth = annotate(states, rollout.scene_meshes, rollout.scenery_in).truth
    free = truth.visible == 1.0
    assert (free & (truth.truncation > 0.3)).any()
    off = np.abs(truth.tracks.boxes - truth.visible_boxes)[free]
    assert off.max() <= 2.0


def test_the_box_of_a_car_beside_the_camera_is_that_of_its_pixels() -> None:
    rollout = Rollout.of(find_scene("street", frames=11, bends=False, wander=0.0, bumps=0.0), 1)
    state = rollout.traffic_states[10]
    truth = annotate_frame(state, rollout.scene_meshes, 0, scenery=rollout.scenery_in(state)).truth
    (row,) = np.flatnonzero(truth.tracks.ids == 2)
    assert truth.visible[row] == 1.0
    assert truth.visible_boxes[row].tolist() == [1113.0, 288.0, 1241.0, 374.0]
    np.testing.assert_allclose(truth.tracks.boxes[row], truth.visible_boxes[row], atol=1.0)
    assert truth.tracks.boxes[row, 2:].tolist() == [1241.0, 374.0]
    seen = Sightings.from_truth(truth)
    np.testing.assert_array_equal(seen.boxes[row], truth.tracks.boxes[row])


def test_speeds_turns_and_accelerations_are_those_of_the_worlds() -> None:
    first = state_of((20.0, 0.0, 0.5), speed=3.0)
    second = state_of((20.2, 0.1, 0.53), (30.0, 3.0, 0.0), time=0.1, speed=3.2)
    truth = truth_of(first, second)
    np.testing.assert_allclose(truth.acceleration, [0.0, 2.0, 0.0])
    np.testing.assert_allclose(truth.yaw_rate, [0.0, 0.3, 0.0])
    np.testing.assert_allclose(truth.velocity[0], [3.0 * np.cos(0.5), 3.0 * np.sin(0.5)])
    assert truth.is_moving.all()


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.floats(4, 60), st.floats(-15, 15), st.floats(-3, 3)), max_size=4))
def test_whatever_stands_around_the_numbers_make_sense(cars) -> None:
    annotated = annotate([state_of(*cars)], meshes_of(state_of(*cars)))
    truth, occlusions = annotated.truth, annotated.occlusions
    assert ((truth.visible >= 0.0) & (truth.visible <= 1.0)).all()
    assert ((truth.truncation >= 0.0) & (truth.truncation < 1.0)).all()
    low, high = truth.tracks.boxes[:, :2], truth.tracks.boxes[:, 2:]
    assert (high > low).all()
    shown = truth.pixels > 0
    assert (truth.visible_boxes[shown, :2] >= low[shown] - 1.0).all()
    assert (truth.visible_boxes[shown, 2:] <= high[shown] + 1.0).all()
    for row, number in enumerate(truth.tracks.ids.tolist()):
        taken = occlusions.pixels[occlusions.ids == number].sum()
        assert taken == truth.amodal_pixels[row] - truth.pixels[row]


@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(st.floats(5, 60), st.floats(-20, 20), st.floats(-3, 3)), max_size=4))
def test_one_more_car_behind_all_others_hides_nobody(cars) -> None:
    without = truth_of(state_of(*cars))
    with_one = truth_of(state_of(*cars, (120.0, 0.0, 0.0)))
    others = with_one.tracks.ids < len(cars)
    np.testing.assert_array_equal(with_one.pixels[others], without.pixels)


def test_the_truth_of_a_tiny_camera_is_as_exact() -> None:
    K = np.array([[90.0, 0.0, 60.0], [0.0, 95.0, 20.0], [0.0, 0.0, 1.0]])
    rig = Rig(Camera.mounted(K, (123, 47), 1.4))
    state = state_of((9.0, 0.0, 0.3))
    expected = mesh_box(state, 0, rig)
    np.testing.assert_allclose(truth_of(state, rig=rig).amodal_boxes[0], expected, atol=0.05)


def states_by_rays(state, row: int, depth_margin: float = 0.03) -> np.ndarray:
    """Whether rays to the keypoints of a car end there (0), or before, on itself (1)."""
    scene_meshes = meshes_of(state)
    instances = scene_meshes.instances(state)
    T, mesh = instances.T_cam_object[row], instances.meshes[row]
    triangles = mesh.vertices[mesh.faces] @ T[:3, :3].T + T[:3, 3]
    points = scene_meshes.vehicles.keypoints[row] @ T[:3, :3].T + T[:3, 3]
    states = []
    for point in points:
        length = np.linalg.norm(point)
        depth, _ = hits(triangles, np.zeros(3), point / length)
        states.append(int(len(depth) > 0 and depth[0] < length - depth_margin))
    return np.array(states)


def test_what_a_car_hides_of_itself_is_what_rays_do_not_reach() -> None:
    agree = total = 0
    for heading in np.linspace(-3.0, 3.0, 9):
        for x in (9.0, 22.0):
            state = state_of((x, 1.0, heading))
            truth = truth_of(state)
            agree += (truth.keypoint_states[0] == states_by_rays(state, 0)).sum()
            total += 36
    assert agree / total >= 0.95


def test_keypoints_project_to_their_places_on_the_mesh() -> None:
    state = state_of((12.0, -2.0, 0.7))
    truth, scene_meshes = truth_of(state), meshes_of(state)
    T = scene_meshes.instances(state).T_cam_object[0]
    expected = RIG.camera.project(scene_meshes.vehicles.keypoints[0] @ T[:3, :3].T + T[:3, 3])
    np.testing.assert_allclose(truth.keypoints[0], expected)
    low, high = truth.amodal_boxes[0, :2], truth.amodal_boxes[0, 2:]
    assert ((truth.keypoints[0] >= low - 0.5) & (truth.keypoints[0] <= high + 0.5)).all()


def test_of_a_car_that_drives_ahead_the_tail_is_seen_and_the_front_is_not() -> None:
    found = truth_of(state_of((12.0, 0.0, 0.0))).keypoint_states[0].tolist()
    states = dict(zip(KEYPOINTS_36, found, strict=True))
    tail = [name for name in states if "taillight" in name]
    front = [name for name in states if "headlight" in name]
    assert len(tail) == len(front) == 2
    assert {states[name] for name in tail} == {KeypointVisibility.VISIBLE}
    assert {states[name] for name in front} == {KeypointVisibility.SELF_OCCLUDED}


def test_a_wall_of_a_car_occludes_and_the_border_truncates() -> None:
    state = state_of(
        (40.0, 0.0, 0.0), (15.0, 0.0, np.pi / 2), (6.0, 4.4, 0.0), size=(4.4, 1.8, 1.8)
    )
    truth = truth_of(state)
    hidden = truth.keypoint_states[0]
    assert set(hidden.tolist()) == {KeypointVisibility.SELF_OCCLUDED, KeypointVisibility.OCCLUDED}
    outside = (truth.keypoints[2, :, 0] > 1241.5) | (truth.keypoints[2, :, 1] > 374.5)
    assert outside.any()
    assert (truth.keypoint_states[2, outside] == KeypointVisibility.TRUNCATED).all()
    assert (truth.keypoint_states[2, ~outside] != KeypointVisibility.TRUNCATED).all()


def test_points_behind_the_camera_are_truncated_and_have_no_pixel() -> None:
    truth = truth_of(state_of((1.8, 2.6, 0.0)))
    behind = np.isnan(truth.keypoints[0]).any(axis=1)
    assert behind.any()
    assert (truth.keypoint_states[0, behind] == KeypointVisibility.TRUNCATED).all()


def test_nobody_has_no_keypoints() -> None:
    state = state_of()
    assert annotate_frame(state, meshes_of(state), 0).truth.keypoint_states.shape == (0, 36)
