"""Folders of results as people have them: other cases, other places, other contents."""

import gzip
import json
import logging
import re
import zipfile
from pathlib import Path

import pytest

from mot_sim.datasets import read_results
from mot_sim.evaluation.scoring import result_files, score_folder
from tests.mot_sim.datasets.conftest import CALIBRATION, write
from tracker.errors import BadFile, DatasetNotFound

CUBOID = "-1 -1 -1 -1000 -1000 -1000 -10"
COUNT = 25


def row(frame: int, kind: str = "Car", number: int = 3, truncated: str = "0") -> str:
    """A car that moves by 2 px a frame."""
    left = 2 + 2 * frame
    return f"{frame} {number} {kind} {truncated} 0 -10 {left} 5 {left + 30} 35 {CUBOID}"


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A KITTI tree of one sequence, whose labels are in lower case."""
    root = tmp_path / "kitti"
    rows = [row(frame, "car") for frame in range(COUNT)]
    write(root / "training" / "label_02" / "0030.txt", "\n".join(rows) + "\n")
    write(root / "training" / "calib" / "0030.txt", CALIBRATION)
    return root


def results(folder: Path, lines: list[str]) -> Path:
    """A folder with the results of the sequence."""
    write(folder / "0030.txt", "".join(f"{line} 0.9\n" for line in lines))
    return folder


def score(folder: Path, tree: Path) -> float:
    """HOTA of a folder of results."""
    return score_folder(folder, tree).evaluation.combined["HOTA"]


@pytest.mark.parametrize("kind", ["Car", "car", "CAR"])
def test_classes_are_read_in_any_case(tree: Path, tmp_path: Path, kind: str) -> None:
    lines = [row(frame, kind) for frame in range(COUNT)]
    assert score(results(tmp_path / "r", lines), tree) == 1.0


@pytest.mark.parametrize("kind", ["0", "Vehicle", "bus"])
def test_what_is_no_class_is_refused_with_its_line(tree: Path, tmp_path: Path, kind: str) -> None:
    folder = results(tmp_path / "r", [row(0), row(1, kind)])
    said = re.escape(f"{folder / '0030.txt'}:2: no class of KITTI: type {kind}; KITTI's classes")
    with pytest.raises(BadFile, match=said):
        score(folder, tree)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ([row(frame, "Van") for frame in range(3)], "the results hold 3 of Van, and no Car"),
        ([row(0, "Pedestrian")], "the results hold 1 of Pedestrian, and no Car"),
        ([row(0, number=-1)], "the results have ids below 0 in all rows of Car"),
        ([], "the results hold no row"),
        ([row(frame).replace(" 5 ", " 345 ").replace(" 35 ", " 375 ") for frame in range(3)],
         "none of 3 boxes meets a label"),
        ([row(f).replace(f"{f} 3", f"{f + 1} 3", 1) for f in range(COUNT - 1)],
         "0030: the results fit the labels better 1 frame earlier"),
    ],
)  # fmt: skip
def test_results_that_mean_nothing_are_named(
    tree: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture, lines: list[str], said: str
) -> None:
    with caplog.at_level(logging.WARNING):
        score(results(tmp_path / "r", lines), tree)
    assert said in caplog.text


def test_a_share_of_truncation_is_read_in_results_alone(tree: Path, tmp_path: Path) -> None:
    lines = [row(frame, truncated="0.35") for frame in range(COUNT)]
    assert score(results(tmp_path / "r", lines), tree) == 1.0
    write(tree / "training" / "label_02" / "0030.txt", "\n".join(lines))
    with pytest.raises(BadFile, match=r"0030.txt:1: truncated is not a whole number: truncated 0.35"
                       r"; tracking labels have levels 0, 1, 2"):  # fmt: skip
        score(tmp_path / "r", tree)


def test_a_level_beyond_any_share_is_refused(tree: Path, tmp_path: Path) -> None:
    with pytest.raises(BadFile, match=r"0030.txt:1: truncated is no level: truncated 1.5; write"):
        score(results(tmp_path / "r", [row(0, truncated="1.5")]), tree)


def test_a_single_file_is_read(tree: Path, tmp_path: Path) -> None:
    folder = results(tmp_path / "r", [row(frame) for frame in range(COUNT)])
    assert score(folder / "0030.txt", tree) == 1.0


def test_packed_results_are_named(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "r.zip", "w") as archive:
        archive.writestr("0030.txt", row(0))
    with gzip.open(tmp_path / "0030.txt.gz", "wt") as packed:
        packed.write(row(0))
    with pytest.raises(DatasetNotFound, match=r"r\.zip: no folder but a zip archive; unpack it"):
        result_files(tmp_path / "r.zip")
    with pytest.raises(DatasetNotFound, match=r"0030\.txt\.gz: no folder but packed by gzip"):
        result_files(tmp_path / "0030.txt.gz")
    with pytest.raises(DatasetNotFound, match=r"nowhere: no such folder"):
        result_files(tmp_path / "nowhere")
    (tmp_path / "r.zip").rename(tmp_path / "0030.txt")  # a zip by another name
    with pytest.raises(BadFile, match=r"not a text file \(a zip archive; unpack it"):
        read_results(tmp_path / "0030.txt")


def test_a_run_of_another_tree_is_warned_of(
    tree: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder = results(tmp_path / "r", [row(frame) for frame in range(COUNT)])
    for made_of, is_told in ((tree, False), (tmp_path / "gone", False), (tmp_path, True)):
        (folder / "run.json").write_text(json.dumps({"settings": {"root": str(made_of)}}))
        caplog.clear()
        score(folder, tree)
        assert ("is --root right?" in caplog.text) is is_told, made_of
