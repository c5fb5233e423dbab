"""A highway with a ramp that joins it: cars change to the left before their lane ends."""

from mot_sim.simulation.scene import Scene
from scenes.live import live_scene


def merge(
    *,
    cars: int = 30,
    arrivals: float = 1.0,
    alike: float = 0.0,
    wander: float = 0.0,
    bumps: float = 0.0,
    frames: int = 200,
) -> Scene:
    """Two lanes and a ramp.

    cars: cars that drive at the beginning.
    arrivals: cars per second that enter later, >= 0.
    alike: share of the car models that look the same, 0 to 1.
    wander: how much drivers drift in the lane and vary their speed, >= 0; 1: as people.
    bumps: how much our car pitches and rolls, >= 0; 0: a level ride, 1: as KITTI's car.
    frames: length of the run in frames, at 10 Hz.
    """
    return live_scene("merge", cars, arrivals, frames, alike, wander=wander, bumps=bumps)
