"""A roundabout with one lane and four arms: curved ways, every heading, rows of parked cars."""

from mot_sim.simulation.scene import Scene
from scenes.live import live_scene


def roundabout(
    *,
    cars: int = 28,
    arrivals: float = 1.6,
    parked: float = 1.0,
    vans: int = 14,
    alike: float = 0.0,
    frames: int = 200,
) -> Scene:
    """Cars enter a ring, go round it and leave; who enters gives way.

    cars: driving at the beginning. arrivals: cars a second that come later. parked: share
    of the kerb's places that are taken. vans: parked where they hide the most. alike: share
    of the models of cars that look the same. frames: at 10 Hz.
    """
    return live_scene("roundabout", cars, arrivals, frames, alike, parked, vans)
