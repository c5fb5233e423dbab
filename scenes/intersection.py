"""A four-way intersection: cars cross, turn, wait for one another and hide behind parked vans."""

from mot_sim.simulation.scene import Scene
from scenes.live import live_scene


def intersection(
    *,
    cars: int = 26,
    arrivals: float = 1.4,
    parked: float = 0.8,
    vans: int = 8,
    alike: float = 0.0,
    frames: int = 200,
) -> Scene:
    """Four arms, one lane each way, with rows of parked cars.

    cars: driving at the beginning. arrivals: cars a second that come later. parked: share of
    the kerb's places that are taken. vans: parked where they hide the most. alike: share of
    the models of cars that look the same. frames: at 10 Hz.
    """
    return live_scene("intersection", cars, arrivals, frames, alike, parked, vans)
