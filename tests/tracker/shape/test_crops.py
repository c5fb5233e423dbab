"""Square pieces of an image around boxes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker.shape import CROP_MARGIN, CROP_SIDE, cut_crops, from_shares, to_shares, windows_of
from tracker.shape.crops import OUTSIDE_COLOUR, show_something


def test_a_window_is_a_square_around_the_middle_of_its_box() -> None:
    windows = windows_of(np.array([[10.0, 20.0, 50.0, 40.0]]))
    assert windows[0] == pytest.approx([30.0, 30.0, 40.0 * CROP_MARGIN])


def test_a_window_of_the_crop_s_own_size_is_cut_pixel_by_pixel() -> None:
    image = np.random.default_rng(0).integers(0, 255, (100, 120, 3)).astype(np.uint8)
    window = np.array([[20.0 + 31.5, 10.0 + 31.5, float(CROP_SIDE)]])
    assert (cut_crops(image, window)[0] == image[10:74, 20:84]).all()


def test_a_large_window_is_averaged() -> None:
    checks = (255 * (np.indices((256, 256)).sum(axis=0) % 2)).astype(np.uint8)[:, :, None]
    crop = cut_crops(checks, np.array([[127.5, 127.5, 256.0]]))[0]
    assert crop.min() >= 126
    assert crop.max() <= 129


def test_beyond_the_image_is_grey() -> None:
    image = np.zeros((40, 40, 3), np.uint8)
    crop = cut_crops(image, np.array([[0.0, 20.0, 64.0]]))[0]
    assert tuple(crop[32, 0]) == OUTSIDE_COLOUR
    assert tuple(crop[32, -1]) == (0, 0, 0)


def test_no_window_gives_no_crop() -> None:
    image = np.zeros((40, 40, 3), np.uint8)
    assert cut_crops(image, np.zeros((0, 3))).shape == (0, CROP_SIDE, CROP_SIDE, 3)
    assert windows_of(np.zeros((0, 4))).shape == (0, 3)


@given(
    st.floats(-500.0, 2000.0), st.floats(-500.0, 500.0), st.floats(2.0, 900.0), st.floats(0.0, 1.0)
)
def test_shares_and_pixels_are_inverse(u: float, v: float, side: float, share: float) -> None:
    windows = np.array([[u, v, side]])
    shares = np.array([[[share, 1.0 - share]]])
    assert to_shares(from_shares(shares, windows), windows) == pytest.approx(shares)


@pytest.mark.parametrize(
    ("what", "box", "shows"),
    [
        ("an ordinary box", (10.0, 10.0, 60.0, 40.0), True),
        ("cut by the border", (-30.0, 10.0, 5.0, 40.0), True),
        ("one pixel", (10.0, 10.0, 11.0, 11.0), False),
        ("without area", (10.0, 10.0, 60.0, 10.0), False),
        ("left of the image", (-60.0, 10.0, -5.0, 40.0), False),
        ("below the image", (10.0, 90.0, 60.0, 140.0), False),
        ("not finite", (np.nan, 10.0, 60.0, 40.0), False),
    ],
)
def test_which_boxes_show_something(what: str, box: tuple[float, ...], shows: bool) -> None:
    assert bool(show_something(np.array([box]), (100, 80))[0]) is shows, what
