"""The world around the cars: painted ground, scenery, sky, light, weather.

weather = find_weather("rain")
world = Neighbourhood.build(roads, seed, weather.light)
view = world.view(camera, ego, cars)
image = post_process(weather, view, renderer.render(view), seed, frame)
"""

from mot_sim.simulation.scenery.knobs import Knobs
from mot_sim.simulation.scenery.light import Light
from mot_sim.simulation.scenery.neighbourhood import Neighbourhood
from mot_sim.simulation.scenery.post_processing import post_process
from mot_sim.simulation.scenery.scenery import Scenery
from mot_sim.simulation.scenery.weather import WEATHERS, Weather, find_weather

__all__ = [
    "WEATHERS", "Knobs", "Light", "Neighbourhood", "Scenery", "Weather", "find_weather", "post_process",
]  # fmt: skip
