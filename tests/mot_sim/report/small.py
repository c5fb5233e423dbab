"""A short drive for pictures: we follow two cars before a small camera."""

from functools import cache

import numpy as np

from mot_sim.simulation.episode import Episode, record
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.sensors import Detector
from mot_sim.simulation.traffic import Route, Script, Scripted
from tracker.types import Camera, Tracks

FRAMES = 6
SIZE = (320, 96)
K = np.array([[220.0, 0.0, 160.0], [0.0, 220.0, 44.0], [0.0, 0.0, 1.0]])


def near(*, speed: float = 6.0, frames: int = FRAMES) -> Scene:
    """We follow a car, and pass one that stands on the right."""

    def traffic(models: object) -> Scripted:
        ego = Script(Route([(0.0, 0.0), (90.0, 0.0)]), [(0.0, 6.0)])
        ahead = Script(Route([(11.0, -1.0), (99.0, -1.0)]), [(0.0, speed)])
        parked = Script(Route([(18.0, 3.5), (99.0, 3.5)]), [(0.0, 0.0)])
        return Scripted([ahead, parked], ego)

    rig = Rig(Camera.mounted(K, SIZE, 1.65))
    return Scene("near", traffic, frames, rig=rig, detector=Detector("rrc", misses=0.0))


@cache
def drive(frames: int = FRAMES) -> Episode:
    """The episode, its images drawn when asked for."""
    return record(near(frames=frames), 0, renderer="raster")


def exact_tracks(frames: int = FRAMES, shift: int = 10) -> Tracks:
    """The true boxes of the cars, with ids that differ from the labels' by `shift`."""
    truth = drive(frames).truth
    cars = truth.select(truth.ids >= 0)
    return Tracks(cars.frames, cars.ids + shift, cars.boxes, np.ones(len(cars)))


def one_track(boxes: list[tuple[float, ...]], track_id: int = 3) -> Tracks:
    """A track with a box in each of the frames 0, 1, ..."""
    count = len(boxes)
    return Tracks(np.arange(count), np.full(count, track_id), np.array(boxes), np.ones(count))
