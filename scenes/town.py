"""A town: our car drives a route of minutes past junctions, bends and a few parked cars."""

from mot_sim.simulation.scene import Scene
from scenes.live import live_scene


def town(
    *,
    cars: int = 40,
    arrivals: float = 0.25,
    parked: float = 0.8,
    vans: int = 2,
    route: str = "any",
    wander: float = 1.0,
    bumps: float = 1.0,
    alike: float = 0.0,
    frames: int = 300,
) -> Scene:
    """Nine junctions with give-way lines, and streets with bends.

    cars: cars that drive at the beginning.
    arrivals: cars per second that enter later, >= 0.
    parked: share of the parking places at the kerb that are taken, 0 to 1; streets differ.
    vans: vans parked where they hide the most.
    route: of our car: loop, old_town, shore or errands; any: drawn by the seed.
    wander: how much drivers drift in the lane and vary their speed, >= 0; 1: as people.
    bumps: how much our car pitches and rolls, >= 0; 0: a level ride, 1: as KITTI's car.
    alike: share of the car models that look the same, 0 to 1.
    frames: length of the run in frames, at 10 Hz; a route lasts for 1,500 or more.
    """
    amounts = "town", cars, arrivals, frames, alike, parked, vans
    return live_scene(*amounts, route=route, wander=wander, bumps=bumps)
