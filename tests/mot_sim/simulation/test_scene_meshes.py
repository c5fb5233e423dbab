"""Cars stand where the world says."""

import numpy as np

from mot_sim.simulation.renderers import NO_INSTANCE, MeshInstances, Semantic
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene_meshes import Ts_cam_object
from tests.mot_sim.simulation.renderers.shapes import at, box
from tests.mot_sim.simulation.truth.states import meshes_of, state_of
from tracker.geometry import transform


def test_the_corners_of_a_car_are_those_of_its_cuboid() -> None:
    state, rig = state_of((14.0, -3.0, 0.8), (25.0, 4.0, -2.0)), Rig.kitti(pitch=0.03, roll=0.02)
    cuboids = rig.cuboids(state)
    for row, T in enumerate(Ts_cam_object(cuboids, rig)):
        length, height, width = cuboids.size[row]
        low, high = np.array([-length, -2 * height, -width]) / 2, np.array([length, 0, width]) / 2
        corners = np.array(
            [
                (x, y, z)
                for x in (low[0], high[0])
                for y in (low[1], high[1])
                for z in (low[2], high[2])
            ]
        )
        expected = transform(rig.camera.T_cam_road, cuboids.corners()[row])
        gaps = np.linalg.norm(transform(T, corners)[:, None] - expected[None], axis=2)
        assert gaps.min(axis=1).max() < 1e-9
        assert gaps.min(axis=0).max() < 1e-9


def test_a_car_drives_with_its_front_ahead() -> None:
    state, rig = state_of((20.0, 0.0, 0.0)), Rig.kitti()
    T = Ts_cam_object(rig.cuboids(state), rig)[0]
    np.testing.assert_allclose(T[:3, :3] @ (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), atol=1e-12)
    np.testing.assert_allclose(T[:3, :3] @ (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(T[:3, 3], (0.0, 1.65, 20.0), atol=1e-12)


def test_meshes_are_painted_and_say_what_they_are_made_of() -> None:
    scene_meshes = meshes_of(state_of((20.0, 0.0, 0.0)))
    mesh = scene_meshes.mesh(0)
    assert {Semantic.CAR, Semantic.GLASS, Semantic.TYRE, Semantic.LIGHT, Semantic.PLATE} <= {
        Semantic(value) for value in np.unique(mesh.semantics)
    }
    silver = (mesh.colours == (176, 179, 182)).all(axis=1)
    assert np.array_equal(silver, mesh.semantics == Semantic.CAR)


def test_scenery_stands_behind_the_cars_in_the_list() -> None:
    state, rig = state_of((20.0, 0.0, 0.0)), Rig.kitti()
    tree = MeshInstances((box(),), at(rig.camera, 3.0, 9.0)[None], np.array([NO_INSTANCE]))
    instances = meshes_of(state).instances(state, tree)
    assert instances.ids.tolist() == [0, NO_INSTANCE]
    assert instances.meshes[1] is tree.meshes[0]
