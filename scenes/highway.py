"""A highway with three lanes: dense traffic one way, lane changes, long occlusions ahead."""

from mot_sim.simulation.scene import Scene
from scenes.live import live_scene


def highway(
    *,
    cars: int = 50,
    arrivals: float = 1.5,
    alike: float = 0.0,
    wander: float = 1.0,
    bumps: float = 1.0,
    frames: int = 200,
) -> Scene:
    """Three lanes, one way.

    cars: cars that drive at the beginning.
    arrivals: cars per second that enter later, >= 0.
    alike: share of the car models that look the same, 0 to 1.
    wander: how much drivers drift in the lane and vary their speed, >= 0; 1: as people.
    bumps: how much our car pitches and rolls, >= 0; 0: a level ride, 1: as KITTI's car.
    frames: length of the run in frames, at 10 Hz.
    """
    return live_scene("highway", cars, arrivals, frames, alike, wander=wander, bumps=bumps)
