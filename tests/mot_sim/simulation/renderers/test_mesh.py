"""The OpenGL renderer, and how well it agrees with the embedded one."""

from collections.abc import Iterator
from contextlib import nullcontext

import cv2
import numpy as np
import pytest

from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.renderers import (
    MeshInstances,
    Rendered,
    Semantic,
    View,
    silhouettes,
)
from mot_sim.simulation.renderers.mesh import MeshRenderer, OpenGLFiller
from mot_sim.simulation.renderers.raster import RasterRenderer, SmoothRenderer
from mot_sim.simulation.renderers.view import Material
from mot_sim.simulation.scenery import WEATHERS, Neighbourhood
from tests.mot_sim.simulation.renderers.shapes import CROOKED, KITTI, at, box, lump, street, view_of
from tracker.errors import NoOpenGL
from tracker.types import Camera

pytestmark = pytest.mark.gl
RASTER = RasterRenderer()


@pytest.fixture(scope="module")
def mesh() -> Iterator[MeshRenderer]:
    """A renderer with an OpenGL context, where there is one."""
    try:
        renderer = MeshRenderer()
    except NoOpenGL as error:
        pytest.skip(str(error))
    yield renderer
    renderer.close()


def both(mesh: MeshRenderer, view: View) -> tuple[Rendered, Rendered]:
    return RASTER.render(view), mesh.render(view)


VIEWS = {"kitti": (KITTI, 20, 0), "another": (KITTI, 14, 5), "crooked": (CROOKED, 10, 1)}
every_view = pytest.mark.parametrize("name", list(VIEWS))


@every_view
def test_masks_of_large_objects_agree(mesh: MeshRenderer, name: str) -> None:
    view = street(*VIEWS[name])
    one, other = both(mesh, view)
    measured, compared = silhouettes(view), 0
    for row in range(len(view.instances)):
        a, b = one.instances == row, other.instances == row
        height = measured.amodal_boxes[row, 3] - measured.amodal_boxes[row, 1]
        if height >= 60 and measured.fraction[row] >= 0.5:
            assert (a & b).sum() / (a | b).sum() >= 0.97
            compared += 1
    assert compared > 0 or name == "crooked"


@every_view
def test_ids_differ_only_at_edges(mesh: MeshRenderer, name: str) -> None:
    one, other = both(mesh, street(*VIEWS[name]))
    for a, b in ((one.instances, other.instances), (one.semantics, other.semantics)):
        low = cv2.erode(a.astype(np.float32), np.ones((3, 3)))
        high = cv2.dilate(a.astype(np.float32), np.ones((3, 3)))
        assert (low < high)[a != b].all()


@every_view
def test_depths_agree(mesh: MeshRenderer, name: str) -> None:
    one, other = both(mesh, street(*VIEWS[name]))
    same = (one.instances == other.instances) & np.isfinite(one.depth)
    assert np.array_equal(np.isinf(one.depth), np.isinf(other.depth))
    assert np.abs(one.depth[same] / other.depth[same] - 1.0).max() < 0.005


@every_view
def test_visible_fractions_agree(mesh: MeshRenderer, name: str) -> None:
    view = street(*VIEWS[name])
    measured, rendered = silhouettes(view), mesh.render(view)
    counts = np.bincount(rendered.instances.ravel() + 1, minlength=len(view.instances) + 1)[1:]
    large = measured.amodal >= 100
    assert np.abs(measured.fraction - counts / measured.amodal)[large].max() < 0.02


@every_view
def test_colours_are_those_of_the_smooth_renderer(mesh: MeshRenderer, name: str) -> None:
    view = street(*VIEWS[name])
    one, other = SmoothRenderer().render(view), mesh.render(view)
    is_other = np.abs(one.image.astype(int) - other.image).max(axis=2) > 1
    assert np.count_nonzero(is_other) < 0.002 * is_other.size


def test_materials_and_gaps_in_crowns_are_the_same(mesh: MeshRenderer) -> None:
    place = Neighbourhood.build(find_scene("street").roads, 3, WEATHERS["noon"].light)
    view = place.view(KITTI, np.zeros(3), MeshInstances.empty())
    one, other = SmoothRenderer().render(view), mesh.render(view)
    kinds = [k for m in view.instances.meshes if m.materials is not None for k in set(m.materials)]
    assert {int(Material.TUFT), int(Material.BRICK)} <= {int(kind) for kind in kinds}
    is_other = np.abs(one.image.astype(int) - other.image).max(axis=2) > 1
    assert np.count_nonzero(is_other) < 0.002 * is_other.size


def test_an_object_at_the_near_plane_is_cut_alike(mesh: MeshRenderer) -> None:
    one, other = both(mesh, view_of(KITTI, (lump(), at(KITTI, -1.9, 1.5, -np.pi / 2))))
    assert np.count_nonzero(one.instances != other.instances) < 60


def test_a_view_of_nothing_is_the_same_in_both(mesh: MeshRenderer) -> None:
    one, other = both(mesh, View(KITTI, MeshInstances.empty()))
    assert np.array_equal(one.image, other.image)
    assert (other.semantics != Semantic.CAR).all()


def test_a_skewed_camera_sees_the_same(mesh: MeshRenderer) -> None:
    K = KITTI.K.copy()
    K[0, 1] = 20.0
    skewed = Camera.mounted(K, KITTI.image_size, 1.65)
    view = view_of(skewed, (box(), at(skewed, 1.0, 6.0)))
    one, other = both(mesh, view)
    assert (one.instances == 0).sum() > 1000
    assert np.count_nonzero(one.instances != other.instances) < 60


def test_colours_of_neighbours_that_mix_are_noticed(
    mesh: MeshRenderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert isinstance(mesh.filler, OpenGLFiller)
    assert mesh.filler.keeps_colours()
    monkeypatch.setattr("mot_sim.simulation.renderers.mesh._one_sample", lambda _: nullcontext())
    assert not mesh.filler.keeps_colours()
