"""Boxes as people have them: dialects of CSV, MOTChallenge, KITTI's rows, COCO's results."""

import json
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.datasets.box_tables import read_box_table
from mot_sim.datasets.boxes import box_sequence
from mot_sim.datasets.recorded import RecordedSequence
from tests.mot_sim.datasets.conftest import write
from tests.mot_sim.datasets.test_boxes import CAMERA
from tracker.errors import BadFile

HEADER = "frame,x_min,y_min,x_max,y_max,score"
ROW = "0,10,12,30,32,0.75"


def drive(folder: Path, text: str, name: str = "boxes.csv", **options) -> RecordedSequence:
    write(folder / "camera.toml", CAMERA)
    return box_sequence(write(folder / name, text), folder / "camera.toml", **options)


@pytest.mark.parametrize(
    "text",
    [
        f"{HEADER}\n{ROW}\n",
        f"{HEADER.upper()}\n{ROW}\n",
        f"{HEADER.replace(',', ';')}\n{ROW.replace(',', ';').replace('.', ',')}\n",
        f"{HEADER.replace(',', chr(9))}\n{ROW.replace(',', chr(9))}\n",
        '"frame","x_min","y_min","x_max","y_max","score"\n"0","10","12","30","32","0.75"\n',
        f"# made by hand\n{HEADER},\n{ROW},\n",
        f"# {HEADER}\n{ROW}\n",
        f"\ufeff{HEADER}\r\n{ROW}\r\n",
        "frame_id;x1;y1;x2;y2;confidence\n0;10;12;30;32;.75\n",
        "Frame, Left, Top, Width, Height, Conf\n0, 10, 12, 20, 20, 0.75\n",
        "1,-1,10,12,20,20,0.75,-1,-1,-1\n",
        "0 -1 Car -1 -1 -10 10 12 30 32 -1 -1 -1 -1000 -1000 -1000 -10 0.75\n",
    ],
)
def test_every_dialect_gives_the_one_box(tmp_path: Path, text: str) -> None:
    (frame,) = drive(tmp_path, text)
    assert frame.found.boxes.tolist() == [[10, 12, 30, 32]]
    assert frame.found.scores.tolist() == [0.75]
    assert frame.found.kinds is None


def test_coco_results_are_read_with_their_classes(tmp_path: Path) -> None:
    entries = [
        {"image_id": 1, "category_id": 3, "bbox": [10, 12, 20, 20], "score": 0.75},
        {"image_id": 0, "category_id": 1, "bbox": [40, 12, 5, 20], "score": 0.5},
        {"image_id": 0, "category_id": 17, "bbox": [50, 12, 5, 20], "score": 0.9},
    ]
    first, second = drive(tmp_path, json.dumps(entries), "results.json")
    assert (first.found.boxes.tolist(), list(first.found.kinds)) == (
        [[40, 12, 45, 32]],
        ["Pedestrian"],
    )
    assert (second.found.scores.tolist(), list(second.found.kinds)) == ([0.75], ["Car"])
    named = {"categories": [{"id": 3, "name": "person"}], "annotations": entries[:1]}
    sequence = drive(tmp_path, json.dumps(named), "labels.json")
    assert sequence.kinds == ("Pedestrian",)
    assert drive(tmp_path, json.dumps(entries), "r.json", kinds=("Car",)).kinds == ("Car",)


def test_columns_of_class_time_yaw_and_size_are_used(tmp_path: Path) -> None:
    text = (
        "frame,time,class,yaw,length_m,height_m,width_m,x_min,y_min,x_max,y_max\n"
        "0,5.0,car,0.5,4,1.5,1.7,10,12,30,32\n"
        "0,5.0,PEDESTRIAN,,,,,40,12,45,32\n"
        "3,5.4,Car,,4,1.5,1.7,11,12,31,32\n"
    )
    sequence = drive(tmp_path, text)
    assert sequence.kinds == ("Car", "Pedestrian")
    frames = list(sequence)
    assert [frame.time for frame in frames] == pytest.approx(
        [5.0, 5.0 + 0.4 / 3, 5.0 + 0.8 / 3, 5.4]
    )
    found = frames[0].found
    assert list(found.kinds) == ["Car", "Pedestrian"]
    np.testing.assert_array_equal(found.yaw, [0.5, np.nan])
    np.testing.assert_array_equal(found.size, [[4, 1.5, 1.7], [np.nan] * 3])


def test_times_alone_number_the_frames(tmp_path: Path) -> None:
    text = "timestamp,x_min,y_min,x_max,y_max\n7.5,10,12,30,32\n7,10,12,30,32\n7.5,40,12,50,32\n"
    frames = list(drive(tmp_path, text))
    assert [(frame.time, len(frame.found)) for frame in frames] == [(7.0, 1), (7.5, 2)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ":1: no header but 'an empty file'; the first line names the columns"),
        (
            "frame,x,y,w,h\n0,1,2,3,4\n",
            r":1: unknown column 'x'.*is x the left edge\? Write left,top",
        ),
        ("frame,x_min,y_min,x_max\n0,1,2,3\n", ":1: no column y_max"),
        ("frame,left,top,width\n0,1,2,3\n", ":1: no column height"),
        (f"{HEADER},frame_id\n{ROW},0\n", ":1: a column stands twice: frame"),
        (f"#\n{HEADER}\n{ROW}\n0,1,2,3\n", ":4: 4 values where 6 belong"),
        (f"{HEADER}\n# lost\n0,1,2,x,4,.5\n", ":3: x_max is 'x', which is no number"),
        (f"{HEADER}\n0,1,2,nan,4,.5\n", ":2: x_max is not finite"),
        (f"{HEADER},class\n{ROW},tram car\n", ":2: no class of KITTI: type tram car"),
        (f"{HEADER},class\n{ROW},3\n", ":2: a class that is a number: type 3"),
        (f"{HEADER},length_m\n{ROW},4\n", ":1: no column height_m"),
        (f"{HEADER},length_m,height_m,width_m\n{ROW},4,0,2\n", ":2: a size that no vehicle has"),
        (f"{HEADER},yaw\n{ROW},inf\n", ":2: yaw is not finite"),
        (f"{HEADER},time\n{ROW},1\n1{ROW[1:]},1\n", ":3: a time that does not fit its frame"),
        (f"{HEADER},time\n{ROW},1\n{ROW},2\n", ":3: a time that does not fit its frame"),
        ("0,1,2,3,4,.5\n", ":1: no header but .* without one, rows are MOTChallenge's"),
    ],
)
def test_broken_variants_are_refused_with_file_line_and_value(
    tmp_path: Path, text: str, message: str
) -> None:
    with pytest.raises(BadFile, match=f"boxes.csv{message}"):
        drive(tmp_path, text)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{}", "no list of results as COCO has them"),
        ('[{"image_id": 0, "bbox": [1, 2, 3]}]', "entry 0: ValueError"),
        ('[{"bbox": [1, 2, 3, 4]}]', "entry 0: KeyError: 'image_id'"),
        ('[{"image_id": 0, "category_id": 3, "bbox": [9, 9, -3, 4]}]', "entry 0: inverted box"),
        ("[1]", "entry 0: TypeError"),
    ],
)
def test_broken_entries_are_named(tmp_path: Path, content: str, message: str) -> None:
    with pytest.raises(BadFile, match=f"results.json: {message}"):
        drive(tmp_path, content, "results.json")


def test_words_that_cannot_be_written_are_said_all_the_same(tmp_path: Path, caplog) -> None:
    """JSON may hold half of a pair of surrogates, which no log could take."""
    named = '{"categories": [{"id": 9, "name": "\\ud83d"}], "annotations": [%s]}'
    entry = '{"image_id": 0, "category_id": 9, "bbox": [10, 12, 20, 20]}'
    assert len(next(iter(drive(tmp_path, named % entry, "labels.json"))).found) == 0
    assert r"holds 1 of \ud83d" in caplog.text
    caplog.text.encode("utf-8")


numbers = st.integers(-9000, 9000).map(lambda value: value / 8)
rows = st.lists(st.tuples(st.integers(0, 40), *[numbers] * 4, st.integers(0, 64)), max_size=12)


@given(
    rows, st.sampled_from([",", ";", "\t", "|"]), st.booleans(), st.permutations(HEADER.split(","))
)
def test_whatever_the_dialect_the_same_rows_come_back(made, delimiter, quoted, order) -> None:
    """Delimiters, quotes and the order of columns change nothing."""
    columns = HEADER.split(",")
    mark = '"' if quoted else ""
    lines = [delimiter.join(f"{mark}{name}{mark}" for name in order)]
    for row in made:
        values = dict(zip(columns, (*row[:5], row[5] / 64), strict=True))
        lines.append(delimiter.join(f"{mark}{values[name]}{mark}" for name in order))
    with tempfile.TemporaryDirectory() as folder:
        table, _ = read_box_table(write(Path(folder) / "boxes.csv", "\n".join(lines) + "\n"))
    back = table.block(columns)
    expected = [(*row[:5], row[5] / 64) for row in made]
    np.testing.assert_array_equal(back, np.array(expected, dtype=float).reshape(-1, 6))
