"""Live traffic by highway-env; the only folder that imports it."""

from mot_sim.simulation.traffic.highway.parts import load_parts

load_parts()  # before any of our modules here imports them

from mot_sim.simulation.traffic.highway.traffic import (  # noqa: E402
    CRASHES,
    ROADS,
    HighwayTraffic,
)

__all__ = ["CRASHES", "ROADS", "HighwayTraffic"]
