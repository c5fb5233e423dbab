"""The files between us and a guest."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import DetectionLog, RecordedSequence
from mot_sim.datasets.kitti import write_results
from mot_sim.experiments.guests.exchange import read_guest_results, read_seconds, write_detections
from tests.mot_sim.experiments.guests.conftest import truth_of
from tracker.errors import BadFile
from tracker.types import Detections


def test_a_guest_is_shown_the_boxes_above_its_score(
    drives: list[RecordedSequence], tmp_path: Path
) -> None:
    write_detections(drives, 0.3, tmp_path)
    lines = (tmp_path / "a.txt").read_text().splitlines()
    assert len(lines) == 8
    assert lines[:3] == ["0,500,190,560,230,0.9", "0,700,190,760,230,0.9", "1,502,190,562,230,0.9"]
    write_detections(drives, 0.0, tmp_path)
    assert "1,100,180,140,200,0.2" in (tmp_path / "a.txt").read_text().splitlines()


def test_the_sequences_are_described(drives: list[RecordedSequence], tmp_path: Path) -> None:
    write_detections([drives[0].subset([0, 2])], 0.3, tmp_path)
    told = json.loads((tmp_path / "sequences.json").read_text())
    assert told == {
        "a": {
            "frame_count": 4, "frames": [0, 2], "frame_rate": 10.0,
            "image_width": 1242, "image_height": 375,
        }
    }  # fmt: skip
    rows = (tmp_path / "a.txt").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["0", "0", "2", "2"]


def test_a_drive_without_boxes_is_an_empty_file(
    drives: list[RecordedSequence], tmp_path: Path
) -> None:
    bare = replace(drives[0], log=DetectionLog(np.zeros(0, np.int64), Detections.empty()))
    write_detections([bare], 0.3, tmp_path)
    assert (tmp_path / "a.txt").read_text() == ""
    assert len(read_guest_results([bare], tmp_path)["a"]) == 0


def test_both_layouts_say_the_same(drives: list[RecordedSequence], tmp_path: Path) -> None:
    truth = truth_of(drives[0])
    write_results(truth, tmp_path / "a.txt")
    kitti = read_guest_results(drives[:1], tmp_path)["a"]
    rows = [
        f"{frame} {number} {' '.join(map(str, box))} 0.5"
        for frame, number, box in zip(truth.frames, truth.ids, truth.boxes, strict=True)
    ]
    (tmp_path / "a.txt").write_text("\n".join(rows))
    plain = read_guest_results(drives[:1], tmp_path)["a"]
    for read in (kitti, plain):
        np.testing.assert_array_equal(read.frames, truth.frames)
        np.testing.assert_array_equal(read.ids, truth.ids)
        np.testing.assert_allclose(read.boxes, truth.boxes, atol=1e-6)
    assert plain.scores is not None
    assert plain.scores.tolist() == [0.5] * len(truth)


BAD_ROWS = {
    "0 1 5 5 9 9": "no known format has 6 values",
    "0 1 nan 5 9 9 0.5": "x1 is not finite",
    "0 1 5 5 9 9 nan": "score is not finite",
    "0 1 9 5 5 9 0.5": "inverted box",
    "4 1 5 5 9 9 0.5": "frame beyond the sequence: frame 4",
    "-1 1 5 5 9 9 0.5": "frame below 0: frame -1",
    "0 -1 5 5 9 9 0.5": "id below 0: frame 0, id -1",
    "0 1.5 5 5 9 9 0.5": "id is not a whole number: id 1.5",
    "0 one 5 5 9 9 0.5": "id is 'one', which is no number",
    "0 1 5 5 9 9 0.5\n0 1 15 5 19 9 0.5": "an id twice in a frame: frame 0, id 1",
    "0 -1 Car 0 0 0 5 5 9 9 1 1 1 1 1 1 1 0.5": "id below 0",
    "Traceback (most recent call last):": "no known format has 5 values",
}


@pytest.mark.parametrize("row", BAD_ROWS, ids=BAD_ROWS.values())
def test_rubbish_is_named_with_file_and_line(
    row: str, drives: list[RecordedSequence], tmp_path: Path
) -> None:
    (tmp_path / "a.txt").write_text(f"\n{row}\n")
    with pytest.raises(BadFile) as caught:
        read_guest_results(drives[:1], tmp_path)
    line = 1 if "no known format" in BAD_ROWS[row] else 2 + row.count("\n")
    assert str(caught.value).startswith(f"{tmp_path / 'a.txt'}:{line}: {BAD_ROWS[row]}")


def test_rows_of_a_frame_that_was_not_given_are_refused(
    drives: list[RecordedSequence], tmp_path: Path
) -> None:
    (tmp_path / "a.txt").write_text("0 1 5 5 9 9 0.5\n1 1 5 5 9 9 0.5\n")
    with pytest.raises(BadFile, match=r"a\.txt:2: frame that was not given: frame 1"):
        read_guest_results([drives[0].subset([0, 2])], tmp_path)


def test_a_drive_without_a_file_is_refused(drives: list[RecordedSequence], tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("")
    with pytest.raises(BadFile, match=r"b\.txt: not written; .* write an empty file"):
        read_guest_results(drives, tmp_path)


def test_a_file_of_no_drive_is_refused(drives: list[RecordedSequence], tmp_path: Path) -> None:
    for name in "abc":
        (tmp_path / f"{name}.txt").write_text("")
    with pytest.raises(BadFile, match=r"c\.txt: results of no sequence .* for a, b"):
        read_guest_results(drives, tmp_path)


def test_seconds_may_be_told_or_not(drives: list[RecordedSequence], tmp_path: Path) -> None:
    assert read_seconds(drives, tmp_path) is None
    (tmp_path / "seconds.json").write_text('{"a": 1, "b": 0.5, "more": 3}')
    assert read_seconds(drives, tmp_path) == {"a": 1.0, "b": 0.5}


@pytest.mark.parametrize(
    "text", ["[1, 2]", '{"a": 1}', '{"a": 1, "b": -1}', '{"a": 1, "b": NaN}', "1 s", '{"a": null}']
)
def test_seconds_that_are_none_are_refused(
    text: str, drives: list[RecordedSequence], tmp_path: Path
) -> None:
    (tmp_path / "seconds.json").write_text(text)
    with pytest.raises(BadFile, match=r"seconds\.json"):
        read_seconds(drives, tmp_path)
