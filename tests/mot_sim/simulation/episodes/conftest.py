"""An episode of the small scene, recorded once with all its pictures."""

from collections.abc import Callable
from pathlib import Path

import pytest

from mot_sim.simulation.episodes import PICTURES, EpisodeFiles, PictureOptions, record_episode
from tests.mot_sim.simulation.episodes.small import small

SEED = 3
ALL = PictureOptions(tuple(PICTURES))


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The root of a tree with the episode 0000; not to be changed."""
    root = tmp_path_factory.mktemp("recorded")
    record_episode(small(), SEED, EpisodeFiles(root, "0000"), ALL)
    return root


@pytest.fixture
def interrupt_after() -> Callable[[int], Callable[[], None]]:
    """Gives a progress function, during whose call Ctrl-C comes after so many frames."""

    def make(frames: int) -> Callable[[], None]:
        left = [frames]

        def progress() -> None:
            left[0] -= 1
            if left[0] <= 0:
                raise KeyboardInterrupt

        return progress

    return make


def contents(root: Path) -> dict[str, bytes]:
    """Every file below a folder."""
    return {
        str(path.relative_to(root)): path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file()
    }
