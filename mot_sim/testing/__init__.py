"""Unit tests of trackers without data sets: seeded episodes, and assertions on scores."""

from mot_sim.experiments.sweep.following import TrackerFailed, follow
from mot_sim.experiments.sweep.seeded_episodes import SeededEpisode, mot_episode
from mot_sim.testing.checking import assert_tracks
from mot_sim.testing.mistakes import Mistake, Mistakes

__all__ = [
    "Mistake",
    "Mistakes",
    "SeededEpisode",
    "TrackerFailed",
    "assert_tracks",
    "follow",
    "mot_episode",
]
