"""What air leaves of the light and adds to it equals plain NumPy."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.simulation.scenery import post_processing as post
from mot_sim.simulation.scenery.weather import Weather
from tests.mot_sim.simulation.kernels.test_drawing import SMALL


@pytest.mark.unchecked
@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.sampled_from([15.0, 300.0, 1e9]), st.sampled_from([0.0, 0.4]))
def test_air(seed: int, visibility: float, loss: float) -> None:
    rng, (width, height) = np.random.default_rng(seed), SMALL.image_size
    image = rng.integers(0, 256, (height, width, 3)).astype(np.uint8)
    depth = rng.choice([0.3, 20.0, 1e6, np.inf], (height, width)).astype(np.float32)
    colour = tuple(rng.integers(0, 256, 3).tolist())
    weather = Weather(visibility=visibility, vignetting=loss, air=colour)
    rendered = SimpleNamespace(depth=depth)
    shot = post.Shot(weather, SimpleNamespace(camera=SMALL), rendered, 0, 0, (0.0, 0.0))
    left = np.exp(-3.912 * np.minimum(depth, post._haze_depth(SMALL)) / visibility)
    lens = post._vignette(SMALL, loss)
    dimmed = np.rint(image * np.rint(255.0 * left * lens)[..., None] / 255.0)
    own = np.rint(((1.0 - left) * lens)[..., None] * np.array(colour))
    expected = np.minimum(dimmed + own, 255.0)
    apart = np.abs(post.with_air(image, shot) - expected)
    assert apart.max() <= 1.0
    assert (apart > 0.0).mean() < 0.01
