"""Other people's trackers on the same detections, through files, in environments of their own."""

from mot_sim.experiments.guests.comparison import Comparison, Entry, Failure, run_comparison
from mot_sim.experiments.guests.sequence_trackers import (
    BASELINES,
    ExternalSequenceTracker,
    OwnTracker,
    SequenceTracker,
    TrackedSequences,
    find_sequence_tracker,
)
from mot_sim.foreign.environments import Environment
from mot_sim.foreign.failure import ExternalTrackerFailed
from mot_sim.foreign.live import ExternalOnlineTracker
from mot_sim.foreign.register import GUESTS, ExternalTracker, parse_scores, with_scores

__all__ = [
    "BASELINES",
    "GUESTS",
    "Comparison",
    "Entry",
    "Environment",
    "ExternalOnlineTracker",
    "ExternalSequenceTracker",
    "ExternalTracker",
    "ExternalTrackerFailed",
    "Failure",
    "OwnTracker",
    "SequenceTracker",
    "TrackedSequences",
    "find_sequence_tracker",
    "parse_scores",
    "run_comparison",
    "with_scores",
]
