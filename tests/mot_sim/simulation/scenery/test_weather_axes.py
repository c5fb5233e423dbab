"""Weather in units: named weathers are points on the axes, contrast falls by Koschmieder's law."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.simulation.camera_looks import PLAIN, find_camera_look
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.renderers import Rendered, Semantic
from mot_sim.simulation.scenery import (
    WEATHERS,
    WeatherAxes,
    contrast_left,
    find_weather,
    post_process,
)
from mot_sim.simulation.scenery.weather_axes import AXIS_RANGES
from tests.mot_sim.simulation.scenery.test_post_processing import drawn, street
from tracker.errors import BadConfig

NOON, KITTI = WEATHERS["noon"], find_camera_look("kitti")


def without_camera(weather: object) -> object:
    return replace(weather, noise=0.0, vignetting=0.0)


def test_zero_everywhere_changes_nothing() -> None:
    for weather in WEATHERS.values():
        assert WeatherAxes()(weather, KITTI) == (weather, KITTI)


@pytest.mark.parametrize(("name", "axes"), [("fog", {"fog": 125.0}), ("rain", {"rain": 16.0})])
def test_named_weathers_are_points_on_the_axes(name: str, axes: dict[str, float]) -> None:
    shifted, _ = WeatherAxes(**axes)(NOON, KITTI)
    named = WEATHERS[name]
    assert shifted.visibility == pytest.approx(named.visibility)
    assert shifted.rain == pytest.approx(named.rain)
    assert shifted.exposure == pytest.approx(named.exposure)
    assert without_camera(shifted) == without_camera(
        replace(named, visibility=shifted.visibility, rain=shifted.rain, exposure=shifted.exposure)
    )


def test_a_sun_as_low_as_low_suns_has_its_light() -> None:
    low = WEATHERS["low_sun"]
    shifted, _ = WeatherAxes(sun_elevation=11.0)(NOON, KITTI)
    for knob in ("warmth", "glare", "air"):
        assert getattr(shifted, knob) == pytest.approx(getattr(low, knob))
    for knob in ("elevation", "ambient", "shade"):
        assert getattr(shifted.light, knob) == pytest.approx(getattr(low.light, knob))
    same, _ = WeatherAxes(sun_elevation=48.0)(NOON, KITTI)
    assert same == NOON


@given(
    st.floats(10.0, 20_000.0), st.floats(0.1, 150.0), st.floats(5.0, 90.0), st.floats(-3.0, 3.0),
    st.sampled_from(sorted(WEATHERS)),
)  # fmt: skip
def test_any_values_in_range_give_a_weather(
    fog: float, rain: float, sun: float, stops: float, name: str
) -> None:
    weather, look = WeatherAxes(fog, rain, sun, stops)(WEATHERS[name], KITTI)
    assert 10.0 <= weather.visibility <= fog
    assert look.exposure.stops == pytest.approx(KITTI.exposure.stops + stops)


@pytest.mark.parametrize("visibility", [50.0, 200.0, 1000.0])
def test_contrast_falls_by_koschmieders_law(visibility: float) -> None:
    depth = 40.0
    image = np.full((375, 1242, 3), 60, np.uint8)
    image[:, 621:] = 180
    nothing = np.full((375, 1242), -1, np.int32)
    road = np.full((375, 1242), Semantic.ROAD, np.uint8)
    flat = Rendered(image, np.full((375, 1242), depth, np.float32), nothing, road)
    weather = replace(find_weather("clear"), visibility=visibility)
    seen = post_process(weather, street(), flat, 1, 0).astype(float)
    left = (seen[300, 900] - seen[300, 300]) / 120.0
    assert left == pytest.approx(contrast_left(depth, visibility), abs=0.01)
    assert contrast_left(visibility, visibility) == pytest.approx(0.02, abs=1e-4)


def test_each_axis_goes_one_way() -> None:
    def picture(**axes: float) -> np.ndarray:
        weather, look = WeatherAxes(**axes)(NOON, PLAIN)
        return post_process(weather, street(), drawn(), 1, 0, look=look).astype(float)

    spreads = [picture(fog=fog).std() for fog in (40.0, 100.0, 300.0, 5000.0)]
    assert spreads == sorted(spreads)
    rains = [WeatherAxes(rain=rate)(NOON, PLAIN)[0] for rate in (0.5, 4.0, 16.0, 60.0)]
    assert [one.rain for one in rains] == sorted(one.rain for one in rains)
    assert [-one.visibility for one in rains] == sorted(-one.visibility for one in rains)
    suns = [WeatherAxes(sun_elevation=one)(NOON, PLAIN)[0].warmth for one in (80, 30, 15, 8)]
    assert suns == sorted(suns)
    means = [picture(exposure=stops).mean() for stops in (-2.0, -0.5, 1.0)]
    assert means == sorted(means)


def test_scenes_take_the_axes_as_knobs_and_keep_their_labels() -> None:
    scene = find_scene("street", weather="night", fog=80.0, exposure=-1.0)
    assert scene.weather.visibility == 80.0
    assert scene.weather.night == 1.0
    assert scene.camera_look.exposure.stops == -1.0
    assert find_scene("street", exposure=1.0, camera_look="plain").weather.exposure == 2.0
    assert find_scene("street", sun_elevation=20.0).weather.light.elevation == 20.0
    assert find_scene("street", rain=8.0).knobs["rain"] == 8.0


@pytest.mark.parametrize("name", sorted(AXIS_RANGES))
def test_a_value_out_of_range_is_refused_with_the_cure(name: str) -> None:
    least, most, unit = AXIS_RANGES[name]
    for value in (least - 0.05, most + 1.0, float("nan")):
        with pytest.raises(BadConfig, match=rf"^{name} = .*: give .* {unit}, or 0 for"):
            WeatherAxes(**{name: value})
        with pytest.raises(BadConfig, match=f"{name} ="):
            find_scene("street", **{name: value})
