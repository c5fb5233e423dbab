"""Noise on exact truth or labels, one file an effect: functions over arrays, level 0 = exact."""

from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals
from mot_sim.simulation.sensors.detector import Detector, Provenance, Sensed
from mot_sim.simulation.sensors.ego import Miscalibration, Odometry
from mot_sim.simulation.sensors.profile import (
    EFFECTS,
    PROFILES,
    WEATHERS,
    Profile,
    find_profile,
    in_weather,
)
from mot_sim.simulation.sensors.sightings import Sightings
from mot_sim.simulation.sensors.timing import Timed, Timing
from mot_sim.simulation.sensors.weather_strength import in_fog_and_rain

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
    "in_fog_and_rain",
    "in_weather",
]
