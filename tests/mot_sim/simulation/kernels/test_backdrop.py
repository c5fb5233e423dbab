"""Kernels of the backdrop equal plain NumPy."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.simulation.renderers import Road, Sun, Texture, View
from mot_sim.simulation.renderers.ground import cuts, horizon, road_rgba, sky_image
from mot_sim.simulation.renderers.raster import RasterRenderer
from mot_sim.simulation.renderers.shadows import casters, closed_mask, drawn, shadow_mask
from mot_sim.simulation.renderers.surroundings import Level
from mot_sim.simulation.scenery.window import _needed
from tests.mot_sim.simulation.kernels import plain_backdrop as plain
from tests.mot_sim.simulation.kernels.test_drawing import SMALL
from tests.mot_sim.simulation.renderers.shapes import at, box, view_of
from tracker.geometry import homogeneous, rotation_y
from tracker.types import Camera

FEW = settings(max_examples=20)
seeds = st.integers(0, 2**32 - 1)
UPWARDS = Camera.mounted(SMALL.K, SMALL.image_size, 1.3, pitch=1.2)
cameras = st.sampled_from([SMALL, UPWARDS])


def some_road(seed: int) -> Road:
    """A road of three levels, seen from anywhere; parts of it are no road."""
    rng, levels = np.random.default_rng(seed), []
    for texel, reach in ((0.05, 6.0), (0.2, 30.0), (0.8, np.inf)):
        rgba = rng.integers(0, 256, (64, 48, 4)).astype(np.uint8)
        turn, shift = rotation_y(rng.uniform(-0.5, 0.5))[::2, ::2], rng.uniform(0.0, 9.0, 2)
        A = np.eye(3)
        A[:2, :2], A[:2, 2] = turn / texel, shift / texel
        levels.append(Level(Texture.of_rgba(rgba), A, reach))
    last = levels[-1]
    return Road(last.texture, last.A_texture_road, (9, 8, 7), tuple(levels[:-1]))


def nowhere(view: View) -> np.ndarray:
    """No number at any pixel."""
    return np.zeros(view.camera.image_size[::-1], np.int32)


@FEW
@given(seeds, cameras, st.floats(0.0, 1.0))
def test_the_ground_is_laid_under_shadows(seed: int, camera: Camera, shade: float) -> None:
    road = some_road(seed)
    view = view_of(camera, (box(), at(camera, 0.0, 8.0)), road=road, sun=Sun(shade=shade))
    found, seen = RasterRenderer().backdrop(view), horizon(camera)
    rgba, expected = road_rgba(camera, road), sky_image(camera, view.sky)
    rows = casters(view, 0.3)
    dark, closed = shadow_mask(view, 0.3, rows), closed_mask(view, seen.first, rows, nowhere(view))
    if len(rgba):
        plane = np.ascontiguousarray(rgba[..., :3])
        ground = plain.plain_shaded(plane, dark[seen.first :], closed[seen.first :], shade)
        below = seen.below[seen.first :, :, None] > 0
        expected[seen.first :] = np.where(below, ground, expected[seen.first :])
        np.testing.assert_array_equal(found.semantics, plain.plain_kinds(rgba, camera))
    np.testing.assert_array_equal(found.image, expected)
    np.testing.assert_array_equal(found.depth, seen.depth)


@FEW
@given(seeds, st.integers(0, 4))
def test_the_sky_that_boxes_hide_from_the_road(seed: int, count: int) -> None:
    rng, places = np.random.default_rng(seed), []
    for _ in range(count):
        x, z, yaw = rng.uniform((-6.0, -2.0, -9.0), (6.0, 20.0, 9.0))
        places.append((box(*rng.uniform(0.2, 5.0, 3)), at(SMALL, x, z, yaw)))
    view, first = view_of(SMALL, *places), horizon(SMALL).first
    found = closed_mask(view, first, casters(view, 0.3), nowhere(view))
    expected = plain.plain_closed(view)
    # A centre on the border of a footprint may fall to either side.
    assert (np.abs(found[first:] - expected[first:]) > 1.0).sum() <= 2
    assert not found[:first].any()


@FEW
@given(seeds, cameras)
def test_each_row_shows_the_picture_that_is_fine_enough(seed: int, camera: Camera) -> None:
    road, rows = some_road(seed), []
    for top, bottom, finer, number in cuts(camera, road):
        rows += [(number, finer)] * (bottom - top)
    assert rows == plain.plain_cuts(camera, road)


@FEW
@given(seeds, st.integers(3, 7))
def test_tiles_in_sight(seed: int, corners: int) -> None:
    rng = np.random.default_rng(seed)
    turn = np.sort(rng.uniform(0.0, 2.0 * np.pi, corners))
    circle = np.stack((np.cos(turn), np.sin(turn)), axis=1) * rng.choice([0.1, 2.0, 9.0])
    outline = circle + rng.uniform(-1.0, 7.0, 2)
    found = _needed(outline, (0, 0), 1.0, homogeneous(flat_road(), np.zeros(3)))
    np.testing.assert_array_equal(found, plain.plain_touched(outline, len(found)))
    assert not _needed(outline[:0], (0, 0), 1.0, np.eye(4)).any()


def flat_road() -> np.ndarray:
    """A rotation that leads x and z of the road to x and y."""
    return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


@FEW
@given(seeds, st.integers(1, 5))
def test_outlines_are_projected(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    corners = rng.uniform((-20.0, -3.0), (20.0, 60.0), (3 * count, 2))
    ends = 3 * np.arange(1, count + 1)
    expected = plain.plain_drawn(SMALL, corners, ends, 0.3)
    whole = [polygon for polygon in expected if polygon is not None]
    found = drawn(SMALL, corners[np.repeat([p is not None for p in expected], 3)],
                  3 * np.arange(1, len(whole) + 1), 0.3) if whole else []  # fmt: skip
    for one, other in zip(found, whole, strict=True):
        np.testing.assert_array_equal(one, other)
    assert len(drawn(SMALL, corners, ends, 0.3)) <= count


def test_no_shadow_changes_nothing() -> None:
    view = view_of(SMALL, (box(), at(SMALL, 0.0, 8.0)), road=some_road(1))
    bare = RasterRenderer(shadows=False).backdrop(view)
    hovering = replace(view.instances.meshes[0], casts=False)
    alone = view_of(SMALL, (hovering, at(SMALL, 0.0, 8.0)), road=view.road, sun=Sun(shade=0.7))
    assert isinstance(view, View)
    np.testing.assert_array_equal(bare.image, RasterRenderer().backdrop(alone).image)


def test_without_a_sun_the_road_is_dark_only_beside_and_beneath_objects() -> None:
    view = view_of(SMALL, (box(), at(SMALL, 0.0, 8.0)), sun=Sun(shade=0.0))
    bare, unlit = (RasterRenderer(shadows=on).backdrop(view).image for on in (False, True))
    ground = SMALL.touch_road(np.argwhere((bare != unlit).any(axis=2))[:, ::-1].astype(float))
    assert 0.0 < np.hypot(ground[:, 0], ground[:, 2] - 8.0).max() < 2.2 + 2.0 * 1.5
    u, v = np.round(SMALL.project(SMALL.T_cam_road[:3] @ (0.0, 0.0, 8.0, 1.0))).astype(int)
    assert unlit[v, u].max() < 0.15 * bare[v, u].max()
