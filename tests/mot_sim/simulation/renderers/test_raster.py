"""Frames of the embedded renderer."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from mot_sim.simulation.renderers import (
    NO_INSTANCE,
    MeshInstances,
    Road,
    Semantic,
    Sun,
    Texture,
    View,
)
from mot_sim.simulation.renderers.raster import RasterRenderer
from tests.mot_sim.simulation.renderers.shapes import (
    CROOKED,
    KITTI,
    at,
    box,
    lump,
    street,
    view_of,
    wedge,
)
from tracker.errors import BadCalibration, BadConfig
from tracker.types import Camera

RASTER = RasterRenderer()


def layers(rendered) -> tuple[np.ndarray, ...]:
    return rendered.image, rendered.depth, rendered.instances, rendered.semantics


def test_two_runs_give_the_same_bytes() -> None:
    first, second = (RasterRenderer().render(street(cars=8)) for _ in range(2))
    for one, other in zip(layers(first), layers(second), strict=True):
        assert one.tobytes() == other.tobytes()


def test_the_number_of_threads_changes_no_byte() -> None:
    before = cv2.getNumThreads()
    try:
        frames = []
        for threads in (1, 2):
            cv2.setNumThreads(threads)
            frames.append(RASTER.render(street(cars=8)))
    finally:
        cv2.setNumThreads(before)
    for one, other in zip(layers(frames[0]), layers(frames[1]), strict=True):
        assert one.tobytes() == other.tobytes()


def test_a_frame_is_the_callers_own() -> None:
    view = street(cars=2)
    first = RASTER.render(view)
    for layer in layers(first):
        layer[:] = 7
    second = RASTER.render(view)
    assert not any((layer == 7).all() for layer in layers(second))


def test_rendering_leaves_its_inputs_alone() -> None:
    view = street(cars=3)
    before = view.instances.T_cam_object.copy(), view.instances.meshes[0].vertices.copy()
    RASTER.render(view)
    assert np.array_equal(view.instances.T_cam_object, before[0])
    assert np.array_equal(view.instances.meshes[0].vertices, before[1])


def test_a_view_of_nothing_is_sky_over_road() -> None:
    rendered = RASTER.render(View(KITTI, MeshInstances.empty()))
    assert (rendered.instances == NO_INSTANCE).all()
    assert set(np.unique(rendered.semantics)) == {Semantic.SKY, Semantic.ROAD, Semantic.GROUND}
    assert np.array_equal(np.isinf(rendered.depth), rendered.semantics == Semantic.SKY)
    assert (rendered.image[-1] == rendered.image[-1, 0]).all()


def test_without_a_road_the_sky_goes_on_below() -> None:
    rendered = RASTER.render(View(KITTI, MeshInstances.empty(), road=None))
    assert np.isinf(rendered.depth).all()
    assert (rendered.semantics == Semantic.SKY).all()


def test_a_camera_that_looks_up_sees_no_road() -> None:
    upwards = Camera.mounted(KITTI.K, KITTI.image_size, 1.65, pitch=1.2)
    rendered = RASTER.render(view_of(upwards, (box(), at(upwards, 0.0, 10.0))))
    assert np.isinf(rendered.depth).all()


def test_ids_and_depth_agree_about_where_objects_are() -> None:
    view = street(cars=12)
    rendered = RASTER.render(view)
    alone = RASTER.render(View(KITTI, MeshInstances.empty()))
    assert set(np.unique(rendered.instances)) <= {NO_INSTANCE, *range(12)}
    covered = rendered.instances != NO_INSTANCE
    kinds = {Semantic.CAR, Semantic.GLASS, Semantic.TYRE}
    assert set(np.unique(rendered.semantics[covered])) == kinds
    assert np.array_equal(rendered.depth[~covered], alone.depth[~covered])
    assert (rendered.depth[covered] < 1.001 * alone.depth[covered]).all()  # nothing below the road
    for row in range(12):
        mine = rendered.depth[rendered.instances == row]
        z = view.instances.T_cam_object[row, 2, 3]
        assert not mine.size or (abs(mine - z) < 2.6).all()


def test_the_nearer_object_hides_the_farther_in_whatever_order_they_come() -> None:
    near, far = (box(), at(KITTI, 0.0, 9.0)), (wedge(), at(KITTI, 0.2, 16.0))
    one, other = RASTER.render(view_of(KITTI, near, far)), RASTER.render(view_of(KITTI, far, near))
    assert np.array_equal(one.image, other.image)
    assert np.array_equal(one.depth, other.depth)
    assert np.array_equal(one.instances == 0, other.instances == 1)
    assert np.count_nonzero(one.instances == 0) > np.count_nonzero(one.instances == 1) > 0


def test_scenery_is_drawn_without_an_id() -> None:
    mesh, place = box(), at(KITTI, 0.0, 9.0)
    instances = MeshInstances((mesh,), place[None], np.array([NO_INSTANCE]))
    rendered = RASTER.render(View(KITTI, instances))
    assert (rendered.instances == NO_INSTANCE).all()
    assert np.count_nonzero(rendered.semantics == Semantic.CAR) > 5000


def test_an_object_around_the_camera_is_seen_from_inside_as_nothing() -> None:
    rendered = RASTER.render(view_of(KITTI, (box(6.0, 3.0, 3.0), at(KITTI, 0.0, 0.0))))
    assert (rendered.instances == NO_INSTANCE).all()


def test_an_object_beside_the_camera_is_cut_at_the_near_plane() -> None:
    rendered = RASTER.render(view_of(KITTI, (lump(), at(KITTI, -1.9, 1.5, -np.pi / 2))))
    seen = rendered.instances == 0
    assert seen[:, 0].any()  # it leaves the image on the left
    assert not seen[:, 700:].any()
    assert rendered.depth[seen].min() >= RASTER.near


def test_a_larger_near_plane_cuts_more() -> None:
    view = view_of(KITTI, (box(), at(KITTI, -1.9, 3.0, -np.pi / 2)))
    depth = RasterRenderer(near=3.0).render(view)
    assert depth.depth[depth.instances == 0].min() >= 3.0


@pytest.mark.parametrize("near", [0.0, -0.3, np.nan, np.inf])
def test_a_near_plane_that_is_not_before_the_camera_is_refused(near: float) -> None:
    with pytest.raises(BadConfig, match=r"near plane at .* must lie before the camera"):
        RasterRenderer(near=near)


def test_an_image_without_pixels_never_reaches_a_renderer() -> None:
    with pytest.raises(BadCalibration, match="image size"):
        Camera.mounted(KITTI.K, (0, 375), 1.65)


def test_faces_in_the_sun_are_brighter_than_those_in_the_shade() -> None:
    sun = Sun(towards=(0.0, -1.0, -1.0))  # behind us
    dull = replace(box(colour=(100, 100, 100)), semantics=np.full(12, Semantic.OTHER, np.uint8))
    view = view_of(KITTI, (dull, at(KITTI, 0.0, 9.0, 0.0)), sun=sun)
    rendered = RASTER.render(view)
    v, u = np.nonzero(rendered.instances == 0)
    rear, roof = rendered.image[v.max() - 3, u.mean().astype(int), 0], 100
    away = Sun(towards=(0.0, -1.0, 1.0))
    dark = RASTER.render(View(KITTI, view.instances, sun=away))
    assert dark.image[v.max() - 3, u.mean().astype(int), 0] < 0.6 * rear
    assert roof in rendered.image[rendered.instances == 0][:, 0]  # level: its own colour


def test_a_shadow_lies_beside_its_car_and_darkens_only_the_road() -> None:
    view = view_of(KITTI, (box(), at(KITTI, 0.0, 9.0)))
    lit, plain = RASTER.render(view), RasterRenderer(shadows=False).render(view)
    darker = (lit.image.astype(int) < plain.image).any(axis=2)
    assert (lit.image <= plain.image).all()
    assert darker.sum() > 1000
    assert (lit.semantics[darker] == Semantic.ROAD).all()
    v, u = np.nonzero(darker)
    ground = KITTI.touch_road(np.stack((u, v), axis=1).astype(float))
    assert np.hypot(ground[:, 0], ground[:, 2] - 9.0).max() < 4.5
    assert np.array_equal(lit.depth, plain.depth)


def test_a_crooked_camera_sees_a_texels_corner_where_it_projects() -> None:
    texture = np.zeros((200, 100, 3), np.uint8)
    texture[100:, 50:] = 255  # white: x > 0 and z < 10
    road = Road.spread(Texture(texture), (-5.0, 5.0), (0.0, 20.0))
    rendered = RASTER.render(View(CROOKED, MeshInstances.empty(), road))
    for x, z, white in ((0.4, 9.0, True), (-0.4, 9.0, False), (0.4, 11.0, False), (0.4, 6, True)):
        point = CROOKED.T_cam_road[:3, :3] @ (x, 0.0, z) + CROOKED.T_cam_road[:3, 3]
        u, v = np.round(CROOKED.project(point)).astype(int)
        assert (rendered.image[v, u, 0] > 127) == white
        assert rendered.depth[v, u] == pytest.approx(point[2], rel=0.1)


def test_glass_mirrors_the_sky_and_paint_the_sun() -> None:
    place = at(KITTI, 0.0, 9.0, 0.0)
    means = {}
    for kind in (Semantic.OTHER, Semantic.CAR, Semantic.GLASS):
        mesh = replace(box(colour=(60, 60, 60)), semantics=np.full(12, kind, np.uint8))
        rendered = RASTER.render(view_of(KITTI, (mesh, place)))
        means[kind] = rendered.image[rendered.instances == 0].mean()
    assert means[Semantic.OTHER] < means[Semantic.CAR] < means[Semantic.GLASS]


def test_a_mesh_that_casts_no_shadow_leaves_the_road_alone() -> None:
    place = at(KITTI, 0.0, 9.0)
    lit = RASTER.render(view_of(KITTI, (replace(box(), casts=False), place)))
    bare = RASTER.render(View(KITTI, MeshInstances.empty()))
    beside = lit.instances == NO_INSTANCE
    assert np.array_equal(lit.image[beside], bare.image[beside])
