"""Worlds for tests: one neighbourhood a road, built once, and ego poses in it."""

from functools import cache

import numpy as np

from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scenery import WEATHERS, Neighbourhood
from mot_sim.simulation.traffic import Roads
from mot_sim.simulation.traffic.highway.paint import roads_of

CAMERA = Rig.kitti().camera
EGOS = {
    "highway": (180.0, 3.5, 0.0),
    "intersection": (-45.0, 1.75, 0.0),
    "merge": (100.0, 3.5, 0.0),
    "roundabout": (-55.0, 1.75, 0.0),
    "street": (60.0, 1.75, 0.0),
}


def ego_on(road: str) -> np.ndarray:
    return np.array(EGOS[road])


@cache
def roads(road: str) -> Roads:
    """The part of a road around the ego: a smaller world is built sooner."""
    whole, (x, y, _) = roads_of(road), EGOS[road]
    near = [s for s in whole.surfaces if np.hypot(*(s.corners.mean(axis=0) - (x + 30.0, y))) < 60.0]
    return Roads(tuple(near), whole.lanes)


@cache
def neighbourhood(road: str, seed: int = 3) -> Neighbourhood:
    return Neighbourhood.build(roads(road), seed, WEATHERS["noon"].light)
