"""Verifying episodes: whole ones pass, and every change is named."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mot_sim.simulation.episodes import (
    EpisodeFiles,
    record_episode,
    recording,
    verify_episode,
    verify_tree,
)
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.truth import Annotations
from tests.mot_sim.simulation.episodes.conftest import SEED
from tests.mot_sim.simulation.episodes.small import FRAMES, small
from tracker.errors import DatasetNotFound, UnknownName


def find(name: str, **knobs: object) -> Scene:
    """The scene of the recording."""
    assert name == "small"
    return small(**knobs)


@pytest.fixture
def tree(recorded: Path, tmp_path: Path) -> Path:
    """A copy that may be changed."""
    return Path(shutil.copytree(recorded, tmp_path / "tree"))


def flip(path: Path) -> None:
    """Change one byte in the middle."""
    whole = bytearray(path.read_bytes())
    whole[len(whole) // 2] ^= 1
    path.write_bytes(whole)


def test_what_was_recorded_is_the_same(recorded: Path) -> None:
    (found,) = verify_tree(recorded, find, pictures=True)
    assert found.is_same
    assert found.frames == FRAMES
    assert {"labels", "detections", "trajectories", "images", "depth"} < found.parts.keys()
    assert found.verdict("pictures") == "same"
    assert verify_episode(recorded, "0000", find).verdict("pictures") == "-"


@pytest.mark.parametrize(
    ("part", "group"),
    [
        ("labels", "labels"),
        ("detections", "detections"),
        ("exact detections", "detections"),
        ("oxts", "trajectories"),
        ("odometry", "trajectories"),
        ("calibration", "trajectories"),
    ],
)
def test_a_changed_byte_is_named(tree: Path, part: str, group: str) -> None:
    flip(EpisodeFiles(tree, "0000").text(part))
    found = verify_episode(tree, "0000", find)
    assert not found.is_same
    assert found.verdict(group) == f"{part}: file changed"
    assert sum(what != "same" for what in found.parts.values()) == 1


def test_a_missing_file_is_named(tree: Path) -> None:
    EpisodeFiles(tree, "0000").text("labels").unlink()
    assert verify_episode(tree, "0000", find).parts["labels"] == "file missing"


def test_changed_pictures_are_found_when_asked_for(tree: Path) -> None:
    places = EpisodeFiles(tree, "0000")
    shutil.copy(places.picture("images", 1), places.picture("images", 2))
    places.picture("depth", 3).unlink()
    assert verify_episode(tree, "0000", find).is_same
    found = verify_episode(tree, "0000", find, pictures=True)
    assert found.parts["images"] == "files changed"
    assert "000003.png: no such picture" in found.parts["depth"]
    assert found.parts["instances"] == "same"


def test_a_damaged_extra_file_keeps_nobody_else_from_the_check(tree: Path) -> None:
    record_episode(small(), SEED, EpisodeFiles(tree, "0001"))
    flip(EpisodeFiles(tree, "0000").extra)
    bad, good = verify_tree(tree, find)
    assert bad.trouble is not None
    assert "record again" in bad.trouble
    assert good.is_same


def test_a_scene_that_runs_differently_now_is_found(recorded: Path) -> None:
    found = verify_episode(recorded, "0000", lambda name: small(speed=7.0))
    assert not found.is_same
    assert found.parts["labels"] == found.parts["trajectories"] == "a new run differs"
    assert found.parts["calibration"] == "same"


def test_a_scene_that_is_gone_is_told(recorded: Path) -> None:
    def gone(name: str) -> Scene:
        raise UnknownName.of("scene", name, ["crossing"])

    found = verify_episode(recorded, "0000", gone)
    assert not found.is_same
    assert found.trouble == "cannot be run again: unknown scene 'small'; known: crossing"


def test_a_shorter_episode_passes(
    tmp_path: Path, interrupt_after: Callable[[int], Callable[[], None]]
) -> None:
    with pytest.raises(KeyboardInterrupt):
        record_episode(small(), SEED, EpisodeFiles(tmp_path, "0000"), progress=interrupt_after(3))
    found = verify_episode(tmp_path, "0000", find)
    assert (found.is_same, found.frames) == (True, 3)


def test_a_half_made_episode_is_told(tree: Path) -> None:
    (tree / "episodes.json").write_text("{}")
    EpisodeFiles(tree, "0000").extra.unlink()
    (found,) = verify_tree(tree, find)
    assert found.trouble is not None
    assert found.trouble.startswith("half-made")


def test_a_tree_without_episodes_is_told(tmp_path: Path) -> None:
    (tmp_path / "training" / "calib").mkdir(parents=True)
    (tmp_path / "training" / "calib" / "0000.txt").write_text("")
    with pytest.raises(DatasetNotFound, match="no episodes in it; mot-sim record makes some"):
        verify_tree(tmp_path, find)


def nudged(monkeypatch: pytest.MonkeyPatch, by: float) -> None:
    """From now on a new run sees boxes that are off by so many pixels, as on another CPU."""
    original = recording.annotate_frame

    def annotate_frame(*arguments: Any) -> Annotations:
        seen = original(*arguments)
        tracks = seen.truth.tracks
        moved = seen.truth.replaced(tracks=tracks.replaced(boxes=tracks.boxes + by))
        return replace(seen, truth=moved)

    monkeypatch.setattr(recording, "annotate_frame", annotate_frame)


def test_another_rounding_of_the_last_bits_is_the_same_to_the_printed_digits(
    recorded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    nudged(monkeypatch, 1e-9)
    found = verify_episode(recorded, "0000", find)
    assert found.is_same
    assert not found.is_bit_equal
    assert found.parts["truth"] == found.verdict("labels") == "same to the printed digits"
    assert found.verdict("trajectories") == "same"


def test_another_printed_digit_is_a_difference(
    recorded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    nudged(monkeypatch, 1e-5)
    found = verify_episode(recorded, "0000", find)
    assert not found.is_same
    assert found.parts["truth"] == found.parts["exact detections"] == "a new run differs"
