"""Leaves, gaps in crowns and patterns of walls: only colours change, and they stay in place."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.simulation.renderers import Material, Mesh, Semantic, View
from mot_sim.simulation.renderers.filling import KernelFiller, fill, fill_apart
from mot_sim.simulation.renderers.materials import (
    NOISE_SIZES,
    TEXELS_A_METRE,
    TONE_STEPS,
    Materials,
    patterns,
)
from mot_sim.simulation.renderers.raster import RasterRenderer, paint
from mot_sim.simulation.renderers.triangles import Triangles
from tests.mot_sim.simulation.kernels.plain_pixels import plain_seen
from tests.mot_sim.simulation.renderers.shapes import KITTI, at, box, lump, view_of
from tracker.kernels.loading import load
from tracker.types import Camera

SMALL = Camera.mounted(
    np.array([[60.0, 0.4, 39.3], [0.0, 66.0, 27.6], [0.0, 0.0, 1.0]]), (81, 57), 1.3, 0.05, 0.04
)
R_CELL_OBJECT = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
RASTER = RasterRenderer()
seeds = st.integers(0, 2**32 - 1)


def made_of(mesh: Mesh, material: Material, kind: Semantic = Semantic.VEGETATION) -> Mesh:
    """The same shape of something else."""
    count = len(mesh.faces)
    return replace(
        mesh,
        semantics=np.full(count, kind, np.uint8),
        materials=np.full(count, material, np.uint8),
    )


def plain_bits(cells: np.ndarray) -> np.ndarray:
    """32 random bits of each cell (n, 3)."""
    x, y, z = (cells[:, axis].astype(np.int64).astype(np.uint32) for axis in range(3))
    bits = (x * np.uint32(0x8DA6B343)) ^ (y * np.uint32(0xD8163841)) ^ (z * np.uint32(0xCB1AB31F))
    bits = (bits ^ (bits >> np.uint32(15))) * np.uint32(0x2C1B3C6D)
    bits = (bits ^ (bits >> np.uint32(12))) * np.uint32(0x297A2D39)
    return bits ^ (bits >> np.uint32(15))


def some_tree(seed: int, material: Material) -> View:
    """A lump of leaves before a wall."""
    x, z, yaw = np.random.default_rng(seed).uniform((-2.0, 2.0, -9.0), (2.0, 60.0, 9.0))
    crown = made_of(lump(), material), at(SMALL, x, z, yaw)
    return view_of(SMALL, crown, (box(), at(SMALL, x, z + 9.0, yaw)))


@settings(max_examples=6)
@given(seed=seeds)
def test_faces_of_leaves_break_into_leaves_as_large_as_can_be_seen(seed: int) -> None:
    view = some_tree(seed, Material.LEAF)
    triangles = Triangles.of(view.instances, SMALL, 0.3)
    found = fill(triangles, SMALL)
    first = np.append(triangles.objects, -1)[found.numbers - 1] == 0
    v, u = np.nonzero(first)
    codes = Materials.of(view, triangles).codes
    painted = paint(view, triangles, codes, plain_seen(triangles, found.numbers))
    flat = painted[found.numbers[v, u] - 1, :3].astype(int)
    depth = 1.0 / found.nearness[v, u].astype(float)
    points = SMALL.rays(np.stack((u, v), axis=1).astype(float)) * depth[:, None]
    T = view.instances.T_cam_object[0]
    doublings = np.ceil(np.log2(np.maximum(2.2 * depth / SMALL.K[0, 0] / 0.085, 1.0)))
    cells = (points - T[:3, 3]) @ T[:3, :3] @ R_CELL_OBJECT.T / (0.085 * 2.0**doublings)[:, None]
    bits = plain_bits(np.floor(cells))
    share = 112 + (bits & 255).astype(int) + ((bits >> 8) & 63).astype(int)
    share = np.where(bits >> 24 < 60, 40 + share // 5, share)
    lit = RASTER.render(view).image[v, u]
    expected = np.minimum(flat * share[:, None] // 256, 255)
    assert (lit != expected).any(axis=1).mean() < 0.01  # on the border of two cells


@settings(max_examples=6)
@given(seed=seeds)
def test_one_sees_through_gaps_but_the_truth_does_not(seed: int) -> None:
    closed, tufts = (some_tree(seed, each) for each in (Material.LEAF, Material.TUFT))
    whole, open_one = RASTER.render(closed), RASTER.render(tufts)
    for name in ("depth", "instances", "semantics"):
        np.testing.assert_array_equal(getattr(whole, name), getattr(open_one, name))
    is_crown = open_one.semantics == Semantic.VEGETATION
    np.testing.assert_array_equal(open_one.image[~is_crown], whole.image[~is_crown])
    triangles = Triangles.of(tufts.instances, SMALL, 0.3)
    kinds = open_one.semantics.copy()
    shown = Materials.of(tufts, triangles).lay(triangles, tufts, KernelFiller(), kinds)[2]
    gaps = is_crown & (np.append(triangles.objects, -1)[np.maximum(shown.numbers, 0) - 1] != 0)
    behind = fill(triangles.of_objects(np.array([1])), SMALL)
    np.testing.assert_array_equal(shown.nearness[gaps], behind.nearness[gaps])
    backdrop = RASTER.backdrop(tufts).image
    np.testing.assert_array_equal(
        open_one.image[gaps & (behind.numbers == 0)], backdrop[gaps & (behind.numbers == 0)]
    )
    np.testing.assert_array_equal(open_one.image[is_crown & ~gaps], whole.image[is_crown & ~gaps])
    assert is_crown.sum() < 40 or 0.2 < gaps[is_crown].mean() < 0.65


@settings(max_examples=10)
@given(seed=seeds)
def test_leaves_are_filled_apart(seed: int) -> None:
    view = some_tree(seed, Material.TUFT)
    triangles = Triangles.of(view.instances, SMALL, 0.3)
    leaves = np.random.default_rng(seed).random(len(triangles)) < 0.5
    for part, found in zip((~leaves, leaves), fill_apart(triangles, SMALL, leaves), strict=True):
        rows = np.flatnonzero(part)
        if found is None:
            assert not len(rows)
            continue
        alone = fill(triangles.at(rows), SMALL)
        np.testing.assert_array_equal(found.nearness, alone.nearness)
        np.testing.assert_array_equal(found.numbers, np.append(0, rows + 1)[alone.numbers])


@settings(max_examples=10)
@given(seed=seeds)
def test_labels_are_of_the_nearest_and_what_is_seen_is_marked(seed: int) -> None:
    view = some_tree(seed, Material.TUFT)
    triangles = Triangles.of(view.instances, SMALL, 0.3)
    found, plain = RASTER.render(view), fill(triangles, SMALL)
    covered = plain.numbers > 0
    rows = plain.numbers[covered] - 1
    np.testing.assert_array_equal(found.depth[covered], np.float32(1) / plain.nearness[covered])
    np.testing.assert_array_equal(
        found.instances[covered], view.instances.ids[triangles.objects[rows]]
    )
    materials = Materials.of(view, triangles)
    np.testing.assert_array_equal(found.semantics[covered], materials.codes[rows, 3])
    shown = materials.lay(triangles, view, KernelFiller(), found.semantics)[2]
    assert shown.seen[shown.numbers[shown.numbers > 0] - 1].all()
    assert ((shown.numbers < 0) <= covered).all()
    assert (shown.nearness[shown.numbers <= 0] == 0.0).all()
    for row, (first, end) in zip(shown.numbers, shown.spans.tolist(), strict=True):
        open_ones = np.flatnonzero(row <= 0)
        assert (first, end) == ((open_ones[0], open_ones[-1] + 1) if len(open_ones) else (end, end))


@pytest.mark.parametrize("material", [each for each in Material if each])
def test_walls_have_a_pattern_that_leaves_the_truth_alone(material: Material) -> None:
    plain, made = (
        RASTER.render(
            view_of(KITTI, (made_of(box(), each, Semantic.BUILDING), at(KITTI, 0.0, 8.0)))
        )
        for each in (Material.PLAIN, material)
    )
    for name in ("depth", "instances", "semantics"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(made, name))
    inside = plain.semantics == Semantic.BUILDING
    np.testing.assert_array_equal(made.image[~inside], plain.image[~inside])
    if material not in (Material.TUFT, Material.SHOP):  # a shop is higher than the box
        assert made.image[inside].std(axis=0).min() > plain.image[inside].std(axis=0).min()


def test_patterns_change_the_mean_little() -> None:
    finest = patterns()[1 : Material.BARK + 1, : 512 * 512] / 80.0
    assert finest.std(axis=1).min() > 0.05
    assert np.abs(finest.mean(axis=1)).max() < 0.02


def test_the_kernel_counts_texels_and_materials_as_the_patterns_do() -> None:
    kernel = load("mot_sim.simulation.kernels.materials")
    assert kernel.TEXELS_A_METRE == TEXELS_A_METRE
    assert tuple(kernel.TEXELS >> level for level in range(kernel.LEVELS)) == NOISE_SIZES
    assert pytest.approx(TONE_STEPS, rel=1e-4) == kernel.MEAN / kernel.TONE
    named = ("BLOCKS", "LEAF", "TUFT", "SHOP")
    assert [getattr(kernel, name) for name in named] == [Material[name] for name in named]
