"""Controlled stress: sweeps over any knob, many seeds, trackers side by side, at any scale."""

from mot_sim.experiments.contenders import Contender
from mot_sim.experiments.crew import WorkersLost
from mot_sim.experiments.design import Design, Range
from mot_sim.experiments.design_files import DESIGNS, read_design
from mot_sim.experiments.sweep import sweep

__all__ = ["DESIGNS", "Contender", "Design", "Range", "WorkersLost", "read_design", "sweep"]
