"""Filled triangles against exact geometry."""

import numpy as np
import pytest

from mot_sim.simulation.renderers.filling import fill
from mot_sim.simulation.renderers.triangles import Triangles
from tests.mot_sim.simulation.renderers.shapes import CROOKED, KITTI, at, box, lump, view_of, wedge
from tracker.types import Camera

NEAR = 0.3
PLACES = ((0.0, 6.0), (0.5, 7.0), (-2.0, 9.0), (1.5, 4.0), (-1.5, 1.0))


def soup(corners: np.ndarray) -> Triangles:
    numbers = np.arange(len(corners))
    return Triangles(corners, np.zeros(len(corners), np.int64), numbers)


def whole_frame(triangles: Triangles, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Row of the nearest triangle (-1: none) and its depth (inf: none) at every pixel."""
    fragments = fill(triangles, camera)
    depth = np.divide(1.0, fragments.nearness, where=fragments.numbers > 0,
                      out=np.full(fragments.numbers.shape, np.inf))  # fmt: skip
    return fragments.numbers - 1, depth


def brute_force(triangles: Triangles, camera: Camera) -> tuple[np.ndarray, ...]:
    """The same by a ray a pixel through every triangle; and how close any edge is to a pixel."""
    width, height = camera.image_size
    v, u = np.mgrid[:height, :width]
    rays = camera.rays(np.stack((u, v), axis=-1).reshape(-1, 2).astype(float))
    rows, depth = np.full(len(rays), -1), np.full(len(rays), np.inf)
    closest = np.full(len(rays), np.inf)
    for row, corners in enumerate(triangles.corners):
        weights = np.linalg.solve(corners.T, rays.T).T  # ray = sum of weights x corners
        inside = (weights >= 0.0).all(axis=1)
        z = 1.0 / np.where(inside, weights.sum(axis=1), 1.0)
        nearer = inside & (z < depth)
        rows[nearer], depth[nearer] = row, z[nearer]
        closest = np.minimum(closest, np.abs(weights).min(axis=1) / np.abs(weights).max(axis=1))
    return rows.reshape(height, width), depth.reshape(height, width), closest.reshape(height, width)


def crowd(camera: Camera) -> Triangles:
    """Objects that stand in each other, before each other, and partly behind the camera."""
    places = [at(camera, x, z, x + z) for x, z in PLACES]
    objects = zip((box(), wedge(), box(), wedge(), box()), places, strict=True)
    return Triangles.of(view_of(camera, *objects).instances, camera, NEAR)


def test_every_pixel_shows_the_nearest_triangle_as_a_ray_finds_it() -> None:
    triangles = crowd(CROOKED)
    rows, depth = whole_frame(triangles, CROOKED)
    true_rows, true_depth, closest = brute_force(triangles, CROOKED)
    clear = closest > 1e-4  # no edge through the pixel's centre
    assert clear.mean() > 0.9
    assert (rows == true_rows)[clear].mean() > 0.9999
    assert (
        np.array_equal(rows >= 0, true_rows >= 0) or ((rows >= 0) == (true_rows >= 0))[clear].all()
    )
    both = (rows == true_rows) & (rows >= 0)
    assert np.abs(depth[both] / true_depth[both] - 1.0).max() < 2e-5


def test_the_order_of_the_triangles_changes_nothing() -> None:
    triangles = crowd(CROOKED)
    turned = soup(triangles.corners[::-1])
    rows, depth = whole_frame(soup(triangles.corners), CROOKED)
    turned_rows, turned_depth = whole_frame(turned, CROOKED)
    assert np.array_equal(depth, turned_depth)
    same = np.where(turned_rows < 0, -1, len(triangles) - 1 - turned_rows) == rows
    assert same.mean() > 0.999  # at shared edges the first one is taken


@pytest.mark.parametrize("camera", [KITTI, CROOKED], ids=["kitti", "crooked"])
@pytest.mark.parametrize("slope", [0.0, 0.7, 3.0])
def test_depth_is_that_of_a_slanted_plane(camera: Camera, slope: float) -> None:
    x, y = np.array([-60.0, 60.0, 0.0]), np.array([-40.0, -40.0, 60.0])
    plane = np.stack((x, y, 30.0 + 0.2 * slope * x + 0.15 * slope * y), axis=1)
    plane[:, 2] = np.maximum(plane[:, 2], 0.5)
    rows, depth = whole_frame(soup(plane[None]), camera)
    normal = np.cross(plane[1] - plane[0], plane[2] - plane[0])
    v, u = np.nonzero(rows == 0)
    assert len(v) > 1000
    rays = camera.rays(np.stack((u, v), axis=1).astype(float))
    exact = normal @ plane[0] / (rays @ normal)
    assert np.abs(depth[v, u] / exact - 1.0).max() < 1e-4


@pytest.mark.parametrize("camera", [KITTI, CROOKED], ids=["kitti", "crooked"])
@pytest.mark.parametrize("mesh", [box(), wedge(), lump()], ids=["box", "wedge", "lump"])
def test_the_silhouette_ends_within_a_pixel_of_the_projected_vertices(camera, mesh) -> None:
    for x, z, yaw in ((0.0, 9.0, 0.3), (-1.0, 14.0, 2.0), (2.0, 40.0, -1.0)):
        place = at(camera, x, z, yaw)
        triangles = Triangles.of(view_of(camera, (mesh, place)).instances, camera, NEAR)
        rows, _ = whole_frame(triangles, camera)
        v, u = np.nonzero(rows >= 0)
        pixels = camera.project(mesh.vertices @ place[:3, :3].T + place[:3, 3])
        drawn = np.array([u.min() - 0.5, v.min() - 0.5, u.max() + 0.5, v.max() + 0.5])
        exact = np.concatenate((pixels.min(axis=0), pixels.max(axis=0)))
        assert np.abs(drawn - exact).max() <= 1.0


def test_no_triangle_covers_no_pixel() -> None:
    rows, depth = whole_frame(soup(np.zeros((0, 3, 3))), KITTI)
    assert (rows == -1).all()
    assert np.isinf(depth).all()
