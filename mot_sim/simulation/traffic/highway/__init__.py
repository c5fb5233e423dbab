"""Live traffic by highway-env; the only folder that imports it.

Importing this brings highway_env, pygame, matplotlib and pandas: do so inside a function.
"""

from mot_sim.simulation.traffic.highway.traffic import CRASHES, ROADS, HighwayTraffic

__all__ = ["CRASHES", "ROADS", "HighwayTraffic"]
