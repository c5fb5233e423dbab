"""What a user names, opened or refused."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import write_results
from mot_sim.evaluation.runs import Recipe
from mot_sim.report.opening import DriveRequest, open_tracks, track_drive, truth_of
from mot_sim.simulation import registry
from mot_sim.simulation.episode import Episode
from mot_sim.simulation.episodes import EpisodeFiles, PictureOptions, StoredEpisode, record_episode
from tests.mot_sim.report.small import FRAMES, drive, exact_tracks, near
from tracker.errors import BadConfig, BadFile, BadTracks, DatasetNotFound, UnknownName


@pytest.fixture(autouse=True)
def near_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry.SCENES, "near", "tests.mot_sim.report.small:near")


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Two recorded episodes, the first with images."""
    root = tmp_path / "tree"
    record_episode(near(), 0, EpisodeFiles(root, "0000"), PictureOptions(("images",)))
    record_episode(near(), 1, EpisodeFiles(root, "0001"))
    return root


@pytest.mark.kitti
def test_a_kitti_sequence_with_images_where_there_are_some(kitti_root: Path) -> None:
    with_images = DriveRequest(str(kitti_root), "0000").open()
    assert with_images.images is not None
    assert with_images.images.load(3).shape == (375, 1242, 3)
    without = DriveRequest(str(kitti_root), "0002", detections="permatrack", ego="none").open()
    assert without.images is None
    assert without.Ts_world_cam is None
    assert len(truth_of(without)) > 100


def test_a_scene_is_run_for_no_longer_than_needed() -> None:
    opened = DriveRequest("near", seed=0, knobs={"speed": 6.0}, end=4).open()
    assert isinstance(opened, Episode)
    assert opened.frame_count == 4
    assert opened.images.load(0).shape == (96, 320, 3)
    longer = DriveRequest("near", end=400).open()
    assert longer.frame_count == FRAMES


def test_a_recorded_episode_comes_with_its_exact_truth_and_its_images(tree: Path) -> None:
    first = DriveRequest(str(tree), "0000").open()
    assert isinstance(first, StoredEpisode)
    assert first.images is not None
    second = DriveRequest(str(tree), "0001").open()
    assert second.images is None
    assert len(truth_of(second)) == 2 * FRAMES
    exact = DriveRequest(str(tree), "0000", detections="exact").open()
    assert isinstance(exact, StoredEpisode)
    np.testing.assert_allclose(exact.log.detections.scores.min(), 1.0)


@pytest.mark.parametrize(
    ("wanted", "error", "told"),
    [
        (DriveRequest("near", sequence="0000"), BadConfig, "--sequence 0000: near is a scene"),
        (DriveRequest("near", detections="rrc"), BadConfig, "--detections rrc: near is a scene"),
        (DriveRequest("neer"), UnknownName, "unknown folder or scene 'neer'.*Did you mean 'near'"),
        (
            DriveRequest("no/such/place"),
            DatasetNotFound,
            "no such folder; give one of mot-sim record",
        ),
    ],
)
def test_what_is_not_there_is_told(wanted: DriveRequest, error: type, told: str) -> None:
    with pytest.raises(error, match=told):
        wanted.open()


def test_a_folder_of_several_asks_which_one(tree: Path, tmp_path: Path) -> None:
    with pytest.raises(BadConfig, match=r"holds 0000, 0001: choose with --sequence"):
        DriveRequest(str(tree)).open()
    with pytest.raises(UnknownName, match="unknown sequence '0007'; known: 0000, 0001"):
        DriveRequest(str(tree), "0007").open()
    with pytest.raises(BadConfig, match="recorded already"):
        DriveRequest(str(tree), "0000", knobs={"speed": 3.0}).open()
    (tmp_path / "empty" / "training").mkdir(parents=True)
    with pytest.raises(DatasetNotFound, match="neither episodes of mot-sim record nor KITTI's"):
        DriveRequest(str(tmp_path / "empty")).open()


def test_tracking_on_the_way_stops_before_the_end() -> None:
    seen: list[int] = []
    tracks = track_drive(drive(), Recipe(), 4, lambda: seen.append(1))
    assert len(seen) == 4
    assert set(tracks.frames.tolist()) == {0, 1, 2, 3}


def test_tracks_come_from_a_runs_folder_or_a_file(tmp_path: Path) -> None:
    shown, tracks = replace(drive(), name="0003"), exact_tracks()
    write_results(tracks, tmp_path / "run" / "0003.txt")
    for place in (tmp_path / "run", tmp_path / "run" / "0003.txt"):
        assert open_tracks(place, shown).ids.tolist() == tracks.ids.tolist()


def test_tracks_of_another_drive_are_refused(tmp_path: Path) -> None:
    shown, tracks = replace(drive(), name="0003"), exact_tracks()
    right = tmp_path / "0003.txt"

    def refused(wrong, error, told: str, name: str = "0003.txt") -> None:
        write_results(wrong, tmp_path / name)
        with pytest.raises(error, match=told) as caught:
            open_tracks(tmp_path / name, shown)
        assert name in str(caught.value)

    refused(tracks, BadTracks, "tracks of '0004', but '0003' is shown", "0004.txt")
    refused(replace(tracks, frames=tracks.frames + 50), BadFile, "frame 50")
    outside = tracks.boxes + np.array([900.0, 0.0, 900.0, 0.0])
    refused(replace(tracks, boxes=outside), BadTracks, "outside the image of 320 x 96 pixels")
    many = exact_tracks(12)
    long = replace(drive(12), name="0003")
    aside = replace(many, boxes=many.boxes + np.array([-90.0, 0.0, -90.0, 0.0]))
    write_results(aside, right)
    with pytest.raises(BadTracks, match="of its 24 boxes lie on a detection of '0003'"):
        open_tracks(right, long)
    write_results(many, right)
    assert len(open_tracks(right, long)) == 24


def test_missing_tracks_are_told_with_what_is_there(tmp_path: Path) -> None:
    write_results(exact_tracks(), tmp_path / "0001.txt")
    with pytest.raises(DatasetNotFound, match="no tracks of 'near'; tracks there: 0001"):
        open_tracks(tmp_path, drive())
    with pytest.raises(DatasetNotFound, match="no such file"):
        open_tracks(tmp_path / "0002.txt", drive())


def test_a_run_of_another_tree_is_warned_of(
    tree: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    shown = DriveRequest(str(tree), "0000").open()
    run = tmp_path / "run"
    write_results(exact_tracks(), run / "0000.txt")
    for root, warned in ((tree, False), (tmp_path / "elsewhere", True)):
        caplog.clear()
        (run / "run.json").write_text(json.dumps({"settings": {"root": str(root.resolve())}}))
        assert len(open_tracks(run, shown)) == 2 * FRAMES
        assert bool(re.search("which is not what is shown", caplog.text)) == warned
    (run / "run.json").write_text("[]")
    assert len(open_tracks(run, shown)) == 2 * FRAMES
