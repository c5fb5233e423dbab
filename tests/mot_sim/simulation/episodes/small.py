"""A scene of few frames before a small camera, quick to record."""

import numpy as np

from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.sensors import Detector
from mot_sim.simulation.traffic import Route, Script, Scripted
from tracker.types import Camera

FRAMES = 6
K = np.array([[110.0, 0.0, 80.0], [0.0, 110.0, 22.0], [0.0, 0.0, 1.0]])


def rig(pitch: float = 0.0, roll: float = 0.0) -> Rig:
    """160 x 48 pixels."""
    return Rig(Camera.mounted(K, (160, 48), 1.65, pitch, roll))


def small(
    *, speed: float = 6.0, pitch: float = 0.0, roll: float = 0.0, frames: int = FRAMES
) -> Scene:
    """We turn right behind two cars, one of which drives away to the left."""

    def traffic(models: object) -> Scripted:
        ego = Script(Route([(0.0, 0.0), (4.0, 0.0), (4.0, 60.0)]), [(0.0, 6.0)])
        ahead = Script(Route([(12.0, 0.0), (99.0, 0.0)]), [(0.0, speed)])
        away = Script(Route([(16.0, -1.0), (16.0, -60.0)]), [(0.0, 9.0)], begin=0.1)
        return Scripted([ahead, away], ego)

    return Scene(
        "small", traffic, frames, rig=rig(pitch, roll), detector=Detector("rrc", misses=0.3)
    )
