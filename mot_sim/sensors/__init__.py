"""Noise on exact truth, one file an effect: pure functions over arrays, level 0 = exact."""

from mot_sim.sensors.detector import Detector
from mot_sim.sensors.jitter import jitter_boxes
from mot_sim.sensors.misses import miss_probability, missed
from mot_sim.sensors.scores import confidence

__all__ = ["Detector", "confidence", "jitter_boxes", "miss_probability", "missed"]
