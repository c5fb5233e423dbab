"""Fog and rain of a detector in units: the named weathers are points on them."""

import pytest

from mot_sim.simulation.sensors import find_profile, in_fog_and_rain, in_weather
from mot_sim.simulation.sensors.profile import WEATHERS
from mot_sim.simulation.sensors.weather_strength import weather_of_strength

RRC = find_profile("rrc")


def test_none_changes_nothing_and_the_named_weathers_are_points() -> None:
    assert in_fog_and_rain(RRC, 0.0, 0.0) == RRC
    assert in_fog_and_rain(RRC, 125.0, 0.0) == in_weather(RRC, "fog")
    assert in_fog_and_rain(RRC, 0.0, 16.0) == in_weather(RRC, "rain")


@pytest.mark.parametrize("name", ["fog", "rain"])
def test_stronger_weather_loses_more_far_cars(name: str) -> None:
    weathers = [weather_of_strength(name, strength) for strength in (0.0, 0.3, 1.0, 4.0)]
    assert weathers[2] == WEATHERS[name]
    found = [weather(RRC).misses.by_height[0] for weather in weathers]
    assert found == sorted(found, reverse=True)
