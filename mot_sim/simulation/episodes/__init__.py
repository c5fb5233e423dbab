"""Episodes as KITTI trees: recorded, read back with their exact truth, and verified."""

from mot_sim.simulation.episodes.folder import EpisodeFolder, record_episodes
from mot_sim.simulation.episodes.pictures import read_depth
from mot_sim.simulation.episodes.places import PICTURES, TEXTS, EpisodeFiles, stored_episodes
from mot_sim.simulation.episodes.reading import StoredEpisode, read_episode
from mot_sim.simulation.episodes.recording import PictureOptions, record_episode
from mot_sim.simulation.episodes.verification import (
    EpisodeVerification,
    verify_episode,
    verify_tree,
)

__all__ = [
    "PICTURES",
    "TEXTS",
    "EpisodeFiles",
    "EpisodeFolder",
    "EpisodeVerification",
    "PictureOptions",
    "StoredEpisode",
    "read_depth",
    "read_episode",
    "record_episode",
    "record_episodes",
    "stored_episodes",
    "verify_episode",
    "verify_tree",
]
