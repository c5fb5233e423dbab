"""What is seen of each instance."""

import numpy as np
import pytest

from mot_sim.simulation.renderers import (
    NEAR_METRES,
    NO_INSTANCE,
    MeshInstances,
    View,
    scan_view,
    silhouettes,
)
from mot_sim.simulation.renderers.raster import RasterRenderer
from tests.mot_sim.simulation.renderers.shapes import (
    CROOKED,
    KITTI,
    at,
    box,
    lump,
    painted,
    street,
    view_of,
    wedge,
)
from tracker.types import Camera

RASTER = RasterRenderer()


@pytest.mark.parametrize("camera", [KITTI, CROOKED], ids=["kitti", "crooked"])
def test_counts_are_those_of_a_frame_with_one_object_alone(camera: Camera) -> None:
    view = street(camera, cars=10)
    measured = silhouettes(view)
    for row in range(10):
        only = MeshInstances(
            view.instances.meshes[row : row + 1],
            view.instances.T_cam_object[row : row + 1],
            np.array([row]),
        )
        alone = RASTER.render(View(camera, only)).instances
        assert measured.amodal[row] == np.count_nonzero(alone == row)
    assert (measured.visible <= measured.amodal).all()
    assert (measured.fraction < 0.7).any()


def test_visible_pixels_are_those_of_the_frame() -> None:
    view = street(cars=10)
    rendered = RASTER.render(view)
    measured = silhouettes(view)
    counts = np.bincount(rendered.instances.ravel() + 1, minlength=11)[1:]
    assert np.array_equal(measured.visible, counts)
    for row in np.flatnonzero(counts):
        v, u = np.nonzero(rendered.instances == row)
        assert measured.visible_boxes[row].tolist() == [u.min(), v.min(), u.max(), v.max()]


def test_a_car_that_stands_free_is_wholly_visible() -> None:
    view = view_of(KITTI, (lump(), at(KITTI, -4.0, 15.0)), (lump(), at(KITTI, 4.0, 15.0)))
    measured = silhouettes(view)
    assert measured.fraction.tolist() == [1.0, 1.0]
    assert np.abs(measured.visible_boxes - measured.amodal_boxes).max() <= 1.0


def test_the_full_box_is_that_of_the_projected_mesh() -> None:
    view = view_of(CROOKED, (wedge(), at(CROOKED, 0.0, 9.0)), (box(), at(CROOKED, 0.1, 14.0)))
    measured = silhouettes(view)
    for row, mesh in enumerate(view.instances.meshes):
        T = view.instances.T_cam_object[row]
        pixels = CROOKED.project(mesh.vertices @ T[:3, :3].T + T[:3, 3])
        exact = np.concatenate((pixels.min(axis=0), pixels.max(axis=0)))
        assert measured.amodal_boxes[row] == pytest.approx(exact, abs=0.02)


def test_a_hidden_car_has_a_silhouette_and_no_visible_box() -> None:
    view = view_of(KITTI, (box(8.0, 3.0, 6.0), at(KITTI, 0.0, 12.0)), (lump(), at(KITTI, 0, 25.0)))
    measured = silhouettes(view)
    assert measured.visible[1] == 0
    assert measured.amodal[1] > 500
    assert measured.fraction[1] == 0.0
    assert np.isinf(measured.visible_boxes[1]).all()
    assert np.isfinite(measured.amodal_boxes[1]).all()


def test_parts_with_one_id_are_one_silhouette() -> None:
    places = np.array([at(KITTI, -1.0, 12.0), at(KITTI, 1.0, 13.0), at(KITTI, 0.5, 30.0)])
    instances = MeshInstances((box(), box(), wedge()), places, np.array([7, 7, 3]))
    view = View(KITTI, instances)
    measured = silhouettes(view)
    assert measured.instances.tolist() == [3, 7]
    assert measured.fraction[1] == 1.0
    assert measured.fraction[0] < 1.0


def test_scenery_hides_but_has_no_row() -> None:
    places = np.array([at(KITTI, 0.0, 12.0), at(KITTI, 0.5, 20.0)])
    view = View(KITTI, MeshInstances((box(), lump()), places, np.array([NO_INSTANCE, 0])))
    measured = silhouettes(view)
    assert measured.instances.tolist() == [0]
    assert 0.0 < measured.fraction[0] < 1.0


def test_what_is_out_of_sight_has_no_pixels_and_an_inverted_box() -> None:
    view = view_of(KITTI, (lump(), at(KITTI, 0.0, -10.0)))
    measured = silhouettes(view)
    assert (measured.visible[0], measured.amodal[0], measured.fraction[0]) == (0, 0, 0.0)
    assert measured.amodal_boxes[0, 0] > measured.amodal_boxes[0, 2]


def test_a_wall_past_the_near_plane_and_the_border_is_cut_there_not_pushed_inside() -> None:
    K = np.array([[100.0, 0.0, 50.0], [0.0, 100.0, 40.0], [0.0, 0.0, 1.0]])
    camera = Camera.mounted(K, (101, 81), 1.0)
    # A slab from x = 1, 0.4 m below to 0.25 m above the camera, from behind it to 8 m before it.
    corners = [(x, y, z) for x in (1.0, 1.2) for y in (-0.25, 0.4) for z in (-2.0, 8.0)]
    quads = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    slab = painted(corners, [(q[0], *two) for q in quads for two in (q[1:3], q[2:])])
    measured = silhouettes(View(camera, MeshInstances((slab,), np.eye(4)[None], np.array([0]))))
    near = 100.0 / NEAR_METRES
    amodal = [62.5, 40.0 - 0.25 * near, 50.0 + near, 40.0 + 0.4 * near]
    assert measured.amodal_boxes[0] == pytest.approx(amodal)
    # It leaves the image at u = 100, 2 m away, where it is 32.5 pixels high.
    assert measured.clipped_boxes[0] == pytest.approx([62.5, 27.5, 100.0, 60.0])
    assert np.abs(measured.visible_boxes - measured.clipped_boxes).max() <= 1.0
    assert measured.fraction.tolist() == [1.0]


def test_only_the_boxes_of_what_leaves_the_image_are_cut() -> None:
    measured = silhouettes(street(cars=4))  # the second one leaves it to the right
    cut, whole = measured.clipped_boxes, measured.amodal_boxes
    assert (cut[1, 2], whole[1, 2] > 1300.0) == (1241.0, True)
    assert np.array_equal(np.delete(cut, 1, axis=0), np.delete(whole, 1, axis=0))


def test_no_object_gives_no_row() -> None:
    view = View(KITTI, MeshInstances.empty())
    assert len(silhouettes(view)) == 0


@pytest.mark.parametrize("camera", [KITTI, CROOKED], ids=["kitti", "crooked"])
def test_the_scan_is_what_the_renderer_draws(camera: Camera) -> None:
    view = street(camera, cars=14)
    scanned, rendered = scan_view(view), RASTER.render(view)
    assert np.array_equal(scanned.instances, rendered.instances)
    objects = rendered.instances != NO_INSTANCE
    np.testing.assert_allclose(scanned.depth[objects], rendered.depth[objects], rtol=1e-4)
    assert np.isinf(scanned.depth[~objects]).all()


def test_who_hides_a_car_is_named_with_the_pixels_it_takes() -> None:
    places = np.array([at(KITTI, 0.0, 12.0), at(KITTI, 0.8, 20.0), at(KITTI, -1.0, 24.0)])
    scanned = scan_view(
        View(KITTI, MeshInstances((box(), lump(), lump()), places, np.array([NO_INSTANCE, 4, 9])))
    )
    missing = scanned.silhouettes.amodal - scanned.silhouettes.visible
    hidden = scanned.hidden
    assert set(zip(hidden.instances.tolist(), hidden.occluder_ids.tolist(), strict=True)) == {
        (4, NO_INSTANCE),
        (9, NO_INSTANCE),
        (9, 4),
    }
    for row, number in enumerate((4, 9)):
        assert hidden.pixels[hidden.instances == number].sum() == missing[row]


def test_a_layer_is_the_object_alone() -> None:
    view = street(cars=6)
    scanned = scan_view(view)
    for layer in scanned.layers:
        row = layer.instance
        only = MeshInstances(
            view.instances.meshes[row : row + 1],
            view.instances.T_cam_object[row : row + 1],
            np.array([row]),
        )
        rendered = RASTER.render(View(KITTI, only))
        left, top, right, bottom = layer.box
        covered = rendered.instances[top:bottom, left:right] == row
        assert np.array_equal(layer.nearness > 0.0, covered)
        alone = rendered.depth[top:bottom, left:right][covered]
        np.testing.assert_allclose(1.0 / layer.nearness[covered], alone, rtol=1e-4)
