"""Statistics of images, by images of which they are known."""

import cv2
import numpy as np
import pytest

from mot_sim.simulation.camera_looks.image_statistics import (
    STATISTICS,
    image_statistics,
    mean_statistics,
)
from tracker.errors import BadConfig


def noisy(
    level: float, sigma: float, seed: int = 0, size: tuple[int, int] = (128, 200)
) -> np.ndarray:
    grey = level + sigma * np.random.default_rng(seed).standard_normal((*size, 1))
    return np.tile(np.rint(grey), 3).clip(0, 255).astype(np.uint8)


def test_halves_of_black_and_white_by_hand() -> None:
    image = np.zeros((100, 160, 3), np.uint8)
    image[:, 80:] = 255
    found = image_statistics(image)
    assert found.luma_std == pytest.approx(127.5, abs=0.1)
    assert found.dark == pytest.approx(50.0)
    assert found.clipped == pytest.approx(50.0)
    assert found.saturation == 0.0
    assert found.red_minus_blue == 0.0
    assert found.gradient == 0.0
    assert np.isnan(found.noise_mid)


def test_colours_and_slopes_by_hand() -> None:
    image = np.zeros((80, 200, 3), np.uint8)
    image[..., 0], image[..., 2] = 40, 100
    ramp = np.tile(np.arange(200, dtype=np.uint8)[None, :, None], (80, 1, 3))
    assert image_statistics(image).red_minus_blue == pytest.approx(-60.0)
    assert image_statistics(image).saturation == 255.0
    assert image_statistics(ramp).gradient == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(("level", "name"), [(38, "dark"), (75, "mid"), (125, "bright")])
def test_noise_is_found_where_its_light_is(level: float, name: str) -> None:
    for sigma in (1.0, 3.0):
        found = image_statistics(noisy(level, sigma))
        assert getattr(found, f"noise_{name}") == pytest.approx(sigma, rel=0.2)


def test_blur_takes_fine_power_and_makes_the_spectrum_steeper() -> None:
    sharp = noisy(120.0, 30.0)
    soft = cv2.GaussianBlur(sharp, (0, 0), 1.0)
    before, after = image_statistics(sharp), image_statistics(soft)
    assert after.fine_power < 0.3 * before.fine_power
    assert after.spectrum_slope < before.spectrum_slope - 0.5
    assert before.spectrum_slope == pytest.approx(0.0, abs=0.1)  # white noise


def test_means_leave_out_what_cannot_be_measured() -> None:
    dark, bright = noisy(10.0, 2.0), noisy(125.0, 2.0)
    found = mean_statistics([dark, bright])
    assert found.dark == pytest.approx(50.0, abs=1.0)
    assert found.noise_bright == image_statistics(bright).noise_bright
    assert len(STATISTICS) == 11


def test_no_image_and_a_tiny_one_are_refused() -> None:
    with pytest.raises(BadConfig, match="no image"):
        mean_statistics([])
    with pytest.raises(BadConfig, match="an image of 40 x 30 pixels: give 64 or more"):
        image_statistics(np.zeros((30, 40, 3), np.uint8))
