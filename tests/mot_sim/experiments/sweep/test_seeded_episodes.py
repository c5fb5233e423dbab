"""Episodes for tests: the same in every run, made once, copied for every tracker."""

import sys
from pathlib import Path
from types import FrameType
from unittest.mock import patch

import numpy as np
import pytest

from mot_sim.experiments.sweep import drives, seeded_episodes
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.files.fingerprint import PACKAGES, records_truth
from mot_sim.testing import SeededEpisode, mot_episode
from tests.mot_sim.conftest import BARE
from tracker import Sequence
from tracker.errors import BadConfig, TrackingError, UnknownName

ROOT = Path(__file__).parents[4]
# Of what runs while truth is recorded, what decides nothing of it.
UNDECIDING: set[Path] = set()
JITTER = {"detector.jitter": 2.0}


def boxes(episode: SeededEpisode) -> list[list[float]]:
    return [box for frame in episode.frames for box in frame.detections.boxes.tolist()]


def forget() -> None:
    """As a new process would begin."""
    seeded_episodes._drive.cache_clear()
    drives._read.cache_clear()


def test_an_episode_has_frames_truth_and_camera(episode: SeededEpisode) -> None:
    assert isinstance(episode.frames, Sequence)
    assert len(episode) == len(list(episode.frames)) == episode.frame_count == 12
    assert len(episode.truth) > 12
    assert set(episode.truth.frames.tolist()) <= set(range(12))
    assert episode.camera.image_size == (1242, 375)
    assert "crossing, seed 1" in episode.name
    assert "detector.jitter=2.0" in episode.name


def test_the_same_seed_gives_the_same_boxes_and_another_one_others(
    episode: SeededEpisode, cache: Path
) -> None:
    forget()
    again = mot_episode("crossing", 1, frames=12, cache=cache, **BARE, **JITTER)
    assert again is not episode
    assert boxes(again) == boxes(episode)
    other = mot_episode("crossing", 1, frames=12, cache=cache, **BARE)
    assert boxes(other) != boxes(episode)
    assert np.array_equal(other.truth.boxes, episode.truth.boxes)
    other = mot_episode("crossing", 2, frames=12, cache=cache, **BARE, **JITTER)
    assert boxes(other) != boxes(episode)


def test_a_truth_is_recorded_once_and_a_damaged_one_anew(
    episode: SeededEpisode, tmp_path: Path
) -> None:
    def small() -> SeededEpisode:
        return mot_episode("crossing", 3, frames=2, cache=tmp_path, **BARE)

    first = boxes(small())
    (file,) = tmp_path.rglob("truth/*.npz")
    forget()
    with patch.object(drives, "annotate", side_effect=AssertionError("made again")):
        assert boxes(small()) == first
        forget()
        file.write_bytes(file.read_bytes()[:-100])
        with pytest.raises(AssertionError, match="made again"):
            small()
    assert boxes(small()) == first


def test_what_a_tracker_does_to_its_frames_harms_nobody(episode: SeededEpisode) -> None:
    before = boxes(episode)
    for frame in episode.frames:
        frame.detections.boxes[:] = -1.0
    assert boxes(episode) == before


def test_no_truth_is_within_reach_of_a_frame(episode: SeededEpisode) -> None:
    frame = next(iter(episode.frames))
    assert set(vars(frame)) == {
        "index", "time", "detections", "T_now_before", "motion_cov", "image"
    }  # fmt: skip
    assert set(vars(episode.frames)) == {"sequence"}


@pytest.mark.parametrize(
    ("given", "error", "told"),
    [
        ({"scene": "intersektion"}, UnknownName, "Did you mean 'intersection'"),
        ({"carz": 3}, UnknownName, "carz"),
        ({"detector.jitta": 3.0}, UnknownName, "Did you mean 'detector.jitter'"),
        ({"profile": "rcc"}, TrackingError, "rrc"),
        ({"seed": -1}, BadConfig, "seed -1"),
        ({"frames": 0}, BadConfig, "0 frames"),
        ({"houses": "many"}, BadConfig, "give a number"),
    ],
)
def test_what_cannot_be_run_is_refused(
    tmp_path: Path, given: dict, error: type[TrackingError], told: str
) -> None:
    with pytest.raises(error, match=told):
        mot_episode(**{"scene": "crossing", "cache": tmp_path, **given})


def test_the_cache_is_where_the_environment_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOT_SIM_CACHE", "/somewhere")
    assert drives.default_cache() == Path("/somewhere")
    monkeypatch.delenv("MOT_SIM_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", "/caches")
    assert drives.default_cache() == Path("/caches/mot-sim/episodes")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert drives.default_cache().parts[-3:] == (".cache", "mot-sim", "episodes")


def test_all_code_that_runs_while_truth_is_recorded_counts_for_its_key(tmp_path: Path) -> None:
    """What is not in the digest may change without a new truth: none of it may run."""
    ran: set[str] = set()

    def note(frame: FrameType, event: str, argument: object) -> None:
        if event == "call":
            ran.add(frame.f_code.co_filename)

    conditions = Conditions.of("intersection", {"scene.frames": 2})
    sys.setprofile(note)
    try:
        drives.Recordings(tmp_path).truth(conditions, 5)
    finally:
        sys.setprofile(None)
    ours = {Path(file).relative_to(ROOT) for file in ran if Path(file).is_relative_to(ROOT)}
    ours = {path for path in ours if path.parts[0] in PACKAGES}
    assert Path("mot_sim/simulation/truth/annotate.py") in ours
    assert {path for path in ours if not records_truth(path)} <= UNDECIDING
    assert not records_truth(Path("tracker/tracker.py"))
