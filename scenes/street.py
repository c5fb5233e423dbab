"""A two-way street between rows of parked cars: oncoming traffic, standing cars close by."""

from mot_sim.simulation.scene import Scene
from scenes.live import live_scene


def street(
    *,
    cars: int = 14,
    arrivals: float = 0.6,
    parked: float = 0.8,
    vans: int = 3,
    alike: float = 0.0,
    frames: int = 200,
) -> Scene:
    """One lane each way, 500 m, cars parked on both sides.

    cars: driving at the beginning. arrivals: cars a second that come later. parked: share
    of the kerb's places that are taken. vans: parked where they hide the most. alike: share
    of the models of cars that look the same. frames: at 10 Hz.
    """
    return live_scene("street", cars, arrivals, frames, alike, parked, vans)
