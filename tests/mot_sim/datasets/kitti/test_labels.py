"""Label files as tracks, and back to the last printed digit."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.datasets.kitti.labels import read_labels, write_labels
from tests.mot_sim.datasets.conftest import LABELS, write
from tracker.errors import BadFile, BadTracks
from tracker.geometry import homogeneous
from tracker.types import Camera, Cuboids, Tracks

K = np.array([[100.0, 0, 50], [0, 100, 20], [0, 0, 1]])
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
        st.integers(0, 3), *[coordinates] * 5, *[st.floats(0.1, 20)] * 3,
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
