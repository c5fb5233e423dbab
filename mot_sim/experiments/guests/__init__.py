"""Other people's trackers on the same detections, through files, in environments of their own."""

from mot_sim.experiments.guests.comparison import Contest, Entry, Failure, hold_contest
from mot_sim.experiments.guests.contestants import (
    BASELINES,
    Contestant,
    GuestTracker,
    Outcome,
    OwnTracker,
    find_contestant,
)
from mot_sim.experiments.guests.environments import Environment
from mot_sim.experiments.guests.failure import GuestFailed
from mot_sim.experiments.guests.live import LiveGuest
from mot_sim.experiments.guests.register import GUESTS, Guest, parse_scores, with_scores

__all__ = [
    "BASELINES",
    "GUESTS",
    "Contest",
    "Contestant",
    "Entry",
    "Environment",
    "Failure",
    "Guest",
    "GuestFailed",
    "GuestTracker",
    "LiveGuest",
    "Outcome",
    "OwnTracker",
    "find_contestant",
    "hold_contest",
    "parse_scores",
    "with_scores",
]
