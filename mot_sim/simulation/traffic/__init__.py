"""Traffic: who drives where, in world coordinates, at 10 Hz.

`mot_sim.simulation.traffic.highway` drives cars live; it is not imported here: scripted scenes do
without highway-env.
"""

from mot_sim.simulation.traffic.kitti_replay import kitti_recording, kitti_replay
from mot_sim.simulation.traffic.recording import RecordedTraffic, Replay, record_traffic
from mot_sim.simulation.traffic.roads import Roads, Surface
from mot_sim.simulation.traffic.scripted import Improvised, Route, Script, Scripted
from mot_sim.simulation.traffic.traffic_state import (
    Traffic,
    TrafficState,
    colliding_pairs,
    collisions,
)

__all__ = [
    "Improvised",
    "RecordedTraffic",
    "Replay",
    "Roads",
    "Route",
    "Script",
    "Scripted",
    "Surface",
    "Traffic",
    "TrafficState",
    "colliding_pairs",
    "collisions",
    "kitti_recording",
    "kitti_replay",
    "record_traffic",
]
