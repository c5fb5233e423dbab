"""Which frames of which sequences: seqmaps, halves, ranges."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import kitti_sequence
from mot_sim.diagnosis.tasks import kitti_tasks
from mot_sim.evaluation.scoring import score_folder
from mot_sim.evaluation.spatial_scoring import score_folder_in_3d
from mot_sim.evaluation.splits import Split, read_seqmap
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.tuning.labelled import labelled
from tests.mot_sim.datasets.conftest import write
from tracker.errors import BadConfig, BadFile, TrackingError, UnknownName


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A sequence of eight frames with a car in every one."""
    label = "{} 1 Car 0 0 -1.6 100 150 180 200 1.5 1.6 3.9 1 1.6 20 -1.6\n"
    write(tmp_path / "training" / "label_02" / "0030.txt", "".join(map(label.format, range(8))))
    write(tmp_path / "training" / "calib" / "0030.txt", "P2: 700 0 600 0 0 700 180 0 0 0 1 0\n")
    detections = "".join(f"{frame},100,150,180,200,0.9\n" for frame in range(8))
    write(tmp_path / "detections" / "simulated" / "0030.txt", detections)
    return tmp_path


def frames(tree: Path, split: Split) -> list[int]:
    drive = kitti_sequence(tree, "0030", "simulated", "none")
    return split.part(drive).frame_indices.tolist()


def test_halves_ranges_and_seqmaps_choose_frames(tree: Path, tmp_path: Path) -> None:
    assert frames(tree, Split()) == list(range(8))
    assert frames(tree, Split(frames="first-half")) == [0, 1, 2, 3]
    assert frames(tree, Split(frames="second-half")) == [4, 5, 6, 7]
    assert frames(tree, Split(frames="2-3")) == [2, 3]
    seqmap = write(tmp_path / "seqmap.txt", "0030 empty 000003 000008\n")
    split = Split.of(seqmap, None)
    assert frames(tree, split) == [3, 4, 5, 6, 7]
    assert split.sequences(["0029", "0030"]) == ["0030"]
    with pytest.raises(BadConfig, match=r"has frames 0\.\.7, not 6\.\.9"):
        frames(tree, Split(frames="6-9"))


def test_only_the_chosen_frames_are_scored(tree: Path) -> None:
    """The car is lost in the last two frames."""
    row = "{} 1 Car -1 -1 -10 100 150 180 200 -1 -1 -1 -1000 -1000 -1000 -10 0.9\n"
    results = write(tree / "out" / "0030.txt", "".join(map(row.format, range(6)))).parent

    def hits(split: Split) -> tuple[float, float]:
        combined = score_folder(results, tree, split=split).evaluation.combined
        return combined["CLR_TP"], combined["CLR_FN"]

    assert hits(Split()) == (6, 2)
    assert hits(Split(frames="first-half")) == (4, 0)
    assert hits(Split({"0030": range(4, 8)})) == (2, 2)


def test_cuboids_are_scored_in_the_chosen_frames_too(tree: Path) -> None:
    row = "{} 1 Car -1 -1 -10 100 150 180 200 1.5 1.6 3.9 1 1.6 20 -1.6 0.9\n"
    results = write(tree / "out" / "0030.txt", "".join(map(row.format, range(6)))).parent
    for split, hits in ((Split(), 6), (Split(frames="second-half"), 2)):
        scored = score_folder_in_3d(results, tree, ego="none", split=split)
        assert hits == scored.combined.ab3dmot["0.25"].all_tracks.counts.CLR_TP


def test_commands_that_know_cars_only_refuse_other_classes(tree: Path) -> None:
    drive = kitti_sequence(tree, "0030", "simulated", "none")
    drive.require_cars()
    with pytest.raises(BadConfig, match="detections of Pedestrian, but only cars are scored here"):
        labelled(replace(drive, kinds=("Pedestrian",)))
    with pytest.raises(BadConfig, match="detections of Car, Cyclist, but only cars"):
        next(kitti_tasks([replace(drive, kinds=("Car", "Cyclist"))], TrackerSpec.parse("default")))


@pytest.mark.parametrize("text", ["half", "3", "5-2", "-3", "a-b", "1-2-3"])
def test_what_is_no_part_is_named(text: str) -> None:
    with pytest.raises(BadConfig, match=f"frames '{text}': give first-half, second-half"):
        Split(frames=text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ": no sequence; a line is NAME empty FIRST END"),
        ("0030 empty 5 5\n", ":1: no frame: name 0030, first 5, end 5"),
        ("0030 empty 0 5\n0030 empty 5 8\n", ":2: sequence 0030 stands there twice"),
        ("0030 0 5\n", ":1: 3 values where 4 belong"),
        ("0030 empty -1 5\n", ":1: first below 0"),
    ],
)
def test_broken_seqmaps_are_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(BadFile, match=f"seqmap.txt{message}"):
        read_seqmap(write(tmp_path / "seqmap.txt", text))


def test_a_seqmap_of_another_tree_and_two_splits_at_once_are_named(tmp_path: Path) -> None:
    seqmap = write(tmp_path / "seqmap.txt", "0031 empty 0 5\n")
    with pytest.raises(UnknownName, match=r"seqmap\.txt: unknown sequence '0031'"):
        Split.of(seqmap, None).sequences(["0030"])
    with pytest.raises(BadConfig, match="give one of them"):
        Split.of(seqmap, "first-half")
    assert issubclass(BadConfig, TrackingError)
    assert np.all([Split.of(None, None).sequences(["a", "b"]) == ["a", "b"]])
