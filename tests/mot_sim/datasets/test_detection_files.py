"""Score maps: from a detector's scores to probabilities."""

import logging
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.datasets import ScoreMap
from mot_sim.datasets.detection_files import DetectionFormat, read_detections
from mot_sim.datasets.kitti.detectors import DETECTORS
from mot_sim.datasets.kitti.labels import cuboids_of_rows
from tests.mot_sim.datasets.conftest import write
from tracker.errors import BadConfig, BadFile
from tracker.types import Cuboids, Detections


def test_half_of_the_boxes_at_the_midpoint_are_right() -> None:
    expected = [0.5, 1.0 / (1.0 + np.exp(-1.0)), 1.0 / (1.0 + np.exp(1.0))]
    np.testing.assert_allclose(ScoreMap(3.0, 2.0)(np.array([3.0, 5.0, 1.0])), expected)


@given(st.lists(st.floats(-1e6, 1e6), max_size=20), st.floats(-10, 10), st.floats(1e-3, 100))
def test_mapped_scores_are_probabilities_in_the_same_order(
    scores: list[float], midpoint: float, scale: float
) -> None:
    mapped = ScoreMap(midpoint, scale)(np.sort(np.array(scores)))
    assert ((mapped >= 0.0) & (mapped <= 1.0)).all()
    assert (np.diff(mapped) >= 0.0).all()


def test_a_map_is_read_from_two_numbers() -> None:
    assert ScoreMap.parse("2.43, 1.24") == ScoreMap(2.43, 1.24)


@pytest.mark.parametrize("text", ["", "1", "1,2,3", "a,b", "1,0", "1,-2", "nan,1", "1,inf"])
def test_anything_else_is_refused_with_the_text(text: str) -> None:
    with pytest.raises(BadConfig, match=r"score map"):
        ScoreMap.parse(text)


RRC = DetectionFormat(("frame", "x1", "y1", "x2", "y2", "score"), delimiter=",")
SIZE = (100, 50)


def test_boxes_come_by_frame_and_in_the_order_of_the_file(tmp_path: Path) -> None:
    path = write(tmp_path / "d.txt", "2,1,2,3,4,.5\n0,5,6,7,8,-3.5\n2,9,10,11,12,.25\n")
    log = read_detections(path, RRC, SIZE, 3)
    assert log.frames.tolist() == [0, 2, 2]
    assert log.at(0).boxes.tolist() == [[5, 6, 7, 8]]
    assert log.at(0).scores.tolist() == [-3.5]
    assert log.at(2).scores.tolist() == [0.5, 0.25]


def test_an_empty_file_holds_no_detections(tmp_path: Path) -> None:
    log = read_detections(write(tmp_path / "d.txt", ""), RRC, SIZE, 3)
    assert log.at(1).boxes.shape == (0, 4)
    assert log.frames.shape == (0,)


def test_boxes_are_clipped_to_the_pixel_centres(tmp_path: Path) -> None:
    log = read_detections(write(tmp_path / "d.txt", "0,-3,-4,120,60,1\n"), RRC, SIZE)
    assert log.at(0).boxes.tolist() == [[0, 0, 99, 49]]


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("1,nan,2,3,4,.5", "x1 is not finite: x1 nan; leave the row out"),
        ("1,1,2,inf,4,.5", "x2 is not finite: x2 inf"),
        ("1,1,2,3,4,nan", "score is not finite: score nan"),
        ("nan,1,2,3,4,1", "frame is not finite"),
        ("1,3,2,1,4,.5", "inverted box: x1 3, y1 2, x2 1, y2 4; 1 of 2 rows are so"),
        ("1,1,4,3,2,.5", "inverted box: x1 1, y1 4, x2 3, y2 2"),
        ("1,1,2,1,4,.5", "box without area: x1 1, y1 2, x2 1, y2 4; mend the file"),
        ("1,1,4,3,4,.5", "box without area: x1 1, y1 4, x2 3, y2 4"),
        ("1,120,2,130,4,.5", "box wholly outside the 100x50 image: x1 120, y1 2, x2 130, y2 4"),
        ("1,-9,2,0,4,.5", "box wholly outside the 100x50 image: x1 -9"),
        ("1,1,49,3,60,.5", "box wholly outside the 100x50 image: x1 1, y1 49"),
        ("7,1,2,3,4,.5", "frame beyond the sequence: frame 7; the sequence has frames 0..4"),
        ("-1,1,2,3,4,.5", "frame below 0: frame -1"),
        ("0.5,1,2,3,4,.5", "frame is not a whole number: frame 0.5"),
        ("1,1,2,3,4", "5 values where 6 belong"),
        ("1,1,2,3,4,", "score is '', which is no number"),
        ("1,a,2,3,4,1", "x1 is 'a', which is no number"),
    ],
)
def test_bad_rows_are_refused_with_line_value_and_cure(
    tmp_path: Path, row: str, message: str
) -> None:
    path = write(tmp_path / "d.txt", f"0,1,2,3,4,.5\n{row}\n")
    with pytest.raises(BadFile, match=re.escape(f"{path}:2: {message}")) as caught:
        read_detections(path, RRC, SIZE, 5)
    assert "\n" not in str(caught.value)


def test_boxes_that_cannot_overlap_anything_can_be_dropped_and_counted(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = write(tmp_path / "d.txt", "0,1,2,1,4,1\n0,120,2,130,4,1\n0,1,2,3,4,.5\n0,1,2,3,2,1\n")
    with caplog.at_level(logging.WARNING):
        log = read_detections(path, RRC, SIZE, 1, bad_boxes="drop")
    assert log.detections.boxes.tolist() == [[1, 2, 3, 4]]
    assert "2 boxes without area and 1 wholly outside the image are left out" in caplog.text


def test_dropping_forgives_nothing_else(tmp_path: Path) -> None:
    path = write(tmp_path / "d.txt", "0,3,2,1,4,1\n")
    with pytest.raises(BadFile, match="inverted box"):
        read_detections(path, RRC, SIZE, bad_boxes="drop")


def test_a_format_can_drop_by_itself_and_the_caller_can_forbid_it(tmp_path: Path) -> None:
    form = DetectionFormat(RRC.columns, delimiter=",", bad_boxes="drop")
    path = write(tmp_path / "d.txt", "0,1,2,1,4,1\n")
    assert len(read_detections(path, form, SIZE).frames) == 0
    with pytest.raises(BadFile, match=r"leave such boxes out: --drop-bad-boxes"):
        read_detections(path, form, SIZE, bad_boxes="error")


def test_sides_become_corners_and_further_values_are_ignored(tmp_path: Path) -> None:
    form = DetectionFormat(
        ("frame", "id", "left", "top", "width", "height", "score"),
        delimiter=",",
        first_frame=1,
        open_ended=True,
    )
    path = write(tmp_path / "d.txt", "1,-1,10,20,5,6,.5,-1,-1,-1\n3,-1,10,20,5,6,.5,-1,-1,-1\n")
    log = read_detections(path, form, SIZE, 3)
    assert log.frames.tolist() == [0, 2]
    assert log.at(0).boxes.tolist() == [[10, 20, 15, 26]]
    for row, message in {
        "1,-1,10,20,5,6,.5": ":2: 7 values where 10 belong",
        "0,-1,10,20,5,6,.5,1,1,1": ":2: frame below 1",
        "4,-1,10,20,5,6,.5,1,1,1": ":2: frame beyond the sequence: frame 4; .* frames 1..3",
        "1,-1,10,20,-5,6,.5,1,1,1": ":2: inverted box: left 10, top 20, width 5|inverted box",
    }.items():
        write(path, f"1,-1,10,20,5,6,.5,-1,-1,-1\n{row}\n")
        with pytest.raises(BadFile, match=message):
            read_detections(path, form, SIZE, 3)


def test_only_the_wanted_kind_is_kept_and_judged(tmp_path: Path) -> None:
    columns = ("frame", "type", "x1", "y1", "x2", "y2")
    form = DetectionFormat(columns, kinds={"Car": "Car", "Van": "Van"})
    path = write(tmp_path / "d.txt", "0 Car 1 2 3 4\n0 Van 1 2 1 4\n")
    log = read_detections(path, form, SIZE)
    assert log.detections.boxes.tolist() == [[1, 2, 3, 4]]
    assert log.detections.scores.tolist() == [1.0]
    assert log.detections.kinds is None
    numbered = DetectionFormat(columns, kinds={2.0: "Car", 1.0: "Pedestrian"})
    write(path, "0 2 1 2 3 4\n0 1 5 6 7 8\n")
    assert read_detections(path, numbered, SIZE).detections.boxes.tolist() == [[1, 2, 3, 4]]
    both = replace(numbered, tracked=("Car", "Pedestrian"))
    assert list(read_detections(path, both, SIZE).detections.kinds) == ["Car", "Pedestrian"]


def test_labels_stand_for_a_perfect_detector(tmp_path: Path) -> None:
    """17 columns without a score; DontCare regions and other classes are left out."""
    row = "0 3 {} 0 0 -1.5 1 2 30 40 1.5 1.6 3.9 1 1.6 20 -1.5\n"
    path = write(tmp_path / "0000.txt", row.format("Car") + row.format("DontCare"))
    log = read_detections(path, DETECTORS["kitti"], SIZE)
    assert log.detections.boxes.tolist() == [[1, 2, 30, 40]]
    assert log.detections.scores.tolist() == [1.0]


box_rows = st.lists(
    st.tuples(
        st.integers(0, 9), st.floats(0, 90), st.floats(0, 40), st.floats(2, 9), st.floats(2, 9),
        st.floats(-10, 10),
    ),
    max_size=8,
)  # fmt: skip


@given(box_rows)
def test_boxes_inside_the_image_are_read_as_written(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, ...]]
) -> None:
    path = tmp_path_factory.mktemp("rows") / "d.txt"
    corners = [(f, x, y, x + w, y + h, score) for f, x, y, w, h, score in rows]
    path.write_text("".join(",".join(map(repr, row)) + "\n" for row in corners))
    log = read_detections(path, RRC, SIZE, 10)
    expected = np.array(sorted(corners, key=lambda row: row[0])).reshape(-1, 6)
    np.testing.assert_array_equal(log.frames, expected[:, 0])
    np.testing.assert_array_equal(log.detections.boxes, expected[:, 1:5])
    np.testing.assert_array_equal(log.detections.scores, expected[:, 5])


def test_shares_of_the_image_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "d.txt", "0,.08,.48,.11,.56,.9\n1,.08,.48,.11,.56,.9\n")
    said = re.escape(f"{path}:1: all 2 boxes lie within 0..1: normalised boxes?: x1 0.08, y1 0.48")
    with pytest.raises(BadFile, match=said):
        read_detections(path, RRC, SIZE)


def test_a_file_without_the_tracked_class_says_what_it_holds(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rest = "0 0 -10 1 2 30 34 1.5 1.6 4 1 1.6 20 -1.5 .9"
    path = write(tmp_path / "d.txt", f"0 1 Pedestrian {rest}\n1 1 pedestrian {rest}\n")
    assert len(read_detections(path, DETECTORS["kitti"], SIZE).frames) == 0
    assert "holds 2 of Pedestrian, and nothing of Car, which alone is tracked" in caplog.text
    write(path, f"0 1 CAR {rest}\n1 1 car {rest}\n")
    assert len(read_detections(path, DETECTORS["kitti"], SIZE).frames) == 2
    write(path, f"0 1 Car {rest}\n1 1 Vehicle {rest}\n")
    with pytest.raises(BadFile, match=r"d\.txt:2: no class of KITTI: type Vehicle"):
        read_detections(path, DETECTORS["kitti"], SIZE)


# frame, type, box, score, h w l x y z rotation_y, alpha
LIDAR = "0,2,10,5,40,35,3.0,{h},1.6,4.0,2.0,1.65,{z},{ry},-1.0"
POINTRCNN = DETECTORS["pointrcnn"]


def in_camera_0(rows: np.ndarray) -> Cuboids:
    return cuboids_of_rows(rows, np.eye(4))[0]


def lidar_log(folder: Path, *lines: str) -> Detections:
    path = write(folder / "d.txt", "".join(f"{line}\n" for line in lines))
    return read_detections(path, POINTRCNN, SIZE, 3, cuboids=in_camera_0).detections


def test_cuboids_come_with_the_boxes_and_headings_are_wrapped(tmp_path: Path) -> None:
    pedestrian = LIDAR.format(h=1.8, z=9.0, ry=0.0).replace("0,2,", "0,1,", 1)
    found = lidar_log(
        tmp_path, pedestrian, LIDAR.format(h=1.5, z=20.0, ry=-1.5),
        LIDAR.format(h=1.5, z=20.0, ry=4.0),
    )  # fmt: skip
    assert found.base is not None
    assert found.base.tolist() == [[2.0, 1.65, 20.0]] * 2
    assert found.size is not None
    assert found.size.tolist() == [[4.0, 1.5, 1.6]] * 2
    np.testing.assert_allclose(found.yaw, [-1.5, 4.0 - 2 * np.pi])


def test_without_being_asked_for_no_cuboids_are_read(tmp_path: Path) -> None:
    path = write(tmp_path / "d.txt", LIDAR.format(h=1.5, z=20.0, ry=0.0) + "\n")
    found = read_detections(path, POINTRCNN, SIZE, 3).detections
    assert found.base is None
    assert found.yaw is None


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"h": 0.0}, r"d.txt:2: a size that is not positive: h 0, w 1.6, l 4"),
        ({"z": -9.0}, r"d.txt:2: a cuboid wholly behind the camera: z -9"),
        ({"ry": "nan"}, r"d.txt:2: rotation_y is not finite"),
        ({"z": "inf"}, r"d.txt:2: z is not finite"),
    ],
)
def test_cuboids_that_cannot_be_are_refused(tmp_path: Path, changed: dict, told: str) -> None:
    good = {"h": 1.5, "z": 20.0, "ry": 0.0}
    with pytest.raises(BadFile, match=told):
        lidar_log(tmp_path, LIDAR.format(**good), LIDAR.format(**good | changed))


def test_a_format_without_cuboids_says_what_it_lacks(tmp_path: Path) -> None:
    path = write(tmp_path / "d.txt", "0,1,2,3,4,.5\n")
    with pytest.raises(BadConfig, match=r"its format has no h, w, l, x, y, z, rotation_y"):
        read_detections(path, RRC, SIZE, 3, cuboids=in_camera_0)
