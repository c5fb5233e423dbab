"""Numbers and words that no episode has, written with a right checksum, are refused."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy import ndarray as Array

from mot_sim.simulation.episodes import EpisodeFiles, read_episode, record_episode
from mot_sim.simulation.episodes.extra import EPISODE_FORMAT, METADATA, arrays_of, write_extra
from tests.mot_sim.simulation.episodes.small import small
from tracker.errors import BadFile


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A tree with a small episode; its file is written anew by each test."""
    root = tmp_path_factory.mktemp("made")
    record_episode(small(frames=3), 3, EpisodeFiles(root, "0000"))
    (root / "kept.npz").write_bytes(EpisodeFiles(root, "0000").extra.read_bytes())
    return root


def forge(root: Path, **changed: Array) -> None:
    """Write the episode's file with some arrays changed, and the checksum of what is there."""
    extra = EpisodeFiles(root, "0000").extra
    extra.write_bytes((root / "kept.npz").read_bytes())
    stored = read_episode(root)
    write_extra(extra, stored.metadata, arrays_of(stored) | changed)


@pytest.mark.parametrize(
    ("name", "array", "told"),
    [
        ("traffic.ego", np.full((3, 3), np.nan), "traffic.ego holds a number that is not finite"),
        ("traffic.ego", np.full((3, 3), 1e300), "traffic.ego holds a number that is not finite"),
        ("traffic.ego", np.zeros((3, 4)), "traffic.ego is float64 of shape (3, 4), not"),
        ("traffic.x", np.zeros((3, 9)), "traffic.x is float64 of shape (3, 9), not"),
        ("traffic.ids", np.zeros(2), "traffic.ids is float64 of shape (2,), not"),
        ("vehicles.kinds", np.zeros(2), "vehicles.kinds is float64 of shape (2,), not"),
        ("log.frames", np.array([1, 0]), "log."),
        ("camera.K", np.zeros((2, 2)), "camera.K is"),
        ("camera.image_size", np.array([1.5, 2.0]), "camera.image_size is"),
        ("camera.K", np.zeros((3, 3)), "K is singular"),
        ("events.frames", np.array([10**6]), "events."),
    ],
)
def test_a_forged_table_is_refused(made: Path, name: str, array: Array, told: str) -> None:
    forge(made, **{name: array})
    with pytest.raises(BadFile, match=re.escape(told)) as error:
        read_episode(made)
    assert "0000.npz" in str(error.value)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"frames": 10**9}, "1000000000 frames of 3 states"),
        ({"frames": "x"}, "frames is 'x'"),
        ({"seed": -1}, "seed -1"),
        ({"seed": True}, "seed is True"),
        ({"knobs": {"a": []}}, "knobs {'a': []}"),
        ({"pictures": ["../../x"]}, "pictures ['../../x']; known: images"),
        ({"sha256": {"labels": 3}}, "a version or a hash that is no word"),
        ({"scene": None}, "scene is None"),
    ],
)
def test_forged_metadata_are_refused(made: Path, changes: dict[str, Any], told: str) -> None:
    forge(made)
    extra = EpisodeFiles(made, "0000").extra
    arrays = arrays_of(read_episode(made))
    with np.load(extra, allow_pickle=False) as archive:
        about = json.loads(str(archive[METADATA]))
    EPISODE_FORMAT.write(extra, {METADATA: np.array(json.dumps(about | changes)), **arrays})
    with pytest.raises(BadFile, match=re.escape(told)):
        read_episode(made)


def test_frames_out_of_order_are_refused(made: Path) -> None:
    forge(made)
    frames = read_episode(made).exact.tracks.frames
    assert len(set(frames.tolist())) > 1
    forge(made, **{"truth.tracks.frames": frames[::-1].copy()})
    with pytest.raises(BadFile, match=r"truth\.tracks\.frames is not in order"):
        read_episode(made)
