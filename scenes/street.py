"""A two-way street between rows of parked cars: oncoming traffic, standing cars close by."""

from mot_sim.simulation.scene import Scene
from scenes.live import live_scene


def street(
    *,
    cars: int = 14,
    arrivals: float = 0.6,
    parked: float = 0.8,
    vans: int = 3,
    bends: bool = True,
    alike: float = 0.0,
    wander: float = 1.0,
    bumps: float = 1.0,
    frames: int = 200,
) -> Scene:
    """One lane each way, 500 m, with bends and corners; cars parked on both sides.

    cars: cars that drive at the beginning.
    arrivals: cars per second that enter later, >= 0.
    parked: share of the parking places at the kerb that are taken, 0 to 1.
    vans: vans parked where they hide the most.
    bends: whether the street bends, and turns two corners; without, it is straight.
    alike: share of the car models that look the same, 0 to 1.
    wander: how much drivers drift in the lane and vary their speed, >= 0; 1: as people.
    bumps: how much our car pitches and rolls, >= 0; 0: a level ride, 1: as KITTI's car.
    frames: length of the run in frames, at 10 Hz.
    """
    road = "bent_street" if bends else "street"
    amounts = "street", cars, arrivals, frames, alike, parked, vans
    return live_scene(*amounts, road=road, wander=wander, bumps=bumps)
