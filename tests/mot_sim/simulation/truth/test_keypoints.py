"""Which keypoints are seen, against rays from the camera."""

import numpy as np

from mot_sim.simulation.truth import KeypointVisibility, annotate_frame
from tests.mot_sim.simulation.cars.rays import hits
from tests.mot_sim.simulation.truth.states import RIG, meshes_of, state_of, truth_of
from tracker.shape import KEYPOINTS_36


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
