"""Corners and their flow on hand-made images."""

import cv2
import numpy as np

from tracker.ego import CornerFlow, Features

EVERYWHERE = np.ones((120, 200), bool)


def speckled(seed: int = 0) -> np.ndarray:
    """Smooth noise."""
    noise = np.random.default_rng(seed).normal(size=(120, 200)).astype(np.float32)
    return np.clip(128 + 250 * cv2.GaussianBlur(noise, (0, 0), 2.0), 0, 255).astype(np.uint8)


def test_the_corner_flow_is_features() -> None:
    assert isinstance(CornerFlow(), Features)


def test_a_shifted_image_shifts_its_points() -> None:
    image = speckled()
    shifted = np.roll(image, (2, 5), axis=(0, 1))
    before, now = CornerFlow()(image, shifted, EVERYWHERE)
    assert len(before) > 20
    inner = ((before > 15) & (before < (180.0, 100.0))).all(axis=1)
    np.testing.assert_allclose(
        (now - before)[inner], np.tile((5.0, 2.0), (inner.sum(), 1)), atol=0.1
    )


def test_the_corner_of_a_square_is_found_where_it_is() -> None:
    image = np.zeros((120, 200), np.uint8)
    image[40:80, 60:140] = 200
    corners = CornerFlow(per_cell=1).corners(image, EVERYWHERE)
    assert np.abs(corners - (60.0, 40.0)).max(axis=1).min() < 3.0


def test_hidden_pixels_give_no_corner() -> None:
    free = EVERYWHERE.copy()
    free[:, 100:] = False
    before, now = CornerFlow()(speckled(), speckled(), free)
    assert len(before)
    assert before[:, 0].max() < 100.0
    np.testing.assert_allclose(now, before, atol=0.01)


def test_an_image_without_corners_gives_no_points() -> None:
    flat = np.full((120, 200), 90, np.uint8)
    for image, free in ((flat, EVERYWHERE), (speckled(), ~EVERYWHERE)):
        before, now = CornerFlow()(image, image, free)
        assert before.shape == now.shape == (0, 2)
    tiny = np.zeros((10, 10), np.uint8)
    assert CornerFlow()(tiny, tiny, np.ones((10, 10), bool))[0].shape == (0, 2)


def test_no_cell_gives_more_than_its_share() -> None:
    flow = CornerFlow(cell=40, per_cell=2)
    corners = flow.corners(speckled(), EVERYWHERE)
    cells, counts = np.unique(corners // 40, axis=0, return_counts=True)
    assert len(cells) > 5
    assert counts.max() <= 2
