"""What a view is made of, and what it cannot be made of."""

import numpy as np
import pytest

from mot_sim.simulation.renderers import Mesh, MeshInstances, Road, Semantic, Sun, Texture
from tests.mot_sim.simulation.renderers.shapes import box, lump, wedge
from tracker.errors import BadConfig

BLANK = Texture(np.zeros((4, 4, 3), np.uint8))


def test_the_normals_of_a_box_are_its_axes_and_point_away() -> None:
    mesh = box(4.0, 2.0, 1.0)
    middle = mesh.corners.mean(axis=1) - (0.0, -1.0, 0.0)
    assert np.abs(mesh.normals).max(axis=1) == pytest.approx(1.0)
    assert ((mesh.normals * middle).sum(axis=1) > 0.4).all()


@pytest.mark.parametrize("mesh", [box(), wedge(), lump()], ids=["box", "wedge", "lump"])
def test_the_sphere_holds_all_vertices(mesh: Mesh) -> None:
    centre, radius = mesh.sphere
    assert (np.linalg.norm(mesh.vertices - centre, axis=1) <= radius + 1e-12).all()


def test_few_vertices_have_the_extent_of_all() -> None:
    mesh = lump()
    assert len(mesh.extremes) < 0.4 * len(mesh.vertices)
    assert np.ptp(mesh.extremes, axis=0) == pytest.approx(np.ptp(mesh.vertices, axis=0), rel=0.01)


def test_a_mesh_without_faces_has_no_normals() -> None:
    nothing = np.zeros((0, 3))
    mesh = Mesh(nothing, nothing.astype(int), nothing.astype(np.uint8), np.zeros(0, np.uint8))
    assert mesh.normals.shape == (0, 3)
    assert mesh.sphere[1] == 0.0


def test_a_face_without_area_has_a_zero_normal() -> None:
    corner, paint = np.zeros((3, 3)), np.zeros((1, 3), np.uint8)
    mesh = Mesh(corner, np.array([[0, 1, 2]]), paint, np.full(1, Semantic.CAR, np.uint8))
    assert (mesh.normals == 0.0).all()


def test_faces_that_name_missing_vertices_are_refused() -> None:
    mesh = box()
    with pytest.raises(BadConfig, match="vertices 0 to 8; there are 8"):
        Mesh(mesh.vertices, np.where(mesh.faces == 7, 8, mesh.faces), mesh.colours, mesh.semantics)


def test_vertices_that_are_not_finite_are_refused() -> None:
    mesh = box()
    with pytest.raises(BadConfig, match="not finite"):
        Mesh(mesh.vertices * np.nan, mesh.faces, mesh.colours, mesh.semantics)


@pytest.mark.parametrize(
    ("meshes", "places", "ids", "told"),
    [
        (2, np.eye(4)[None], [0], "2 meshes, 1 places and 1 instance ids"),
        (1, np.eye(4)[None] * np.nan, [0], "not finite"),
        (1, np.eye(4)[None], [-2], "instance id -2"),
    ],
)
def test_objects_that_contradict_themselves_are_refused(meshes, places, ids, told) -> None:
    with pytest.raises(BadConfig, match=told):
        MeshInstances((box(),) * meshes, places, np.array(ids))


def test_roads_that_cannot_be_are_refused() -> None:
    with pytest.raises(BadConfig, match="texture of 0 x 4 pixels"):
        Texture(np.zeros((4, 0, 3), np.uint8))
    with pytest.raises(BadConfig, match="smaller edge first"):
        Road.spread(BLANK, (2.0, -2.0), (0.0, 10.0))
    with pytest.raises(BadConfig, match="singular"):
        Road(BLANK, np.zeros((3, 3)))


def test_suns_that_cannot_be_are_refused() -> None:
    with pytest.raises(BadConfig, match="below the road"):
        Sun(towards=(0.0, 1.0, 0.0))
    with pytest.raises(BadConfig, match=r"ambient is 1\.5"):
        Sun(ambient=1.5)


def test_a_spread_road_puts_the_middle_of_its_texture_in_its_middle() -> None:
    road = Road.spread(Texture(np.zeros((40, 20, 3), np.uint8)), (-5.0, 5.0), (10.0, 30.0))
    assert road.A_texture_road @ (0.0, 20.0, 1.0) == pytest.approx([9.5, 19.5, 1.0])
    assert road.A_texture_road @ (-5.0, 30.0, 1.0) == pytest.approx([-0.5, -0.5, 1.0])
