"""Traffic: who drives where, in world coordinates, at 10 Hz."""

from mot_sim.traffic.roads import Roads, Surface
from mot_sim.traffic.scripted import Route, Script, Scripted
from mot_sim.traffic.world import Traffic, World

__all__ = ["Roads", "Route", "Script", "Scripted", "Surface", "Traffic", "World"]
