"""KITTI's `h w l x y z rotation_y` against our cuboids."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.datasets.kitti.labels import (
    NO_CUBOID,
    NO_CUBOID_DONT_CARE,
    alpha_of,
    cuboids_of_rows,
    read_labels,
    read_results,
    rows_of_cuboids,
    write_labels,
    write_results,
)
from tests.mot_sim.datasets.conftest import LABELS, write
from tracker.errors import BadFile, BadTracks
from tracker.geometry import homogeneous, wrap_angle
from tracker.types import Camera, Cuboids, Tracks

K = np.array([[100.0, 0, 50], [0, 100, 20], [0, 0, 1]])
LEVEL = Camera.mounted(K, (100, 40), 1.65)
ROW = np.array([[1.5, 1.6, 4.0, 1.0, 1.65, 20.0, -1.55]])


def test_a_label_on_the_road_becomes_a_cuboid_on_the_road() -> None:
    T_road_label = LEVEL.T_road_cam @ homogeneous(None, np.array([0.06, 0.0, 0.0]))
    cuboids, known = cuboids_of_rows(ROW, T_road_label)
    assert known.tolist() == [True]
    np.testing.assert_allclose(cuboids.base, [[1.06, 0.0, 20.0]], atol=1e-12)
    assert cuboids.size.tolist() == [[4.0, 1.5, 1.6]]
    assert cuboids.yaw.tolist() == [-1.55]
    np.testing.assert_allclose(rows_of_cuboids(cuboids, T_road_label), ROW, atol=1e-12)


def test_alpha_is_the_yaw_seen_from_the_camera() -> None:
    row = np.array([[1.0, 1, 1, 10.0, 0, 10.0, 1.0]])
    np.testing.assert_allclose(alpha_of(row), [1.0 - np.pi / 4])


def test_a_car_driving_away_from_a_pitched_camera_still_drives_away() -> None:
    pitched = Camera.mounted(K, (100, 40), 1.65, pitch=0.3)
    away = np.array([[1.5, 1.6, 4.0, 0.0, 1.65, 20.0, -np.pi / 2]])
    cuboids, _ = cuboids_of_rows(away, pitched.T_road_cam)
    np.testing.assert_allclose(cuboids.yaw, [-np.pi / 2], atol=1e-12)
    # A camera that looks up sees road points lower than a level one does.
    level, _ = cuboids_of_rows(away, LEVEL.T_road_cam)
    assert cuboids.base[0, 1] < level.base[0, 1]


def test_rows_without_a_size_have_no_cuboid() -> None:
    rows = np.array([NO_CUBOID, NO_CUBOID_DONT_CARE, ROW[0]])
    cuboids, known = cuboids_of_rows(rows, LEVEL.T_road_cam)
    assert known.tolist() == [False, False, True]
    assert np.isnan(cuboids.base[:2]).all()
    assert np.isnan(cuboids.yaw[:2]).all()
    assert np.isnan(rows_of_cuboids(cuboids, LEVEL.T_road_cam)[:2]).all()


def test_each_part_of_a_cuboid_that_is_not_known_is_left_open() -> None:
    rows = np.repeat(ROW, 3, axis=0)
    rows[0, 6] = -10.0
    rows[1, :3] = -1.0
    rows[2, 3:6] = -1000.0
    cuboids, known = cuboids_of_rows(rows, LEVEL.T_road_cam)
    assert known.tolist() == [True, True, False]
    assert np.isnan(cuboids.yaw).tolist() == [True, False, True]
    assert np.isnan(cuboids.size).all(axis=1).tolist() == [False, True, True]
    assert np.isnan(cuboids.base).any(axis=1).tolist() == [False, False, True]


@pytest.mark.parametrize("nothing", [-1.0, 0.0])
def test_what_other_tools_write_for_nothing_is_no_cuboid(nothing: float) -> None:
    cuboids, known = cuboids_of_rows(np.full((1, 7), nothing), LEVEL.T_road_cam)
    assert known.tolist() == [False]
    assert np.isnan(cuboids.base).all()


def test_what_is_known_of_a_cuboid_is_written_and_read_back(tmp_path: Path) -> None:
    cuboids, _ = cuboids_of_rows(np.repeat(ROW, 4, axis=0), LEVEL.T_road_cam)
    hole = np.array([1.0, np.nan, 1.0, 1.0])
    partly = Cuboids(
        cuboids.base * np.array([1.0, 1.0, 1.0, np.nan])[:, None],
        cuboids.yaw * hole,
        cuboids.size * np.array([1.0, np.nan, np.nan, 1.0])[:, None],
    )
    tracks = Tracks(np.arange(4), np.zeros(4, np.int64), np.tile([0.0, 0, 9, 9], (4, 1)),
                    cuboids=partly)  # fmt: skip
    write_results(tracks, tmp_path / "r.txt", LEVEL.T_road_cam)
    lines = (tmp_path / "r.txt").read_text().splitlines()
    assert [float(value) for value in lines[1].split()[10:17]] == [-1, -1, -1, 1, 1.65, 20, -10]
    found = read_results(tmp_path / "r.txt", LEVEL.T_road_cam).cuboids
    assert found is not None
    np.testing.assert_allclose(found.base[:3], partly.base[:3], atol=1e-6)
    np.testing.assert_allclose(found.yaw[:3], partly.yaw[:3], atol=1e-6)
    np.testing.assert_allclose(found.size[:3], partly.size[:3], atol=1e-6)
    assert np.isnan(found.base[3]).all()


def test_no_rows_are_no_cuboids() -> None:
    cuboids, known = cuboids_of_rows(np.zeros((0, 7)), LEVEL.T_road_cam)
    assert len(cuboids) == len(known) == 0
    assert rows_of_cuboids(cuboids, LEVEL.T_road_cam).shape == (0, 7)


@given(
    st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-10.0, 10.0), st.floats(-30, 30),
    st.floats(1, 80),
)  # fmt: skip
def test_reading_inverts_writing_for_every_mounting(
    pitch: float, roll: float, yaw: float, x: float, z: float
) -> None:
    T_road_label = Camera.mounted(K, (100, 40), 1.65, pitch, roll).T_road_cam
    row = np.array([[1.5, 1.6, 4.0, x, 1.65, z, yaw]])
    again = rows_of_cuboids(cuboids_of_rows(row, T_road_label)[0], T_road_label)
    np.testing.assert_allclose(again[:, :6], row[:, :6], atol=1e-9)
    assert abs(wrap_angle(float(again[0, 6] - yaw))) < 1e-9


T_ROAD_LABEL = Camera.mounted(K, (100, 40), 1.65).T_road_cam @ homogeneous(
    None, np.array([0.06, 0.001, 0.003])
)
CAR = LABELS.splitlines()[1]


def test_labels_become_tracks(tmp_path: Path) -> None:
    tracks = read_labels(write(tmp_path / "0000.txt", LABELS), T_ROAD_LABEL, 3)
    assert tracks.frames.tolist() == [0, 0, 2]
    assert tracks.ids.tolist() == [-1, 7, 7]
    assert tracks.kinds is not None
    assert tracks.kinds.tolist() == ["DontCare", "Car", "Car"]
    assert tracks.boxes[1].tolist() == [40, 10, 60, 30]
    assert tracks.truncation is not None
    assert tracks.truncation.tolist() == [-1, 0, 0]
    assert tracks.occlusion is not None
    assert tracks.occlusion.tolist() == [-1, 1, 0]
    assert tracks.scores is None
    assert tracks.cuboids is not None
    assert np.isnan(tracks.cuboids.base[0]).all()
    assert tracks.cuboids.size[1].tolist() == [4.0, 1.5, 1.6]
    np.testing.assert_allclose(tracks.cuboids.base[1], [1.06, 0.001, 20.003], atol=1e-12)


def test_written_labels_have_every_digit_but_alpha_of_those_read(tmp_path: Path) -> None:
    path = write(tmp_path / "0000.txt", LABELS)
    write_labels(read_labels(path, T_ROAD_LABEL), tmp_path / "again.txt", T_ROAD_LABEL)
    for line, again in zip(
        LABELS.splitlines(), (tmp_path / "again.txt").read_text().splitlines(), strict=True
    ):
        values, values_again = line.split(), again.split()
        assert values_again[:5] + values_again[6:] == values[:5] + values[6:]


def test_without_a_frame_for_them_cuboids_are_neither_read_nor_written(tmp_path: Path) -> None:
    path = write(tmp_path / "0000.txt", LABELS)
    assert read_labels(path).cuboids is None
    write_labels(read_labels(path, T_ROAD_LABEL), path)
    assert path.read_text().splitlines()[1].split()[5:] == [
        "-10.000000", "40.000000", "10.000000", "60.000000", "30.000000",
        *["-1.000000"] * 3, *["-1000.000000"] * 3, "-10.000000",
    ]  # fmt: skip


def test_an_empty_label_file_is_no_track(tmp_path: Path) -> None:
    tracks = read_labels(write(tmp_path / "0000.txt", ""), T_ROAD_LABEL)
    assert len(tracks) == 0
    write_labels(tracks, tmp_path / "again.txt", T_ROAD_LABEL)
    assert (tmp_path / "again.txt").read_text() == ""


def test_rows_are_brought_into_the_order_of_frames(tmp_path: Path) -> None:
    path = write(tmp_path / "0000.txt", "\n".join(reversed(LABELS.splitlines())))
    tracks = read_labels(path)
    assert tracks.frames.tolist() == [0, 0, 2]
    assert tracks.ids.tolist() == [7, -1, 7]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (CAR, "an id twice in a frame: frame 0, id 7; an id names one object"),
        (CAR.rsplit(" ", 1)[0], "16 values where 17 belong"),
        (CAR.replace("40.000000", "nan"), "x1 is not finite"),
        (CAR.replace("40.000000", "70.000000"), "inverted box: x1 70"),
        (CAR.replace("20.000000", "inf"), "z is not finite"),
        (CAR.replace("0 7 Car", "3 7 Car"), r"frame beyond the sequence: frame 3; .* 0\.\.2"),
        (CAR.replace("0 7 Car", "-1 7 Car"), "frame below 0"),
        (CAR.replace("0 7 Car", "1 -2 Car"), "id below -1"),
        (CAR.replace("0 7 Car 0", "1 7 Car 0.5"), "truncated is not a whole number"),
        (CAR.replace("0 7 Car", "1 Car 7"), "id is 'Car', which is no number"),
    ],
)
def test_bad_labels_are_refused_with_their_line(tmp_path: Path, line: str, message: str) -> None:
    path = write(tmp_path / "0000.txt", f"{LABELS}{line}\n")
    with pytest.raises(BadFile, match=re.escape(f"{path}:4: ") + message):
        read_labels(path, T_ROAD_LABEL, 3)


def test_bad_tracks_are_not_written(tmp_path: Path) -> None:
    twice = Tracks(np.array([1, 1]), np.array([2, 2]), np.zeros((2, 4)))
    with pytest.raises(BadTracks, match=r"0000.txt: id 2 stands twice in frame 1"):
        write_labels(twice, tmp_path / "0000.txt")
    nan = Tracks(np.array([1]), np.array([2]), np.full((1, 4), np.nan))
    with pytest.raises(BadTracks, match=r"0000.txt: box of row 0 is not finite"):
        write_labels(nan, tmp_path / "0000.txt")
    assert list(tmp_path.iterdir()) == []


coordinates = st.floats(-100, 100)
label_rows = st.lists(
    st.tuples(
        st.integers(0, 20), st.sampled_from(["Car", "Van", "Person_sitting"]), st.integers(0, 2),
        st.integers(0, 3), *[coordinates] * 5, *[st.floats(2, 20)] * 3,
    ),
    max_size=6,
)  # fmt: skip


@given(label_rows)
def test_written_tracks_are_read_back(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple]
) -> None:
    path = tmp_path_factory.mktemp("labels") / "0000.txt"
    numbers = np.array([row[4:] for row in rows]).reshape(-1, 8)
    order = np.argsort([row[0] for row in rows], kind="stable") if rows else np.zeros(0, int)
    tracks = Tracks(
        np.array([row[0] for row in rows], dtype=np.int64),
        np.arange(len(rows)),
        np.column_stack([numbers[:, :2], numbers[:, :2] + numbers[:, 5:7]]),
        None,
        np.array([row[1] for row in rows], dtype="U16"),
        np.array([row[2] for row in rows], dtype=np.int64),
        np.array([row[3] for row in rows], dtype=np.int64),
        Cuboids(numbers[:, 2:5], numbers[:, 0] / 32.0, numbers[:, 5:]),
    )
    write_labels(tracks, path, T_ROAD_LABEL)
    again, expected = read_labels(path, T_ROAD_LABEL), tracks.select(order)
    for name in ("frames", "ids", "kinds", "truncation", "occlusion"):
        np.testing.assert_array_equal(getattr(again, name), getattr(expected, name))
    np.testing.assert_allclose(again.boxes, expected.boxes, atol=6e-7)
    assert again.cuboids is not None
    assert expected.cuboids is not None
    np.testing.assert_allclose(again.cuboids.base, expected.cuboids.base, atol=6e-7)
    np.testing.assert_allclose(again.cuboids.yaw, expected.cuboids.yaw, atol=6e-7)
    np.testing.assert_allclose(again.cuboids.size, expected.cuboids.size, atol=6e-7)


BOXES = np.array([[10.0, 20, 30, 40], [1, 2, 3, 4]])


def test_rows_are_what_the_server_wants(tmp_path: Path) -> None:
    path = tmp_path / "0000.txt"
    write_results(Tracks(np.array([4, 0]), np.array([2, 0]), BOXES, np.array([0.5, -3.25])), path)
    assert path.read_text().splitlines() == [
        "0 0 Car -1 -1 -10.000000 1.000000 2.000000 3.000000 4.000000 -1.000000 -1.000000 "
        "-1.000000 -1000.000000 -1000.000000 -1000.000000 -10.000000 -3.25",
        "4 2 Car -1 -1 -10.000000 10.000000 20.000000 30.000000 40.000000 -1.000000 -1.000000 "
        "-1.000000 -1000.000000 -1000.000000 -1000.000000 -10.000000 0.5",
    ]


def test_cuboids_are_written_in_camera_0_with_alpha(tmp_path: Path) -> None:
    path = tmp_path / "0000.txt"
    base = np.array([[1.06, 0.001, 20.003], [np.nan] * 3])
    cuboids = Cuboids(base, np.array([-1.55, np.nan]), np.array([[4, 1.5, 1.6], [np.nan] * 3]))
    write_results(
        Tracks(np.array([0, 0]), np.array([1, 2]), BOXES, cuboids=cuboids), path, T_ROAD_LABEL
    )
    with_cuboid, without = (line.split() for line in path.read_text().splitlines())
    assert [float(value) for value in with_cuboid[10:]] == [1.5, 1.6, 4, 1, 1.65, 20, -1.55, 1]
    assert float(with_cuboid[5]) == pytest.approx(-1.55 - np.arctan2(1.0, 20.0), abs=1e-6)
    assert without[5] == "-10.000000"
    again = read_results(path, T_ROAD_LABEL)
    assert again.cuboids is not None
    np.testing.assert_allclose(again.cuboids.base, base, atol=1e-6)


def test_results_without_any_cuboid_have_no_such_column(tmp_path: Path) -> None:
    path = tmp_path / "0000.txt"
    write_results(Tracks(np.array([0, 1]), np.array([1, 1]), BOXES), path)
    assert read_results(path, T_ROAD_LABEL).cuboids is None


def test_the_authors_rows_count_frames_from_1(tmp_path: Path) -> None:
    path = write(tmp_path / "r.txt", "2 1 1 2 3 4 0.9\n1 1 141.59 185.78 217.75 218.82 0.9\n")
    tracks = read_results(path, frame_count=2)
    assert tracks.frames.tolist() == [0, 1]
    assert tracks.ids.tolist() == [1, 1]
    assert tracks.boxes.tolist() == [[141.59, 185.78, 217.75, 218.82], [1, 2, 3, 4]]
    assert tracks.scores is not None
    assert tracks.scores.tolist() == [0.9, 0.9]
    assert tracks.kinds is None


def test_rows_without_a_score_are_read(tmp_path: Path) -> None:
    row = "0 1 Car -1 -1 -10 1 2 3 4 -1 -1 -1 -1000 -1000 -1000 -10\n"
    assert read_results(write(tmp_path / "r.txt", row)).scores is None


def test_an_empty_result_is_no_track(tmp_path: Path) -> None:
    write_results(Tracks.empty(), tmp_path / "r.txt")
    assert (tmp_path / "r.txt").read_text() == ""
    assert len(read_results(tmp_path / "r.txt")) == 0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 1 1 2 3 4 .9\n2 1 1 2 3 4 .9\n1 1 5 6 7 8 .9\n", ":3: an id twice .* frame 1, id 1"),
        ("0 1 1 2 3 4 .9\n", ":1: frame below 1: frame 0"),
        ("1 1 1 2 3 4 .9\n4 1 1 2 3 4 .9\n", r":2: frame beyond the sequence: frame 4; .* 1\.\.3"),
        ("1 1 1 2 3 4 nan\n", ":1: score is not finite"),
        ("1 1 1 2 3 4 .9\n1 2 1 2 3\n", ":2: 5 values where 7 belong"),
        ("1 1 1 2 3 4 .9 1\n", ":1: no known format has 8 values a row"),
        ("1 1 3 2 1 4 .9\n", ":1: inverted box"),
    ],
)
def test_bad_results_are_refused_with_file_and_line(
    tmp_path: Path, text: str, message: str
) -> None:
    path = write(tmp_path / "r.txt", text)
    with pytest.raises(BadFile, match=re.escape(str(path)) + message):
        read_results(path, frame_count=3)


def test_bad_tracks_are_not_written_and_leave_the_old_file(tmp_path: Path) -> None:
    path = write(tmp_path / "r.txt", "old")
    with pytest.raises(BadTracks, match=r"r.txt: id 1 stands twice in frame 0"):
        write_results(Tracks(np.array([0, 0]), np.array([1, 1]), BOXES), path)
    with pytest.raises(BadTracks, match=r"r.txt: score of row 1 is not finite: nan"):
        write_results(
            Tracks(np.array([0, 0]), np.array([1, 2]), BOXES, np.array([1.0, np.nan])), path
        )
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@given(
    st.lists(
        st.tuples(st.integers(0, 50), *[st.floats(0, 2000)] * 4, st.floats(-1e6, 1e6)), max_size=6
    )
)
def test_written_results_are_read_back(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, ...]]
) -> None:
    path = tmp_path_factory.mktemp("results") / "r.txt"
    table = np.array(sorted(rows, key=lambda row: row[0])).reshape(-1, 6)
    boxes = np.hstack([table[:, 1:3], table[:, 1:3] + table[:, 3:5]])
    tracks = Tracks(table[:, 0].astype(np.int64), np.arange(len(rows)), boxes, table[:, 5])
    write_results(tracks, path)
    again = read_results(path)
    np.testing.assert_array_equal(again.frames, tracks.frames)
    np.testing.assert_array_equal(again.ids, tracks.ids)
    np.testing.assert_allclose(again.boxes, boxes, atol=6e-7)
    assert again.scores is not None
    np.testing.assert_allclose(again.scores, table[:, 5], rtol=1e-8)
