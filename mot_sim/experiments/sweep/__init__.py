"""Controlled stress: sweeps over any knob, many seeds, trackers side by side, at any scale."""

from mot_sim.experiments.sweep.design import DESIGNS, Design, Range, read_design
from mot_sim.experiments.sweep.running import sweep
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from tracker.errors import WorkersLost

__all__ = ["DESIGNS", "Design", "Range", "TrackerSpec", "WorkersLost", "read_design", "sweep"]
