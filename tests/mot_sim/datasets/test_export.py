"""Exports for other people's evaluators."""

import configparser
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets.detection_files import read_detections
from mot_sim.datasets.export import export_motchallenge, export_trackeval
from mot_sim.datasets.kitti import DETECTORS, kitti_sequence, read_labels, read_results
from tests.mot_sim.datasets.test_recorded import drive
from tracker.errors import BadConfig, BadTracks
from tracker.types import CarEstimates, Tracks

RESULTS = Tracks(
    np.array([0, 2]), np.array([0, 3]), np.array([[1.0, 2, 4, 6], [2, 3, 5, 7]]), np.array([0.5, 2])
)


def test_motchallenge_counts_from_one_and_gives_widths(tiny_tree: Path, tmp_path: Path) -> None:
    sequence = kitti_sequence(tiny_tree, "0030")
    export_motchallenge(tmp_path / "out", sequence, sequence.truth, RESULTS)
    home = tmp_path / "out" / "0030"
    assert (home / "res" / "res.txt").read_text().splitlines() == [
        "1,1,1.000000,2.000000,3.000000,4.000000,0.5,3,-1,-1",
        "3,4,2.000000,3.000000,3.000000,4.000000,2,3,-1,-1",
    ]
    assert (home / "gt" / "gt.txt").read_text().splitlines() == [
        "1,8,40.000000,10.000000,20.000000,20.000000,1,3,-1,-1",
        "3,8,41.000000,11.000000,20.000000,20.000000,1,3,-1,-1",
    ]
    header = configparser.ConfigParser()
    header.read(home / "seqinfo.ini")
    assert dict(header["Sequence"]) == {
        "name": "0030", "imdir": "img1", "framerate": "10", "seqlength": "3",
        "imwidth": "1242", "imheight": "375", "imext": ".png",
    }  # fmt: skip


def test_exported_detections_are_read_back(tiny_tree: Path, tmp_path: Path) -> None:
    sequence = kitti_sequence(tiny_tree, "0030")
    export_motchallenge(tmp_path / "out", sequence)
    assert sorted(path.name for path in (tmp_path / "out" / "0030").iterdir()) == [
        "det",
        "seqinfo.ini",
    ]
    log = read_detections(
        tmp_path / "out" / "0030" / "det" / "det.txt", DETECTORS["motchallenge"], (1242, 375), 3
    )
    for frame in sequence:
        np.testing.assert_allclose(log.at(frame.index).boxes, frame.detections.boxes)
        np.testing.assert_allclose(log.at(frame.index).scores, frame.detections.scores)


def test_kinds_that_are_not_cars_have_confidence_0(tmp_path: Path) -> None:
    truth = Tracks(
        np.array([0, 0]), np.array([1, 2]), np.zeros((2, 4)), kinds=np.array(["Van", "Car"])
    )
    export_motchallenge(tmp_path, drive(), truth)
    rows = (tmp_path / "drive" / "gt" / "gt.txt").read_text().splitlines()
    assert [row.split(",")[6] for row in rows] == ["0", "1"]


def test_an_empty_drive_is_exported(tmp_path: Path) -> None:
    export_motchallenge(tmp_path, drive().subset([]), Tracks.empty(), Tracks.empty())
    assert (tmp_path / "drive" / "det" / "det.txt").read_text() == ""
    assert "seqLength=0" in (tmp_path / "drive" / "seqinfo.ini").read_text()


def test_trackeval_finds_its_folders(tiny_tree: Path, tmp_path: Path) -> None:
    sequence = kitti_sequence(tiny_tree, "0030")
    assert sequence.truth is not None
    export_trackeval(
        tmp_path / "out", "mine", {"0030": 3}, {"0030": sequence.truth}, {"0030": RESULTS}
    )
    seqmap = tmp_path / "out" / "gt" / "evaluate_tracking.seqmap.training"
    assert seqmap.read_text() == "0030 empty 000000 000003\n"
    labels = read_labels(tmp_path / "out" / "gt" / "label_02" / "0030.txt")
    np.testing.assert_array_equal(labels.boxes, sequence.truth.boxes)
    np.testing.assert_array_equal(labels.occlusion, sequence.truth.occlusion)
    results = read_results(tmp_path / "out" / "trackers" / "mine" / "data" / "0030.txt")
    np.testing.assert_array_equal(results.boxes, RESULTS.boxes)


def test_cuboids_and_states_are_kept_for_others(tiny_tree: Path, tmp_path: Path) -> None:
    sequence = kitti_sequence(tiny_tree, "0030")
    truth, T_road_label = sequence.truth, sequence.T_road_label
    assert truth is not None
    count = len(RESULTS)
    means = np.tile([1.0, 0.0, 20.0, 0.1, 5.0, 1.4, 0.4, 0.5, 0.0], (count, 1))
    states = CarEstimates(means, np.tile(np.eye(9), (count, 1, 1)), np.full(count, 0.8))
    results = RESULTS.replaced(cuboids=states.cuboids(), estimates=states)
    frames = {"0030": T_road_label}
    export_trackeval(tmp_path, "mine", {"0030": 3}, {"0030": truth}, {"0030": results}, frames)
    labels = read_labels(tmp_path / "gt" / "label_02" / "0030.txt", T_road_label)
    assert truth.cuboids is not None
    assert labels.cuboids is not None
    np.testing.assert_allclose(labels.cuboids.base, truth.cuboids.base, atol=1e-5)
    found = read_results(tmp_path / "trackers" / "mine" / "data" / "0030.txt", T_road_label)
    assert found.estimates is not None
    np.testing.assert_allclose(found.estimates.means, means, atol=1e-6)


def test_exports_refuse_what_evaluators_would_choke_on(tmp_path: Path) -> None:
    with pytest.raises(BadConfig, match="no truth for sequence 0005"):
        export_trackeval(tmp_path, "mine", {"0005": 3}, {}, {"0005": RESULTS})
    with pytest.raises(BadTracks, match="results of 0005: frame 2 is outside the sequence of 2"):
        export_trackeval(tmp_path, "mine", {"0005": 2}, {"0005": Tracks.empty()}, {"0005": RESULTS})
    twice = RESULTS.select(np.array([0, 0]))
    with pytest.raises(BadTracks, match="id 0 stands twice in frame 0"):
        export_motchallenge(tmp_path, drive(), results=twice)


def test_motchallenge_keeps_the_class(tiny_tree: Path, tmp_path: Path) -> None:
    sequence = kitti_sequence(tiny_tree, "0030")
    walking = RESULTS.replaced(kinds=np.full(len(RESULTS), "Pedestrian"))
    assert sequence.truth is not None
    named = sequence.truth.select(sequence.truth.ids >= 0)
    kinds = np.where(np.arange(len(named)) % 2, "Pedestrian", "Van")
    export_motchallenge(tmp_path / "out", sequence, named.replaced(kinds=kinds), walking)
    home = tmp_path / "out" / "0030"
    assert {row.split(",")[7] for row in (home / "res/res.txt").read_text().split()} == {"1"}
    rows = [row.split(",") for row in (home / "gt" / "gt.txt").read_text().split()]
    assert {(row[6], row[7]) for row in rows} == {("1", "1"), ("0", "8")}
