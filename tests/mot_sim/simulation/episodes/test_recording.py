"""Recording episodes: the same bytes always, and nothing half-made after trouble."""

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import kitti_sequence
from mot_sim.simulation.episodes import (
    PICTURES,
    EpisodeFiles,
    PictureOptions,
    read_episode,
    record_episode,
)
from mot_sim.simulation.episodes import recording as recording_module
from mot_sim.simulation.traffic.highway import HighwayTraffic
from tests.mot_sim.simulation.episodes.conftest import ALL, SEED, contents
from tests.mot_sim.simulation.episodes.small import FRAMES, small
from tracker.errors import BadConfig, BadOutput, UnknownName

IMAGES = PictureOptions(("images",))
ELSEWHERE = """
import sys
from pathlib import Path
from mot_sim.simulation.episodes import PICTURES, PictureOptions, EpisodeFiles, record_episode
from tests.mot_sim.simulation.episodes.small import small
files, options = EpisodeFiles(Path(sys.argv[1]), "0000"), PictureOptions(tuple(PICTURES))
record_episode(small(), {seed}, files, options)
"""


def test_two_processes_write_the_same_bytes(recorded: Path, tmp_path: Path) -> None:
    code = ELSEWHERE.format(seed=SEED)
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=True, timeout=60)
    assert contents(tmp_path) == contents(recorded)


def test_several_processes_that_draw_write_the_same_bytes(recorded: Path, tmp_path: Path) -> None:
    record_episode(small(), SEED, EpisodeFiles(tmp_path, "0000"), replace(ALL, jobs=2))
    assert contents(tmp_path) == contents(recorded)


def test_other_environments_in_the_process_change_nothing(recorded: Path, tmp_path: Path) -> None:
    other = HighwayTraffic("highway", cars=4, arrivals=0.5, crashes="label")
    other.reset(np.random.default_rng(5))
    for _ in range(3):
        other.step()
    record_episode(small(), SEED, EpisodeFiles(tmp_path, "0000"), ALL)
    assert contents(tmp_path) == contents(recorded)


def test_another_seed_gives_other_bytes(recorded: Path, tmp_path: Path) -> None:
    record_episode(small(), SEED + 1, EpisodeFiles(tmp_path, "0000"), ALL)
    mine, theirs = contents(tmp_path), contents(recorded)
    assert mine.keys() == theirs.keys()
    for name in ("detections/simulated/0000.txt", "odometry/noisy/0000.txt"):
        assert mine[name] != theirs[name]
    assert mine["training/image_02/0000/000000.png"] != theirs["training/image_02/0000/000000.png"]


@pytest.mark.parametrize("frames", [1, 4])
def test_ctrl_c_leaves_the_episode_of_the_finished_frames(
    tmp_path: Path, interrupt_after: Callable[[int], Callable[[], None]], frames: int
) -> None:
    cut, short = tmp_path / "cut", tmp_path / "short"
    with pytest.raises(KeyboardInterrupt):
        record_episode(small(), SEED, EpisodeFiles(cut, "0000"), ALL, interrupt_after(frames))
    scene = replace(small(), frame_count=frames)
    record_episode(scene, SEED, EpisodeFiles(short, "0000"), ALL)
    assert contents(cut) == contents(short)
    read = kitti_sequence(cut, "0000", "simulated", "oxts", images=True)
    assert len(list(read)) == read.frame_count == frames
    assert read_episode(cut, "0000").frame_count == frames


def test_ctrl_c_while_a_picture_is_written_drops_that_frame(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add = recording_module.Pictures.add

    def interrupted(pictures: object, frame: int, rendered: object) -> None:
        add(pictures, frame, rendered)
        if frame == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(recording_module.Pictures, "add", interrupted)
    with pytest.raises(KeyboardInterrupt):
        record_episode(small(), SEED, EpisodeFiles(tmp_path, "0000"), ALL)
    monkeypatch.undo()
    assert read_episode(tmp_path).frame_count == 2
    for part in PICTURES:
        assert len(list(EpisodeFiles(tmp_path, "0000").pictures(part).iterdir())) == 2


def test_ctrl_c_before_any_frame_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(recording_module, "annotate_frame", interrupted)
    with pytest.raises(KeyboardInterrupt):
        record_episode(small(), SEED, EpisodeFiles(tmp_path, "0000"), IMAGES)
    assert list(tmp_path.rglob("*")) == []


@pytest.mark.parametrize("writes", [0, 3, 7, 9, 12])
def test_a_full_disk_is_told_and_leaves_nothing_that_looks_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, writes: int
) -> None:
    left, replace_file = [writes], os.replace

    def full(source: Path, target: Path) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        replace_file(source, target)

    monkeypatch.setattr("mot_sim.files.writing.os.replace", full)
    with pytest.raises(BadOutput, match=r"cannot be written: No space left on device"):
        record_episode(small(), SEED, EpisodeFiles(tmp_path, "0000"), IMAGES)
    assert list(tmp_path.rglob("*")) == []


def test_an_older_episode_of_the_name_is_replaced(tmp_path: Path) -> None:
    places = EpisodeFiles(tmp_path, "0000")
    record_episode(small(), SEED, places, ALL)
    record_episode(replace(small(), frame_count=2), SEED, places, IMAGES)
    assert not places.pictures("depth").exists()
    assert len(list(places.pictures("images").iterdir())) == 2
    assert read_episode(tmp_path).frame_count == 2


def test_without_pictures_there_are_none(tmp_path: Path) -> None:
    told = record_episode(small(), SEED, EpisodeFiles(tmp_path, "0000"))
    assert told.renderer is None
    assert list(tmp_path.rglob("*.png")) == []
    assert read_episode(tmp_path).frame_count == FRAMES


def test_wrong_pictures_and_renderers_are_named(tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match=r"unknown kind of picture 'deph'.*you mean 'depth'"):
        PictureOptions(("deph",))
    with pytest.raises(BadConfig, match="name each kind once"):
        PictureOptions(("depth", "depth"))
    with pytest.raises(UnknownName, match="unknown renderer 'rastr'"):
        record_episode(
            small(), 0, EpisodeFiles(tmp_path, "0000"), PictureOptions(("images",), "rastr")
        )
    assert list(tmp_path.rglob("*")) == []
