"""The road and the sky."""

from itertools import pairwise

import numpy as np
import pytest

from mot_sim.simulation.renderers import Road, Semantic, Sky, Texture
from mot_sim.simulation.renderers.ground import (
    PIECE_ROWS,
    bands,
    horizon,
    road_image,
    road_semantics,
    sky_image,
)
from tests.mot_sim.simulation.renderers.shapes import CROOKED, KITTI
from tests.mot_sim.simulation.scenery.places import ego_on, neighbourhood
from tracker.types import Camera


@pytest.mark.parametrize("camera", [KITTI, CROOKED], ids=["kitti", "crooked"])
def test_the_roads_depth_is_where_the_rays_meet_it(camera: Camera) -> None:
    width, height = camera.image_size
    v, u = np.mgrid[:height, :width]
    pixels = np.stack((u, v), axis=-1).reshape(-1, 2).astype(float)
    exact = camera.touch_road(pixels)[:, 2].reshape(height, width)
    depth = horizon(camera).depth
    known = np.isfinite(exact)  # touch_road gives up a little below the horizon
    assert np.count_nonzero(np.isfinite(depth) & ~known) <= 2 * width
    assert known.mean() > 0.2
    assert np.abs(depth[known] / exact[known] - 1.0).max() < 1e-6


def test_a_kitti_pixel_ten_rows_below_the_horizon_is_where_one_computes_it_by_hand() -> None:
    K = np.array([[700.0, 0.0, 600.0], [0.0, 700.0, 180.0], [0.0, 0.0, 1.0]])
    seen = horizon(Camera.mounted(K, (1200, 370), 1.6))
    assert seen.depth[190, 3] == pytest.approx(1.6 * 700.0 / 10.0)
    assert np.isinf(seen.depth[180, 3])
    assert seen.first == 181


def test_the_bands_cover_the_road_without_gap_and_are_finest_at_the_horizon() -> None:
    road = Road.spread(Texture(np.zeros((2000, 400, 3), np.uint8)), (-10.0, 10.0), (0.0, 100.0))
    cut = bands(KITTI, road)
    assert cut[0][0] == horizon(KITTI).first
    assert cut[-1][1] == KITTI.image_size[1]
    assert all(one[1] == other[0] for one, other in pairwise(cut))
    finer = [band[2] for band in cut]
    assert finer == sorted(finer, reverse=True)
    assert (finer[0], finer[-1]) == (4, 1)


def test_finer_bands_show_the_same_picture() -> None:
    z, x = np.mgrid[:400, :200] / 10.0
    smooth = (120 + 60 * np.sin(x / 2.0) + 40 * np.cos(z / 4.0)).astype(np.uint8)
    texture = np.repeat(smooth[..., None], 3, axis=2)
    coarse = Texture(np.ascontiguousarray(texture))
    fine = Texture(np.repeat(np.repeat(texture, 5, axis=0), 5, axis=1))
    area = (-10.0, 10.0), (0.0, 40.0)
    one = road_image(KITTI, Road.spread(coarse, *area))
    other = road_image(KITTI, Road.spread(fine, *area))
    inside = road_semantics(KITTI, Road.spread(fine, *area))[horizon(KITTI).first :]
    difference = np.abs(one.astype(int) - other)[inside == Semantic.ROAD]
    assert np.mean(difference) < 2.0
    assert np.quantile(difference, 0.99) < 12


def test_the_road_ends_where_its_texture_does() -> None:
    road = Road.spread(Texture(np.full((50, 50, 3), 90, np.uint8)), (-3.0, 3.0), (0.0, 30.0))
    kinds = road_semantics(KITTI, road)
    for x, z, kind in (
        (2.9, 12.0, Semantic.ROAD),
        (3.1, 12.0, Semantic.GROUND),
        (0.0, 27.0, Semantic.ROAD),
        (0.0, 34.0, Semantic.GROUND),
    ):
        u, v = np.round(KITTI.project(np.array([x, KITTI.height, z]))).astype(int)
        assert kinds[v, u] == kind


def test_the_sky_grows_darker_upwards_from_the_horizon() -> None:
    image = sky_image(KITTI, Sky(top=(10, 20, 30), low=(200, 210, 220)))
    assert image[200, 5].tolist() == [200, 210, 220]
    assert (np.diff(image[:170, 5, 0].astype(int)) >= 0).all()


@pytest.mark.parametrize("rows", range(1, PIECE_ROWS + 1))
@pytest.mark.parametrize("columns", [1, 2, 300])
def test_a_piece_of_sky_of_any_size_is_the_same(rows: int, columns: int) -> None:
    sky = neighbourhood("street").sky_at(ego_on("street"))
    assert sky.panorama is not None
    width, height = KITTI.image_size
    # (The principal point decides how many rows see the sky, and so the size of the last piece.)
    K = KITTI.K.copy()
    K[1, 2] = 6 * PIECE_ROWS + rows - 1.5
    camera = Camera.mounted(K, (width, height), 1.65)
    spans = np.zeros((height, 2), np.int32)
    spans[6 * PIECE_ROWS :] = 700, 700 + columns
    part = slice(6 * PIECE_ROWS, None), slice(700, 700 + columns)
    whole, piece = sky_image(camera, sky), sky_image(camera, sky, spans)
    np.testing.assert_array_equal(piece[part], whole[part])
