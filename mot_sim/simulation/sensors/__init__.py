"""Noise on exact truth or labels, one file an effect: functions over arrays, level 0 = exact."""

from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals
from mot_sim.simulation.sensors.detector import Detector
from mot_sim.simulation.sensors.miscalibration import Miscalibration
from mot_sim.simulation.sensors.odometry import Odometry
from mot_sim.simulation.sensors.profile import EFFECTS, PROFILES, Profile, find_profile
from mot_sim.simulation.sensors.provenance import Provenance, Sensed
from mot_sim.simulation.sensors.sightings import Sightings
from mot_sim.simulation.sensors.timing import Timed, Timing
from mot_sim.simulation.sensors.weather import WEATHERS, in_weather

__all__ = [
    "EFFECTS",
    "PROFILES",
    "WEATHERS",
    "Autocorrelation",
    "Detector",
    "Miscalibration",
    "Odometry",
    "Profile",
    "Provenance",
    "Sensed",
    "Sightings",
    "Timed",
    "Timing",
    "correlated_normals",
    "find_profile",
    "in_weather",
]
