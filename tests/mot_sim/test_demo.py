"""The demo: whole or not at all, the same for the same seed."""

import json
from dataclasses import replace

import cv2
import pytest

from mot_sim import demo
from mot_sim.datasets import read_labels, read_results
from mot_sim.datasets.estimate_files import estimates_path
from mot_sim.demo import run_demo, track_episode
from mot_sim.metrics import evaluate_sequence
from mot_sim.plotting.video import count_frames
from mot_sim.simulation.episode import record
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.traffic import Roads
from tracker import Tracker
from tracker.errors import BadOutput, OutputExists

FRAMES = 4


@pytest.fixture(autouse=True)
def short_scene(monkeypatch) -> None:
    """The first frames of the crossing, on a plain, so that a demo takes no time."""
    short = replace(find_scene("crossing", frames=FRAMES), roads=Roads())
    monkeypatch.setattr(demo, "find_scene", lambda name, **knobs: short)


def test_everything_it_promises_is_there_and_can_be_read_back(tmp_path) -> None:
    seen = []
    result = run_demo(tmp_path / "deep" / "out", progress=lambda *done: seen.append(done))
    assert seen == [(index + 1, FRAMES) for index in range(FRAMES)]
    assert count_frames(result.video) == FRAMES
    assert result.stills[-1].name == "crossing.jpg"
    for still in result.stills:
        assert cv2.imread(str(still)).shape == (812, 1242, 3)
        assert still.stat().st_size <= 300_000
    tracks = read_results(result.tracks, frame_count=FRAMES)
    truth = read_labels(result.truth, frame_count=FRAMES)
    again = evaluate_sequence(truth, tracks, FRAMES)
    assert again["MOTA"] == pytest.approx(result.scores["default"]["MOTA"])
    assert set(json.loads(result.scores_json.read_text())["trackers"]) == {"default", "paper"}
    table = result.scores_table.read_text()
    assert all(word in table for word in ("HOTA", "MOTA", "IDF1", "default", "paper"))
    written = {path.name for path in (tmp_path / "deep" / "out").iterdir()}
    promised = {result.video, *result.stills, result.tracks, result.truth, result.scores_json}
    promised |= {result.scores_table, estimates_path(result.tracks)}
    assert written == {path.name for path in promised}
    assert [path.name for path in (tmp_path / "deep").iterdir()] == ["out"]


def test_the_same_seed_writes_the_same_bytes_and_another_seed_others(tmp_path) -> None:
    first, again, other = (
        run_demo(tmp_path / str(index), seed) for index, seed in enumerate((1, 1, 2))
    )
    assert first.tracks.read_bytes() == again.tracks.read_bytes()
    assert first.scores_json.read_bytes() == again.scores_json.read_bytes()
    assert first.tracks.read_bytes() != other.tracks.read_bytes()
    assert first.truth.read_bytes() == other.truth.read_bytes()


def test_an_older_demo_stays_unless_it_may_be_overwritten(tmp_path) -> None:
    (tmp_path / "out").mkdir()
    old = run_demo(tmp_path / "out", 1)
    before = old.tracks.read_bytes()
    with pytest.raises(OutputExists, match="not empty"):
        run_demo(tmp_path / "out", 2)
    assert old.tracks.read_bytes() == before
    new = run_demo(tmp_path / "out", 2, overwrite=True)
    assert new.tracks.read_bytes() != before
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_it_never_overwrites_what_no_demo_wrote(tmp_path) -> None:
    (tmp_path / "thesis.tex").write_text("precious")
    with pytest.raises(OutputExists, match=r"thesis\.tex"):
        run_demo(tmp_path, overwrite=True)
    assert (tmp_path / "thesis.tex").read_text() == "precious"
    with pytest.raises(OutputExists, match="no folder"):
        run_demo(tmp_path / "thesis.tex", overwrite=True)


def test_a_place_that_cannot_be_written_to_is_one_error(tmp_path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BadOutput, match="cannot be written"):
        run_demo(tmp_path / "file" / "out")


def test_an_interrupted_demo_leaves_nothing(tmp_path) -> None:
    def interrupt(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_demo(tmp_path / "out", progress=interrupt)
    assert list(tmp_path.iterdir()) == []


def test_another_tracker_can_be_shown(tmp_path) -> None:
    result = run_demo(tmp_path / "out", make_tracker=Tracker.paper)
    assert list(result.scores) == ["paper"]


@pytest.mark.slow
def test_on_the_whole_crossing_memory_beats_two_frames() -> None:
    episode = record(find_scene("crossing"))
    scores = {
        make.__name__: evaluate_sequence(episode.truth, track_episode(episode, make), len(episode))
        for make in (Tracker.default, Tracker.paper)
    }
    assert scores["default"]["HOTA"] > scores["paper"]["HOTA"]
    assert scores["default"]["IDSW"] < scores["paper"]["IDSW"]
    assert scores["default"]["MOTA"] > 0.8
