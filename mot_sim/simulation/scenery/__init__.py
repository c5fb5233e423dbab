"""The world around the cars: painted ground, scenery, sky, light, weather.

weather = find_weather("rain")
neighbourhood = Neighbourhood.build(roads, seed, weather.light)
view = neighbourhood.view(camera, ego, cars)
image = post_process(weather, view, renderer.render(view), seed, frame)
"""

from mot_sim.simulation.scenery.culling import Spheres
from mot_sim.simulation.scenery.neighbourhood import Neighbourhood
from mot_sim.simulation.scenery.placing import Knobs
from mot_sim.simulation.scenery.post_processing import post_process
from mot_sim.simulation.scenery.scenery import Scenery
from mot_sim.simulation.scenery.weather import WEATHERS, Light, Weather, find_weather
from mot_sim.simulation.scenery.weather_axes import WeatherAxes, contrast_left

__all__ = [
    "WEATHERS",
    "Knobs",
    "Light",
    "Neighbourhood",
    "Scenery",
    "Spheres",
    "Weather",
    "WeatherAxes",
    "contrast_left",
    "find_weather",
    "post_process",
]
