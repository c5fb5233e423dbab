"""The pytest plugin: fixtures `mot_episode` and `assert_tracks`.

It stands beside the packages, not in one: pytest loads it at every start, when a package that it
brought along could no longer be watched by other plugins (coverage, jaxtyping), and would cost a
second. What the fixtures need is imported when a test asks for them.
"""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from mot_sim.testing import SeededEpisode


@pytest.fixture(scope="session")
def mot_episode(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> "Callable[..., SeededEpisode]":
    """mot_episode("intersection", seed=3, profile="rrc", frames=50, **knobs): an episode.

    It has `frames` (what a tracker is given), `truth` and `camera`; see
    `mot_sim.testing.mot_episode`. Recordings stay in pytest's cache from run to run; with
    `-p no:cacheprovider` they last for one run.
    """
    from mot_sim.testing import mot_episode as made

    kept = getattr(request.config, "cache", None)
    folder = tmp_path_factory.mktemp("mot-sim") if kept is None else kept.mkdir("mot-sim")
    return partial(made, cache=folder)


@pytest.fixture(scope="session")
def assert_tracks() -> "Callable[..., object]":
    """assert_tracks(tracker, episode, mota=0.8, idsw=2); see `mot_sim.testing.assert_tracks`."""
    from mot_sim.testing import assert_tracks as checked

    return checked
