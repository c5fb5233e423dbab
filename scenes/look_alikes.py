"""A convoy of look-alikes: dense traffic of one shape and one paint, so that only motion tells."""

from mot_sim.simulation.scene import Scene
from scenes.live import live_scene


def look_alikes(
    *,
    cars: int = 54,
    arrivals: float = 1.5,
    alike: float = 1.0,
    models: int = 12,
    wander: float = 0.0,
    bumps: float = 0.0,
    frames: int = 200,
) -> Scene:
    """A highway full of cars that look the same.

    cars: cars that drive at the beginning.
    arrivals: cars per second that enter later, >= 0.
    alike: share of the car models that look the same, 0 to 1.
    models: number of car models that the cars are drawn from, 1 or more.
    wander: how much drivers drift in the lane and vary their speed, >= 0; 1: as people.
    bumps: how much our car pitches and rolls, >= 0; 0: a level ride, 1: as KITTI's car.
    frames: length of the run in frames, at 10 Hz.
    """
    return live_scene(
        "look_alikes",
        cars,
        arrivals,
        frames,
        alike,
        road="highway",
        models=models,
        wander=wander,
        bumps=bumps,
    )
