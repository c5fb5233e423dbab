"""Episodes read from disk: bit-equal to what was recorded, and bad files are named."""

import json
import shutil
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from mot_sim.simulation.episode import record
from mot_sim.simulation.episodes import EpisodeFiles, read_episode, verify_episode
from mot_sim.simulation.episodes.extra import (
    EPISODE_FORMAT,
    FORMER_NAMES,
    METADATA,
    array_digests,
    arrays_of,
    read_extra,
)
from mot_sim.simulation.traffic import RecordedTraffic
from tests.mot_sim.simulation.episodes.conftest import SEED
from tests.mot_sim.simulation.episodes.small import FRAMES, small
from tracker.errors import BadFile, DatasetNotFound
from tracker.types import Sequence


def test_everything_comes_back_bit_by_bit(recorded: Path) -> None:
    live, read = arrays_of(record(small(), SEED)), arrays_of(read_episode(recorded, "0000"))
    assert list(live) == list(read)
    for name, array in live.items():
        assert read[name].dtype == array.dtype, name
        assert read[name].tobytes() == array.tobytes(), name
    assert {"truth.keypoints", "vehicles.coefficients", "events.kinds", "log.detections.boxes"} < {
        *live
    }


def test_a_stored_episode_is_a_sequence_with_its_truth_apart(recorded: Path) -> None:
    stored, live = read_episode(recorded), record(small(), SEED)
    assert isinstance(stored, Sequence)
    assert (stored.name, len(stored), stored.seed) == ("0000", FRAMES, SEED)
    assert stored.truth.boxes.tobytes() == live.truth.boxes.tobytes()
    assert stored.events.kinds.tolist() == live.events.kinds.tolist()
    assert stored.subset([2, 4]).truth.frames.tolist() == [
        frame for frame in live.truth.frames.tolist() if frame in (2, 4)
    ]
    for mine, theirs in zip(stored, live, strict=True):
        assert mine.image is None
        assert mine.detections.boxes.tobytes() == theirs.detections.boxes.tobytes()
        assert (mine.T_now_before is None) == (mine.index == 0)
        np.testing.assert_array_equal(mine.T_now_before, theirs.T_now_before)


def test_images_come_when_they_are_asked_for(recorded: Path) -> None:
    drawn = record(small(), SEED, renderer="raster")
    for mine, theirs in zip(read_episode(recorded, images=True), drawn, strict=True):
        np.testing.assert_array_equal(mine.image, theirs.image)


def test_a_tilted_camera_comes_back_exactly(tmp_path: Path) -> None:
    from mot_sim.simulation.episodes import record_episode

    scene = small(pitch=0.05, roll=-0.04)
    record_episode(scene, SEED, EpisodeFiles(tmp_path, "0000"))
    read = read_episode(tmp_path, "0000")
    assert read.camera.T_cam_road.tobytes() == scene.rig.camera.T_cam_road.tobytes()
    live = record(scene, SEED)
    assert read.exact.tracks.cuboids is not None
    assert live.exact.tracks.cuboids is not None
    assert read.exact.tracks.cuboids.yaw.tobytes() == live.exact.tracks.cuboids.yaw.tobytes()


def test_metadata_say_how_it_was_made(recorded: Path) -> None:
    told = read_episode(recorded).metadata
    assert (told.scene, told.seed, told.frames, told.renderer) == ("small", SEED, FRAMES, "raster")
    assert told.versions["numpy"] == np.__version__
    assert {"labels", "detections", "trajectories", "truth", "images"} < told.sha256.keys()
    assert all(len(digest) == 64 for digest in told.sha256.values())


@pytest.fixture
def extra(recorded: Path, tmp_path: Path) -> Path:
    """A copy of the extra file in a tree of its own."""
    place = EpisodeFiles(tmp_path, "0000").extra
    place.parent.mkdir(parents=True)
    return Path(shutil.copy(EpisodeFiles(recorded, "0000").extra, place))


@pytest.mark.parametrize("kept", [0, 30, 4000, -40])
def test_a_cut_file_is_named_with_the_cure(extra: Path, kept: int) -> None:
    extra.write_bytes(extra.read_bytes()[:kept])
    with pytest.raises(BadFile, match=r"0000\.npz: .*; record again"):
        read_episode(extra.parents[2])


def test_older_newer_and_foreign_files_are_told_apart(extra: Path, tmp_path: Path) -> None:
    with np.load(extra) as archive:
        arrays = dict(archive)
    head = json.loads(str(arrays["head"]))
    for version, cure in (
        (0, "this is 1: record again"),
        (2, "this is 1: install a newer mot-sim"),
    ):
        np.savez(extra, **{**arrays, "head": np.array(json.dumps({**head, "version": version}))})
        with pytest.raises(BadFile, match=f"an episode of version {version}, {cure}"):
            read_extra(extra)
    RecordedTraffic.of(record(small(), SEED).traffic_states).save(extra)
    with pytest.raises(BadFile, match="holds recorded traffic, not an episode; record again"):
        read_extra(extra)
    np.savez(extra, x=np.zeros(3))
    with pytest.raises(BadFile, match="its head is None; record again"):
        read_extra(extra)
    extra.write_text("no arrays")
    with pytest.raises(BadFile, match=r"0000\.npz: not an episode: .*; record again"):
        read_extra(extra)


def test_changed_and_missing_arrays_are_found(extra: Path) -> None:
    with np.load(extra) as archive:
        arrays = dict(archive)
    np.savez(extra, **{**arrays, "truth.visible": arrays["truth.visible"] * 0.5})
    with pytest.raises(BadFile, match="do not have the SHA-256"):
        read_extra(extra)
    np.savez(extra, **{name: array for name, array in arrays.items() if name != "vehicles.paints"})
    with pytest.raises(BadFile, match=r"lacks \['vehicles.paints'\]"):
        read_extra(extra)


def test_an_episode_that_is_not_there_is_named_with_those_that_are(recorded: Path) -> None:
    with pytest.raises(DatasetNotFound, match=r"no episode '0007'; episodes there: 0000; mot-sim"):
        read_episode(recorded, "0007")
    with pytest.raises(DatasetNotFound, match="episodes there: none"):
        read_episode(recorded / "training", "0000")


def test_no_table_of_the_truth_is_forgotten(recorded: Path) -> None:
    stored = read_episode(recorded)
    for column in fields(stored.exact):
        assert getattr(stored.exact, column.name) is not None, column.name


def with_former_names(root: Path) -> Path:
    """The extra file of the episode 0000, written anew under the names of earlier versions."""
    path = EpisodeFiles(root, "0000").extra
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files if name != "head"}
    old = {new: former for former, new in FORMER_NAMES.items()}
    assert old.keys() <= arrays.keys()
    arrays = {old.get(name, name): array for name, array in arrays.items()}
    told = json.loads(str(arrays[METADATA]))
    part = {name.replace("cast.", "vehicles."): array for name, array in arrays.items()}
    told["sha256"] |= array_digests(part)
    EPISODE_FORMAT.write(path, {**arrays, METADATA: np.array(json.dumps(told))})
    return path


def test_an_episode_under_former_names_is_read_and_runs_again_the_same(
    recorded: Path, tmp_path: Path
) -> None:
    root = tmp_path / "older"
    shutil.copytree(recorded, root)
    path = with_former_names(root)
    with np.load(path) as file:
        assert {"truth.cut", "occlusions.by", "cast.paints"} <= {*file.files}
    read, live = arrays_of(read_episode(root)), arrays_of(record(small(), SEED))
    assert {name: array.tobytes() for name, array in read.items()} == {
        name: array.tobytes() for name, array in live.items()
    }
    found = verify_episode(root, "0000", lambda _: small(), pictures=False)
    assert found.is_same, found


def test_a_column_under_both_names_is_refused(recorded: Path, tmp_path: Path) -> None:
    root = tmp_path / "both"
    shutil.copytree(recorded, root)
    path = EpisodeFiles(root, "0000").extra
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files if name != "head"}
    EPISODE_FORMAT.write(path, {**arrays, "truth.cut": arrays["truth.truncation"]})
    with pytest.raises(BadFile, match=r"has \['truth.cut'\]"):
        read_episode(root)
