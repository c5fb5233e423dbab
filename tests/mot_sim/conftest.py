"""One small episode for all tests that only look."""

from pathlib import Path

import pytest

from mot_sim.testing import SeededEpisode
from mot_sim.testing import mot_episode as made

BARE = {"houses": 0.0, "trees": 0.0, "furniture": 0.0}


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the truths of these tests lie."""
    return tmp_path_factory.mktemp("episodes")


@pytest.fixture(scope="session")
def episode(cache: Path) -> SeededEpisode:
    """An open crossing, 12 frames, with a bad detector."""
    return made("crossing", 1, frames=12, cache=cache, **BARE, **{"detector.jitter": 2.0})
