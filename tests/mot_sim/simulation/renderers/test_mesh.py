"""The OpenGL renderer, and how well it agrees with the embedded one."""

from collections.abc import Iterator

import cv2
import numpy as np
import pytest

from mot_sim.simulation.renderers import (
    NO_INSTANCE,
    MeshInstances,
    Rendered,
    Semantic,
    View,
    silhouettes,
)
from mot_sim.simulation.renderers.mesh import MeshRenderer
from mot_sim.simulation.renderers.raster import RasterRenderer
from tests.mot_sim.simulation.renderers.shapes import CROOKED, KITTI, at, box, lump, street, view_of
from tracker.errors import BadConfig, NoOpenGL
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


def test_colours_are_alike(mesh: MeshRenderer) -> None:
    one, other = both(mesh, street())
    covered = (one.instances != NO_INSTANCE) & (one.instances == other.instances)
    difference = np.abs(one.image[covered].astype(int) - other.image[covered])
    assert difference.mean() < 25
    away = cv2.dilate((one.instances != NO_INSTANCE).astype(np.uint8), np.ones((5, 5))) == 0
    assert np.array_equal(one.image[away], other.image[away])


def test_an_object_at_the_near_plane_is_cut_alike(mesh: MeshRenderer) -> None:
    one, other = both(mesh, view_of(KITTI, (lump(), at(KITTI, -1.9, 1.5, -np.pi / 2))))
    assert np.count_nonzero(one.instances != other.instances) < 60


def test_a_view_of_nothing_is_the_same_in_both(mesh: MeshRenderer) -> None:
    one, other = both(mesh, View(KITTI, MeshInstances.empty()))
    assert np.array_equal(one.image, other.image)
    assert (other.semantics != Semantic.CAR).all()


def test_a_skewed_camera_is_refused(mesh: MeshRenderer) -> None:
    K = KITTI.K.copy()
    K[0, 1] = 2.0
    skewed = Camera.mounted(K, KITTI.image_size, 1.65)
    with pytest.raises(BadConfig, match="skew of 2"):
        mesh.render(view_of(skewed, (box(), at(skewed, 0.0, 9.0))))
