"""An intersection between houses: crossing traffic is hidden until it is very near."""

from dataclasses import replace
from itertools import product
from math import pi

from mot_sim.simulation.scene import Scene
from mot_sim.simulation.traffic.roads import Plot
from scenes.junction import LANE_METRES, require_between
from scenes.live import live_scene

MIN_SETBACK_METRES = 2.8  # the corners of the asphalt are cut for cars that turn right


def intersection_blind_corner(
    *,
    setback: float = 3.0,
    cars: int = 14,
    arrivals: float = 0.9,
    parked: float = 0.3,
    vans: int = 0,
    alike: float = 0.0,
    wander: float = 0.0,
    bumps: float = 0.0,
    frames: int = 200,
) -> Scene:
    """Four arms, one lane each way, a house at every corner.

    setback: metres from the asphalt to the houses, 2.8 to 15; less: cars are hidden for longer.
    cars: cars that drive at the beginning.
    arrivals: cars per second that enter later, >= 0.
    parked: share of the parking places at the kerb that are taken, 0 to 1.
    vans: vans parked where they hide the most.
    alike: share of the car models that look the same, 0 to 1.
    wander: how much drivers drift in the lane and vary their speed, >= 0; 1: as people.
    bumps: how much our car pitches and rolls, >= 0; 0: a level ride, 1: as KITTI's car.
    frames: length of the run in frames, at 10 Hz.
    """
    name = "intersection_blind_corner"
    require_between(name, setback=(setback, MIN_SETBACK_METRES, 15.0))
    amounts = name, cars, arrivals, frames, alike, parked, vans
    scene = live_scene(*amounts, road="intersection", wander=wander, bumps=bumps)
    away = LANE_METRES + setback
    plots = tuple(
        Plot((x * away, y * away), 0.0 if x > 0.0 else pi, (x > 0.0) == (y > 0.0))
        for x, y in product((-1.0, 1.0), repeat=2)
    )
    return replace(scene, roads=replace(scene.roads, plots=plots))
