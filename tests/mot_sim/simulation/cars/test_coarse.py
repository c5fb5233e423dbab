"""Coarser meshes look like the whole one from where they stand in for it."""

import numpy as np
import pytest
import trimesh

from mot_sim.simulation.cars import load_fleet, topology
from mot_sim.simulation.cars.coarse import LEVEL_DISTANCES, coarse_levels, simplify
from mot_sim.simulation.renderers import Mesh, MeshInstances, View, scan_view
from mot_sim.simulation.scene_meshes import DISTANCES, coarser, mesh_of
from tests.mot_sim.simulation.renderers.shapes import KITTI, at

FLEET = load_fleet(20)
CARS = FLEET.sample(5, np.arange(10))


def scanned(mesh: Mesh, place: np.ndarray):
    return scan_view(View(KITTI, MeshInstances((mesh,), place[None], np.array([0])), road=None))


@pytest.mark.parametrize("level", range(1, len(LEVEL_DISTANCES) + 1))
def test_from_its_distance_on_a_coarser_car_has_the_same_box_within_a_pixel(level) -> None:
    distance, rng = list(coarse_levels())[level - 1], np.random.default_rng(level)
    for row in CARS.coefficients:
        mesh = mesh_of(FLEET.car(row), "red")
        place = at(KITTI, rng.uniform(-0.5, 0.5) * distance, distance, rng.uniform(-3, 3))
        whole, coarse = scanned(mesh, place), scanned(coarser(mesh, distance), place)
        difference = whole.silhouettes.amodal_boxes - coarse.silhouettes.amodal_boxes
        assert np.abs(difference).max() <= 1.0
        a, b = whole.numbers > 0, coarse.numbers > 0
        assert (a & b).sum() / (a | b).sum() > (0.97 if level == 1 else 0.9)


def test_levels_have_the_faces_they_are_named_for_and_the_size_of_the_car() -> None:
    car = FLEET.car(CARS.coefficients[0])
    for distance, count in zip(DISTANCES[1:], LEVEL_DISTANCES, strict=True):
        mesh = coarser(mesh_of(car, "red"), distance)
        assert len(mesh.faces) <= count
        used = car.vertices[np.unique(mesh.faces)]
        np.testing.assert_allclose(np.ptp(used, axis=0), car.size, atol=0.02)


def test_coarser_pieces_are_as_closed_as_the_whole_ones() -> None:
    car, pieces = FLEET.car(CARS.coefficients[1]), topology().pieces
    for level in coarse_levels().values():
        for piece in np.unique(pieces):
            faces = level.faces[pieces[level.origins] == piece]
            whole = car.piece(int(piece)).is_watertight
            assert trimesh.Trimesh(car.vertices, faces).is_watertight == whole


def test_a_flat_grid_loses_its_inner_points_and_keeps_the_locked_ones() -> None:
    n = 5
    u, v = (axis.ravel() for axis in np.meshgrid(np.arange(n), np.arange(n)))
    points = np.stack((u, v, 0 * u), axis=1).astype(float)
    corner = np.arange(n * n).reshape(n, n)[:-1, :-1].ravel()
    faces = np.concatenate(
        (
            np.stack((corner, corner + 1, corner + n), 1),
            np.stack((corner + 1, corner + n + 1, corner + n), 1),
        )
    )
    border = (u == 0) | (v == 0) | (u == n - 1) | (v == n - 1)
    locked = border.copy()
    locked[12] = True
    coarse = simplify(points[None], faces, np.zeros(len(faces), int), locked, 1)
    assert set(np.unique(coarse.faces)) >= set(np.flatnonzero(locked))
    assert len(coarse.faces) < len(faces) - 8
    a, b, c = points[coarse.faces].swapaxes(0, 1)
    assert np.cross(b - a, c - a)[:, 2].sum() == pytest.approx(2.0 * (n - 1) ** 2)
