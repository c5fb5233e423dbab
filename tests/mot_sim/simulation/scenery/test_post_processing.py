"""Weather as a post-effect: nothing at neutral, seeded, each knob does what it says."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mot_sim.simulation.camera_looks import find_camera_look
from mot_sim.simulation.renderers import MeshInstances, Rendered, Semantic, View, find_renderer
from mot_sim.simulation.scenery import WEATHERS, Weather, find_weather, post_process
from mot_sim.simulation.scenery.weather import RANGES
from tests.mot_sim.simulation.scenery.places import CAMERA, ego_on, neighbourhood
from tracker.errors import BadConfig, UnknownName


@cache
def street() -> View:
    return neighbourhood("street").view(CAMERA, ego_on("street"), MeshInstances.empty())


@cache
def drawn() -> Rendered:
    return find_renderer("raster").render(street())


def seen(weather: Weather, seed: int = 1, frame: int = 0, view: View | None = None) -> np.ndarray:
    return post_process(weather, view or street(), drawn(), seed, frame, (1.0, 0.02))


def test_neutral_weather_changes_no_byte() -> None:
    image = seen(Weather())
    assert image.tobytes() == drawn().image.tobytes()
    assert image is not drawn().image
    assert find_weather("clear").is_neutral


@pytest.mark.parametrize("name", sorted(WEATHERS))
def test_a_weather_is_the_same_twice_and_leaves_its_input_alone(name: str) -> None:
    before = drawn().image.copy(), drawn().depth.copy()
    one, other = seen(WEATHERS[name], 4, 7), seen(WEATHERS[name], 4, 7)
    assert one.tobytes() == other.tobytes()
    assert one.shape == drawn().image.shape
    assert one.dtype == np.uint8
    assert np.array_equal(drawn().image, before[0])
    assert np.array_equal(drawn().depth, before[1])


@pytest.mark.parametrize("name", ["noise", "rain"])
def test_draws_depend_on_seed_and_frame(name: str) -> None:
    weather = Weather(**{name: 5.0 if name == "noise" else 0.8})
    first = seen(weather, 1, 0)
    assert (first != seen(weather, 2, 0)).any()
    assert (first != seen(weather, 1, 1)).any()


@pytest.mark.parametrize("name", sorted(RANGES))
def test_every_knob_changes_the_picture(name: str) -> None:
    strong = {"visibility": 80.0, "exposure": 1.5, "noise": 5.0, "jpeg": 40.0, "warmth": 0.7}
    weather = (
        Weather(night=1.0, headlights=1.0)
        if name == "headlights"
        else Weather(WEATHERS["low_sun"].light, **{name: strong.get(name, 0.8)})
    )
    other = Weather(night=1.0) if name == "headlights" else Weather()
    view = street()
    if name == "glare":
        view = View(CAMERA, view.instances, view.road, view.sky, weather.light.sun(0.0))
    assert (seen(weather, view=view) != seen(other, view=view)).any()


def test_fog_takes_contrast_with_depth() -> None:
    air = (200, 200, 200)
    foggy = seen(Weather(visibility=60.0, air=air)).astype(float)
    far = (drawn().depth > 120.0) & np.isfinite(drawn().depth)
    near = drawn().depth < 8.0
    assert np.abs(foggy[far] - 200.0).max() <= 2.0
    assert np.abs(foggy[near] - drawn().image[near]).mean() < 50.0


def test_fog_by_hand() -> None:
    image = np.full((375, 1242, 3), 100, np.uint8)
    depth = np.full((375, 1242), 50.0, np.float32)
    nothing = np.full((375, 1242), -1, np.int32)
    flat = Rendered(image, depth, nothing, np.full((375, 1242), Semantic.ROAD, np.uint8))
    foggy = post_process(Weather(visibility=100.0, air=(200, 200, 200)), street(), flat, 1, 0)
    left = np.exp(-3.912 * 0.5)
    assert abs(int(foggy[300, 600, 0]) - (100 * left + 200 * (1.0 - left))) <= 1.0


def test_night_is_dark_but_for_what_glows() -> None:
    dark = seen(Weather(night=1.0, headlights=1.0))
    glowing = drawn().semantics == Semantic.LIGHT
    assert glowing.any()
    assert dark[glowing].mean() > 150.0
    assert dark[:100].mean() < 0.35 * drawn().image[:100].mean()


def test_lamps_shine_on_the_road_before_us() -> None:
    off, on = seen(Weather(night=1.0)), seen(Weather(night=1.0, headlights=1.0))
    assert on[300:, 400:800].mean() > 2.0 * off[300:, 400:800].mean()


def test_without_motion_nothing_is_blurred() -> None:
    weather = Weather(motion_blur=0.5)
    assert post_process(weather, street(), drawn(), 1, 0).tobytes() == drawn().image.tobytes()


def test_an_unknown_weather_is_refused_with_its_neighbour() -> None:
    with pytest.raises(UnknownName, match=r"unknown weather 'nigth'.*Did you mean 'night'"):
        find_weather("nigth")


@pytest.mark.parametrize(
    ("knob", "value"),
    [(name, RANGES[name][0] - 0.5) for name in sorted(RANGES)]
    + [("night", 1.1), ("jpeg", 101.0), ("noise", float("nan"))],
)
def test_a_knob_out_of_range_is_refused(knob: str, value: float) -> None:
    with pytest.raises(BadConfig, match=f"{knob} of the weather is"):
        Weather(**{knob: value})


def test_air_is_a_colour() -> None:
    with pytest.raises(BadConfig, match="air of the weather"):
        Weather(air=(300, 0, 0))


def test_a_look_replaces_the_weathers_own_camera() -> None:
    look = find_camera_look("kitti")
    noisy = replace(WEATHERS["noon"], noise=20.0, vignetting=0.9, jpeg=5.0)
    one, two = (
        post_process(weather, street(), drawn(), 1, 0, (1.0, 0.02), look)
        for weather in (WEATHERS["noon"], noisy)
    )
    assert one.tobytes() == two.tobytes()
    assert one.tobytes() != seen(WEATHERS["noon"]).tobytes()
