"""A highway with a ramp that joins it: cars change to the left before their lane ends."""

from mot_sim.simulation.scene import Scene
from scenes.live import live_scene


def merge(*, cars: int = 30, arrivals: float = 1.0, alike: float = 0.0, frames: int = 200) -> Scene:
    """Two lanes and a ramp.

    cars: driving at the beginning. arrivals: cars a second that come later. alike: share of
    the models of cars that look the same. frames: at 10 Hz.
    """
    return live_scene("merge", cars, arrivals, frames, alike)
