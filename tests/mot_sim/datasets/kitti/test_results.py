"""Result files: KITTI's rows and the authors'."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.datasets.kitti.results import read_results, write_results
from tests.mot_sim.datasets.conftest import write
from tests.mot_sim.datasets.kitti.test_labels import T_ROAD_LABEL
from tracker.errors import BadFile, BadTracks
from tracker.types import Cuboids, Tracks

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
