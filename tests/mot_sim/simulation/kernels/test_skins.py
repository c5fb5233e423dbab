"""Cars lit pixel by pixel equal plain NumPy; patterns, lamps and shadows on them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.simulation.cars.finish import skin_of, smooth_neighbours, vertex_openness
from mot_sim.simulation.cars.fleet import load_fleet
from mot_sim.simulation.cars.topology import PARTS, topology
from mot_sim.simulation.renderers import Cover, Mesh, Pattern, Semantic, Skin, Sun, View
from mot_sim.simulation.renderers.filling import fill
from mot_sim.simulation.renderers.raster import (
    RasterRenderer,
    SmoothRenderer,
    diffuse_light,
)
from mot_sim.simulation.renderers.skins import (
    GLINT_LEVELS,
    GLOSS,
    glyphs,
    mirrored_light,
    plate_of,
)
from mot_sim.simulation.renderers.triangles import Triangles
from mot_sim.simulation.scene_meshes import DISTANCES, finished, mesh_of
from tests.mot_sim.simulation.renderers.shapes import KITTI, at, lump, view_of
from tracker.errors import BadConfig
from tracker.types import Camera

SMALL = Camera.mounted(
    np.array([[60.0, 0.4, 39.3], [0.0, 66.0, 27.6], [0.0, 0.0, 1.0]]), (81, 57), 1.3, 0.05, 0.04
)
RASTER = RasterRenderer()
seeds = st.integers(0, 2**32 - 1)


@cache
def car(paint: str = "black") -> Mesh:
    """A car as scenes have them."""
    shape = load_fleet().car(np.zeros(5))
    return finished(mesh_of(shape, paint), shape)


def skinned(seed: int, kind: Semantic) -> Mesh:
    """A body whose corners have any normals, and see any share of the sky."""
    rng, mesh = np.random.default_rng(seed), lump()
    normals = mesh.normals[:, None] + 0.3 * rng.standard_normal((len(mesh.faces), 3, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    openness, plain = rng.random((len(mesh.faces), 3)), np.zeros(len(mesh.faces), np.int64)
    skin = Skin(normals, openness, plain, np.ones(8))
    kinds = np.full(len(mesh.faces), kind, np.uint8)
    return replace(mesh, semantics=kinds, make_skin=lambda: skin)


def plain_lit(view: View, mesh: Mesh, triangles: Triangles, numbers: np.ndarray) -> np.ndarray:
    """Colours at the pixels with a triangle, from where their rays meet the whole faces."""
    v, u = np.nonzero(numbers)
    faces = triangles.faces[numbers[v, u] - 1]
    T, R_cam_road, sun = view.instances.T_cam_object[0], view.camera.T_cam_road[:3, :3], view.sun
    corners = mesh.corners[faces] @ T[:3, :3].T + T[:3, 3]
    rays = view.camera.rays(np.stack((u, v), axis=1).astype(float))
    shares = np.linalg.solve(corners.swapaxes(1, 2), rays[..., None])[..., 0]
    depth = 1.0 / shares.sum(axis=1)
    shares *= depth[:, None]
    normals = np.einsum("nc,nci->ni", shares, mesh.skin.normals[faces]) @ T[:3, :3].T
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    opened = (shares * mesh.skin.openness[faces]).sum(axis=1).clip(0.0, 1.0)
    to_up, to_sun = -R_cam_road[:, 1], R_cam_road @ sun.direction
    away = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    lit = np.ones(len(u))
    if view.cover is not None:
        points = rays * depth[:, None] @ view.camera.T_road_cam[:3, :3].T
        points += view.camera.T_road_cam[:3, 3]
        fallen = points - points[:, 1:2] / sun.direction[1] * sun.direction
        at_u = fallen[:, [0, 2]] @ view.cover.A_cover_road[0, :2]
        lit = np.where(at_u + view.cover.A_cover_road[0, 2] < 7.0, 1.0, 0.0)  # dark from column 7
        lit[np.abs(at_u + view.cover.A_cover_road[0, 2] - 7.0) < 1.0] = np.nan
    constant, zenith, direct = diffuse_light(sun)
    straight, flat, narrow = GLOSS[mesh.semantics[faces]].T
    strength = (constant + zenith * (normals @ to_up)) * opened
    strength += direct * lit * np.maximum(normals @ to_sun, 0.0)
    facing = (-(normals * away).sum(axis=1)).clip(0.0, 1.0)
    mirrored = away + 2.0 * facing[:, None] * normals
    c, s = np.cos(view.sky.heading), np.sin(view.sky.heading)
    wave = mirrored @ (R_cam_road @ (-s, 0.0, c))
    wave = 4.0 * wave**3 - 3.0 * wave
    level = mirrored @ to_up - 0.05 * wave * (1.0 + wave)
    seen = mirrored_light(view.sky)[(127.5 * (level + 1.0)).clip(0.0, 255.0).astype(int)]
    shine = np.maximum(mirrored @ to_sun, 1e-3)
    glossy = (narrow > 0.0).astype(float)
    share = glossy * (straight + flat * (1.0 - facing) ** 5) * opened
    strength += glossy * 0.22 * direct * lit * shine**8
    own = mesh.colours[faces] * strength[:, None]
    glint = glossy * GLINT_LEVELS * sun.shade * lit * shine**narrow
    return np.minimum(np.sqrt(own**2 + share[:, None] * seen) + glint[:, None], 255.0)


@pytest.mark.parametrize("kind", [Semantic.CAR, Semantic.GLASS, Semantic.TRIM])
@settings(max_examples=6)
@given(seed=seeds, covered=st.booleans())
def test_pixels_are_lit_between_the_corners_of_their_faces(
    kind: Semantic, seed: int, covered: bool
) -> None:
    rng, mesh = np.random.default_rng(seed), skinned(seed, kind)
    x, z, yaw = rng.uniform((-2.0, 2.0, -9.0), (2.0, 9.0, 9.0))
    dark = np.zeros((16, 16), np.uint8)
    dark[:, 7:] = 255
    A = np.array([[2.0, 0.0, 7.0 - 2.0 * x], [0.0, 0.5, 3.0], [0.0, 0.0, 1.0]])
    view = view_of(SMALL, (mesh, at(SMALL, x, z, yaw)), sun=Sun(ambient=rng.uniform(0.1, 0.9)),
                   cover=Cover(dark, A) if covered else None)  # fmt: skip
    triangles = Triangles.of(view.instances, SMALL, 0.3)
    numbers = fill(triangles, SMALL).numbers
    found = RASTER.render(view).image[numbers > 0].astype(float)
    expected = plain_lit(view, mesh, triangles, numbers)
    off = np.abs(found - expected).max(axis=1, initial=0.0)
    assert (off[np.isfinite(off)] > 1.5).mean() < 0.01  # a step of the mirrored sky, here and there


def test_light_changes_neither_depth_nor_ids() -> None:
    places = [at(KITTI, x, z, yaw) for x, z, yaw in ((-3.0, 7.0, 0.3), (2.0, 12.0, 2.0))]
    lit, flat = (
        RASTER.render(view_of(KITTI, *((mesh, place) for place in places)))
        for mesh in (car(), replace(car(), make_skin=None))
    )
    for name in ("depth", "instances", "semantics"):
        np.testing.assert_array_equal(getattr(lit, name), getattr(flat, name))
    assert (lit.image != flat.image).any(axis=2).mean() > 0.05


def test_smooth_edges_mix_lit_colours() -> None:
    view = view_of(KITTI, (car("white"), at(KITTI, 0.0, 8.0, 1.0)))
    one, other = RASTER.render(view), SmoothRenderer().render(view)
    off = np.abs(one.image.astype(int) - other.image).max(axis=2)
    assert 0.0 < (off > 0).mean() < 0.01
    inside = one.instances == 0
    assert inside[off > 0].mean() < 0.9


def test_corners_are_smooth_over_a_body_and_sharp_at_its_edges() -> None:
    mesh = car()
    skin = mesh.skin
    assert np.linalg.norm(skin.normals, axis=2) == pytest.approx(1.0)
    turned = np.einsum("fci,fi->fc", skin.normals, mesh.normals)
    assert turned.min() > 0.3
    assert (turned < 0.999).mean() > 0.5
    one, rim = smooth_neighbours(0.0), topology().parts == PARTS.index("rim")
    np.testing.assert_array_equal(one.own[one.starts], np.arange(len(mesh.faces)).repeat(3))
    np.testing.assert_allclose(turned[rim], 1.0, atol=0.02)


def test_openness_falls_from_the_roof_to_the_sill_and_into_the_arches() -> None:
    share, vertices = vertex_openness() / 255.0, load_fleet().vertices(np.zeros(5))
    assert len(share) == len(vertices)
    roof = share[vertices[:, 1] < vertices[:, 1].min() + 0.05]
    side = (np.abs(vertices[:, 2]) > 0.8) & (vertices[:, 1] > -0.45) & (vertices[:, 1] < -0.15)
    assert roof.min() > 0.9
    assert share[side].mean() < roof.mean() - 0.15
    right = topology().on_right
    np.testing.assert_array_equal(share[right], share[topology().twins[right]])


def test_a_car_of_another_mesh_keeps_its_flat_faces() -> None:
    shape = replace(load_fleet().car(np.zeros(5)), coefficients=None)
    assert {skin_of(shape, distance) for distance in DISTANCES} == {None}


def test_plates_have_characters_and_wheels_have_dark_tyres() -> None:
    view = view_of(KITTI, (car("white"), at(KITTI, 0.0, 8.0, -np.pi / 2)))
    rendered = RASTER.render(view)
    plate = rendered.image[rendered.semantics == Semantic.PLATE].astype(int)
    assert (plate.max(axis=1) < 70).mean() > 0.08
    assert (plate.min(axis=1) > 90).mean() > 0.3
    assert ((plate[:, 2] - plate[:, 0]) > 30).mean() > 0.02  # the blue end
    wheels = car().skin.patterns == Pattern.WHEEL
    assert (car().semantics[wheels] == Semantic.TYRE).all()
    side = view_of(KITTI, (car("white"), at(KITTI, 0.0, 5.0, 0.0)))
    rendered = RASTER.render(side)
    tyre = rendered.image[rendered.semantics == Semantic.TYRE].max(axis=1)
    assert np.median(tyre) < 45
    assert (tyre > 60).mean() > 0.05


def test_a_cars_plate_is_its_own() -> None:
    assert plate_of(3) == plate_of(3) != plate_of(4)
    assert len(plate_of(3)) == 9
    assert max(plate_of(3)) < len(glyphs())
    assert set(plate_of(-1)) == {-1.0}


def test_a_car_in_a_shadow_is_darker_and_mirrors_no_sun() -> None:
    view = view_of(KITTI, (car("silver"), at(KITTI, 0.0, 8.0, 1.0)))
    dark = Cover(np.full((8, 8), 255, np.uint8), np.diag((0.1, 0.1, 1.0)))
    dark.A_cover_road[:2, 2] = 3.5
    open_one, covered = RASTER.render(view), RASTER.render(replace(view, cover=dark))
    inside = open_one.instances == 0
    assert (covered.image[inside] <= open_one.image[inside]).all()
    assert covered.image[inside].mean() < 0.85 * open_one.image[inside].mean()
    np.testing.assert_array_equal(covered.image[~inside], open_one.image[~inside])


def test_a_picture_of_shadows_without_pixels_is_refused() -> None:
    with pytest.raises(BadConfig, match="a picture of shadows of 1 x 1 pixels"):
        Cover(np.zeros((1, 1), np.uint8), np.eye(3))
