"""Kernels of truth and renderer equal plain NumPy: near planes, borders, slivers, nothing."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.simulation.renderers import (
    NO_INSTANCE,
    Mesh,
    MeshInstances,
    Semantic,
    Sun,
    View,
    scan_view,
)
from mot_sim.simulation.renderers.filling import SPARE_PIXELS, fill
from mot_sim.simulation.renderers.materials import Materials
from mot_sim.simulation.renderers.raster import RasterRenderer, SmoothRenderer, paint
from mot_sim.simulation.renderers.triangles import Triangles, boxes_inside, cut_near
from mot_sim.simulation.truth.annotate import seen_keypoints
from tests.mot_sim.simulation.kernels import plain_pixels as pixels
from tests.mot_sim.simulation.kernels import plain_triangles as plain
from tests.mot_sim.simulation.renderers.shapes import at, box, lump, painted, wedge
from tracker.kernels import load
from tracker.types import Camera

K = np.array([[30.0, 0.4, 19.3], [0.0, 33.0, 13.6], [0.0, 0.0, 1.0]])
SMALL = Camera.mounted(K, (41, 29), 1.3, 0.05, 0.04)
NEAR = 0.3
FEW = settings(max_examples=20)
seeds, counts = st.integers(0, 2**32 - 1), st.integers(0, 6)
SLIVER = painted([(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, -9.0, 0.0)],
                 [(0, 1, 2), (0, 1, 3)])  # fmt: skip
SHAPES = (box(), wedge(), SLIVER, box(60.0, 9.0, 0.2), lump())


def some_view(seed: int, count: int, kind: Semantic = Semantic.CAR) -> View:
    """Objects before, around and behind the camera; some of scenery, some with one id."""
    rng = np.random.default_rng(seed)
    meshes = tuple(of_kind(rng.integers(0, len(SHAPES)), kind) for _ in range(count))
    places = [
        at(SMALL, *rng.uniform((-6.0, -2.0, -9.0), (6.0, 30.0, 9.0)), y=rng.uniform(-0.5, 0.5))
        for _ in range(count)
    ]
    ids = rng.choice([NO_INSTANCE, 3, 7, 1_000_000_007], count)
    instances = MeshInstances(meshes, np.array(places).reshape(-1, 4, 4), ids)
    return View(SMALL, instances, sun=Sun(ambient=rng.uniform(0.1, 0.9)))


@cache
def of_kind(shape: int, kind: Semantic) -> Mesh:
    """A shape made of something else."""
    mesh = SHAPES[shape]
    return replace(mesh, semantics=np.full(len(mesh.faces), kind, np.uint8))


def triangles_of(view: View) -> Triangles:
    return Triangles.of(view.instances, SMALL, NEAR)


@FEW
@given(seeds, counts)
def test_faces_before_the_camera(seed: int, count: int) -> None:
    view = some_view(seed, count)
    found, expected = triangles_of(view), plain.plain_triangles(view.instances, SMALL, NEAR)
    np.testing.assert_array_equal(found.objects, expected.objects)
    np.testing.assert_array_equal(found.faces, expected.faces)
    np.testing.assert_allclose(found.corners, expected.corners, rtol=1e-9, atol=1e-12)


@FEW
@given(seeds, counts)
def test_triangles_are_cut_at_a_plane(seed: int, count: int) -> None:
    corners = np.random.default_rng(seed).choice([-1.0, 0.2, 0.3, 0.5, 1e9], (count, 3, 3))
    found, rows = cut_near(corners, NEAR)
    expected, expected_rows = plain.plain_cut(corners, NEAR)
    np.testing.assert_array_equal(rows, expected_rows)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@given(seeds, counts)
def test_boxes_inside_the_image(seed: int, count: int) -> None:
    rng, far = np.random.default_rng(seed), SMALL.far_corner[2:]
    corners = rng.choice([-1e12, -3.0, 0.0, 20.0, 28.0, 40.0, 44.0], (count, 3, 2))
    corners += rng.choice([0.0, 1e-12, 0.3], (count, 3, 2))
    found, expected = boxes_inside(corners, far), plain.plain_boxes_inside(corners, far)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9)


@FEW
@given(seeds, counts)
def test_nearest_triangles_and_their_depths(seed: int, count: int) -> None:
    triangles = triangles_of(some_view(seed, count))
    found = fill(triangles, SMALL)
    near, clear = pixels.plain_nearness(triangles, SMALL)
    nearest = near.max(axis=0, initial=0.0)
    sure = clear.all(axis=0)
    np.testing.assert_allclose(found.nearness[sure], nearest[sure], rtol=2e-7)
    assert np.array_equal(found.numbers > 0, found.nearness > 0.0)
    v, u = np.nonzero((found.numbers > 0) & sure)
    np.testing.assert_allclose(near[found.numbers[v, u] - 1, v, u], nearest[v, u], rtol=2e-7)


@FEW
@given(seeds, st.integers(3, 9))
def test_no_gap_is_between_triangles_around_a_point(seed: int, count: int) -> None:
    """Also where edges go through the pixels' centres, and corners lie on them."""
    rng, turn = np.random.default_rng(seed), np.linspace(0.0, 2.0 * np.pi, count + 1)[:-1]
    rim = np.round(np.stack((np.cos(turn), np.sin(turn)), axis=1) * 900.0)
    middle = rng.integers(5, 20, 2) + rng.choice([0.0, 0.5, 1.0 / 3.0])
    fan = np.full((count, 3, 3), 8.0)  # with a focal length of 8 pixels they are pixels
    fan[:, 0, :2], fan[:, 1, :2], fan[:, 2, :2] = middle, rim, np.roll(rim, -1, axis=0)
    flat = Camera.mounted(np.diag((8.0, 8.0, 1.0)), (30, 25), 1.0)
    rows = np.zeros(count, np.int64)
    assert (fill(Triangles(fan, rows, rows), flat).numbers > 0).all()


@FEW
@given(seeds, counts)
def test_scans_count_what_plain_masks_count(seed: int, count: int) -> None:
    view = some_view(seed, count)
    owners, scanned, triangles = view.instances.ids, scan_view(view), triangles_of(view)
    seen, ids = scanned.silhouettes, scanned.layers.instances
    np.testing.assert_array_equal(ids, [NO_INSTANCE, *sorted({*owners} - {NO_INSTANCE})])
    boxes, clipped, farthest = plain.plain_extents(triangles, SMALL, owners, ids[1:])
    np.testing.assert_allclose(seen.amodal_boxes, boxes, rtol=1e-12)
    np.testing.assert_allclose(seen.clipped_boxes, clipped, rtol=0.0, atol=1e-9)
    kept = plain.plain_hiders(triangles, SMALL, owners, clipped, farthest)
    crops = np.zeros((len(ids), 29, 41))
    for layer in scanned.layers:
        left, top, right, bottom = layer.box
        crops[np.searchsorted(ids, layer.instance), top:bottom, left:right] = layer.nearness
    for row, number in enumerate(ids):
        mine = fill(triangles.select(kept & (owners[triangles.objects] == number)), SMALL)
        beside = plain.plain_beside(seen.clipped_boxes, SMALL) & (number == NO_INSTANCE)
        np.testing.assert_array_equal(crops[row], np.where(beside, 0.0, mine.nearness))
    numbers, whole, visible, visible_boxes, hidden = pixels.plain_counts(crops)
    np.testing.assert_array_equal(scanned.numbers, numbers)
    np.testing.assert_array_equal(scanned.nearness, crops.max(axis=0))
    np.testing.assert_array_equal(seen.amodal, whole)
    np.testing.assert_array_equal(seen.visible, visible)
    np.testing.assert_array_equal(seen.visible_boxes, visible_boxes)
    found = np.stack((scanned.hidden.instances, scanned.hidden.occluder_ids), axis=1)
    np.testing.assert_array_equal(found, ids[hidden[:, :2]])
    np.testing.assert_array_equal(scanned.hidden.pixels, hidden[:, 2])


@FEW
@given(seeds, counts, st.integers(0, 5))
def test_keypoints_are_seen_or_hidden(seed: int, count: int, points: int) -> None:
    rng, view = np.random.default_rng(seed), some_view(seed, count)
    scanned = scan_view(view)
    ids = scanned.silhouettes.instances
    where = rng.uniform((-6.0, -2.0, -1.0), (6.0, 2.0, 30.0), (len(ids), points, 3))
    faces_us = rng.random((len(ids), points)) < 0.7
    where_seen, found = seen_keypoints(where, faces_us, ids, scanned, SMALL)
    np.testing.assert_array_equal(found, pixels.plain_states(where, faces_us, ids, scanned, SMALL))
    np.testing.assert_array_equal(where_seen, SMALL.project(where))


@pytest.mark.parametrize("kind", [Semantic.CAR, Semantic.GLASS, Semantic.VEGETATION, Semantic.POLE])
@settings(max_examples=4)
@given(seed=seeds, count=st.integers(1, 4))
def test_faces_are_lit(kind: Semantic, seed: int, count: int) -> None:
    view = some_view(seed, count, kind)
    triangles = triangles_of(view)
    if not len(triangles):
        return
    every = np.ones(len(triangles), bool)
    codes = np.concatenate([
        view.instances.meshes[row].codes[triangles.faces[start:end]]
        for row, (start, end) in enumerate(triangles.slices(count))
    ])  # fmt: skip
    expected = pixels.plain_paint(triangles, codes, SMALL, view.sun).astype(int)
    assert np.abs(paint(view, triangles, codes, every) - expected).max() <= 1


@FEW
@given(seeds, counts)
def test_objects_are_laid_over_the_backdrop(seed: int, count: int) -> None:
    view = some_view(seed, count)
    rendered, bare = RasterRenderer().render(view), RasterRenderer().backdrop(view)
    triangles = triangles_of(view)
    found = fill(triangles, SMALL)
    covered = found.numbers > 0
    ids = view.instances.ids[triangles.objects]
    np.testing.assert_array_equal(rendered.instances, pixels.plain_instances(found.numbers, ids))
    for name in ("image", "depth", "semantics"):
        np.testing.assert_array_equal(
            getattr(rendered, name)[~covered], getattr(bare, name)[~covered]
        )
    np.testing.assert_array_equal(rendered.depth[covered], np.float32(1) / found.nearness[covered])
    if len(triangles):
        own = Materials.of(view, triangles).codes
        codes = paint(view, triangles, own, pixels.plain_seen(triangles, found.numbers))[
            found.numbers[covered] - 1
        ]
        np.testing.assert_array_equal(rendered.image[covered], codes[:, :3])
        np.testing.assert_array_equal(rendered.semantics[covered], codes[:, 3])


@FEW
@given(seeds, st.integers(1, 6))
def test_smooth_edges_mix_four_samples_and_nothing_else_changes(seed: int, count: int) -> None:
    view = some_view(seed, count)
    plain_one, smooth = RasterRenderer().render(view), SmoothRenderer().render(view)
    for name in ("depth", "instances", "semantics"):
        np.testing.assert_array_equal(getattr(plain_one, name), getattr(smooth, name))
    triangles, behind = triangles_of(view), RasterRenderer().backdrop(view).image
    if not len(triangles):
        np.testing.assert_array_equal(smooth.image, plain_one.image)
        return
    aside = np.array([[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]])
    colours, objects, own = [], [], Materials.of(view, triangles).codes
    for shift in aside:  # each sample by a camera of its own
        K = SMALL.K.copy()
        K[:2, 2] -= shift
        numbers = fill(triangles, replace(SMALL, K=K)).numbers
        painted = paint(view, triangles, own, pixels.plain_seen(triangles, numbers))[
            numbers - 1, :3
        ]
        colours.append(np.where((numbers > 0)[..., None], painted, behind))
        objects.append(np.where(numbers > 0, triangles.objects[numbers - 1], -1))
    mixed = (np.sum(colours, axis=0, dtype=int) + 2) // 4
    is_edge = (np.array(objects) != objects[0]).any(axis=0)
    expected = np.where(is_edge[..., None], mixed, plain_one.image)
    assert (smooth.image != expected).any(axis=2).sum() <= 1  # a centre on an edge, once


def test_an_image_has_room_for_all_that_are_filled_at_once() -> None:
    assert load("mot_sim.simulation.kernels.filling").PIXELS == SPARE_PIXELS
