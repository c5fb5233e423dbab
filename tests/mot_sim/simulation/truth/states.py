"""Small worlds, and the stages on which their cars stand."""

import numpy as np

from mot_sim.simulation.cars import VehicleSampler
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.traffic import RecordedTraffic, TrafficState
from mot_sim.simulation.truth import Truth, annotate

RIG = Rig.kitti()
CAR = (4.4, 1.45, 1.8)
EGO = np.zeros(3)
SAMPLER = VehicleSampler(paint="silver")


def state_of(*cars: tuple[float, float, float], size=CAR, time=0.0, speed=0.0) -> TrafficState:
    """Cars at (x, y, heading); we stand at the origin."""
    poses = np.array(cars, dtype=float).reshape(-1, 3)
    n = len(poses)
    return TrafficState(
        time,
        np.arange(n),
        poses[:, 0],
        poses[:, 1],
        poses[:, 2],
        np.full(n, speed),
        np.tile(np.array(size), (n, 1)),
        EGO,
        np.array(CAR),
        kinds=np.full(n, "Car"),
    )


def meshes_of(*states: TrafficState, rig: Rig = RIG) -> SceneMeshes:
    """The cars of worlds before a camera."""
    return SceneMeshes(SAMPLER.sample(RecordedTraffic.of(states), 0), rig)


def truth_of(*states: TrafficState, rig: Rig = RIG) -> Truth:
    """The truth of worlds, a frame each."""
    return annotate(states, meshes_of(*states, rig=rig)).truth
