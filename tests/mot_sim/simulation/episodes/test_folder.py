"""Folders of episodes: what is refused, resumed, replaced and taken back."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from mot_sim.simulation.episodes import (
    EpisodeFiles,
    EpisodeFolder,
    PictureOptions,
    read_episode,
    record_episodes,
)
from tests.mot_sim.simulation.episodes.conftest import contents
from tests.mot_sim.simulation.episodes.small import FRAMES, small
from tracker.errors import BadConfig, BadFile, BadOutput, OutputExists

SETTINGS = {"scene": "small", "seed": 3}
IMAGES = PictureOptions(("images",))


def open_folder(path: Path, **more: bool) -> EpisodeFolder:
    """For two episodes."""
    return EpisodeFolder.open(path, SETTINGS, 2, FRAMES, **more)


def test_episodes_have_neighbouring_seeds(tmp_path: Path) -> None:
    done: list[str] = []
    record_episodes(small(), 3, open_folder(tmp_path / "out"), IMAGES, done.append)
    assert done == ["0000"] * FRAMES + ["0001"] * FRAMES
    seeds = [read_episode(tmp_path / "out", name).seed for name in ("0000", "0001")]
    assert seeds == [3, 4]
    told = json.loads((tmp_path / "out" / "episodes.json").read_text())
    assert told["complete"] is True
    assert told["settings"] == SETTINGS
    assert told["episodes"] == ["0000", "0001"]


def test_an_interrupted_recording_is_resumed_to_the_same_files(
    tmp_path: Path, interrupt_after: Callable[[int], Callable[[], None]]
) -> None:
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    record_episodes(small(), 3, open_folder(whole), IMAGES)
    interrupt = interrupt_after(FRAMES + 2)
    with pytest.raises(KeyboardInterrupt):
        record_episodes(small(), 3, open_folder(broken), IMAGES, lambda _: interrupt())
    assert json.loads((broken / "episodes.json").read_text())["complete"] is False
    assert [read_episode(broken, name).frame_count for name in ("0000", "0001")] == [FRAMES, 2]
    again = open_folder(broken, resume=True)
    assert again.missing == ("0001",)  # too short
    record_episodes(small(), 3, again, IMAGES)
    assert contents(broken) == contents(whole)


def test_what_a_killed_process_left_is_done_again(tmp_path: Path) -> None:
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    for root in (whole, killed):
        record_episodes(small(), 3, open_folder(root), IMAGES)
    places = EpisodeFiles(killed, "0001")
    places.extra.unlink()  # it comes last
    places.text("labels").write_text("0 1 Car")
    (places.pictures("images") / ".000002.png.77.half").write_bytes(b"half")
    (places.text("oxts").parent / ".0001.txt.77.half").write_bytes(b"half")
    damaged = EpisodeFiles(killed, "0000").extra
    damaged.write_bytes(damaged.read_bytes()[:500])
    again = open_folder(killed, resume=True)
    assert again.missing == ("0000", "0001")
    record_episodes(small(), 3, again, IMAGES)
    assert contents(killed) == contents(whole)


def test_overwrite_replaces_all_episodes_and_nothing_else(tmp_path: Path) -> None:
    record_episodes(small(), 3, open_folder(tmp_path), IMAGES)
    (tmp_path / "training" / "mine.txt").write_text("mine")
    folder = EpisodeFolder.open(tmp_path, {"scene": "other"}, 1, FRAMES, overwrite=True)
    assert len(contents(tmp_path)) > 20
    record_episodes(small(), 9, folder)
    left = contents(tmp_path)
    assert not [name for name in left if "0001" in name or name.endswith(".png")]
    assert "training/mine.txt" in left


def test_folders_of_others_are_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("")
    for more in ({}, {"overwrite": True}, {"resume": True}):
        with pytest.raises(OutputExists, match="not empty, and no episodes of ours"):
            open_folder(tmp_path, **more)
    with pytest.raises(BadOutput, match="no folder to write to"):
        open_folder(tmp_path / "mine.txt")


def test_earlier_episodes_are_kept_unless_told(tmp_path: Path) -> None:
    record_episodes(small(), 3, open_folder(tmp_path))
    with pytest.raises(OutputExists, match="--resume records the rest, --overwrite replaces"):
        open_folder(tmp_path)
    with pytest.raises(BadConfig, match="keep one"):
        open_folder(tmp_path, resume=True, overwrite=True)
    with pytest.raises(BadConfig, match="seed was 3 and is 4"):
        EpisodeFolder.open(tmp_path, {**SETTINGS, "seed": 4}, 2, FRAMES, resume=True)
    (tmp_path / "episodes.json").write_text("{}")
    with pytest.raises(BadFile, match="no list of ours"):
        open_folder(tmp_path, resume=True)


@pytest.mark.parametrize("count", [0, -1, 10_001])
def test_the_number_of_episodes_has_a_range(tmp_path: Path, count: int) -> None:
    with pytest.raises(BadConfig, match=f"{count} episodes: give 1 to 10000"):
        EpisodeFolder.open(tmp_path, SETTINGS, count, FRAMES)


def test_nothing_is_left_when_nothing_was_recorded(tmp_path: Path) -> None:
    def interrupt(_: str) -> None:
        raise BadOutput("disk")

    with pytest.raises(BadOutput):
        record_episodes(small(), 3, open_folder(tmp_path / "a" / "b"), IMAGES, interrupt)
    assert list(tmp_path.iterdir()) == []
