"""Tracks as tables of boxes: what is written is read back to the same rows."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.datasets import read_results, tracks_of_boxes, write_lines, write_results
from mot_sim.datasets.box_writers import BOX_WRITERS
from tracker.errors import BadTracks
from tracker.types import Tracks

# A corner in hundredths of a pixel, and how far away the other one is: no normalised boxes.
PLACES = st.tuples(st.integers(-5_000, 200_000), st.integers(200, 90_000))
ROWS = st.lists(
    st.tuples(st.integers(0, 9), st.integers(0, 9), PLACES, PLACES, st.integers(0, 1000)),
    unique_by=lambda row: row[:2],
    max_size=8,
)


def tracks_of(rows: list, kinds: tuple[str, ...]) -> Tracks:
    """Rows as hypothesis makes them, in the order of frames."""
    rows = sorted(rows)
    boxes = [(x, y, x + w, y + h) for _, _, (x, w), (y, h), _ in rows]
    return Tracks(
        np.array([row[0] for row in rows], dtype=np.int64),
        np.array([row[1] for row in rows], dtype=np.int64),
        np.array(boxes, dtype=float).reshape(-1, 4) / 100.0,
        np.array([row[4] for row in rows], dtype=float) / 1000.0,
        np.array([kinds[row[4] % len(kinds)] for row in rows], dtype="U10"),
    )


def same(read: Tracks, written: Tracks, atol: float) -> None:
    order = np.lexsort((read.ids, read.frames))
    read = read.select(order)
    assert read.frames.tolist() == written.frames.tolist()
    assert read.ids.tolist() == written.ids.tolist()
    np.testing.assert_allclose(read.boxes, written.boxes, rtol=0.0, atol=atol)
    assert read.scores is not None
    np.testing.assert_allclose(read.scores, written.scores, rtol=0.0, atol=1e-8)
    assert written.kinds is not None
    kinds = ["Car"] * len(read) if read.kinds is None else read.kinds.tolist()
    assert kinds == written.kinds.tolist()


@settings(max_examples=30, deadline=None)
@given(rows=ROWS)
@pytest.mark.parametrize(
    ("form", "kinds", "first_id", "atol"),
    [
        ("csv", ("Car", "Pedestrian", "Cyclist"), 0, 0.0),
        ("coco", ("Car", "Pedestrian"), 0, 1e-9),
        ("mot", ("Car", "Pedestrian", "Cyclist"), 1, 1e-5),
    ],
)
def test_what_is_written_is_read_back(
    form: str, kinds: tuple[str, ...], first_id: int, atol: float, rows: list
) -> None:
    tracks = tracks_of(rows, kinds)
    writer = BOX_WRITERS[form]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"drive{writer.suffix}"
        write_lines(path, writer.lines(tracks))
        read = tracks_of_boxes(path)
    same(read, tracks.replaced(ids=tracks.ids + first_id), atol)


@settings(max_examples=30, deadline=None)
@given(rows=ROWS)
def test_rows_of_kitti_are_read_back_by_both_readers(rows: list) -> None:
    tracks = tracks_of(rows, ("Car", "Pedestrian", "Cyclist"))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.txt"
        write_results(tracks, path)
        same(read_results(path), tracks, 1e-5)
        same(tracks_of_boxes(path), tracks, 1e-5)


def test_coco_has_no_cyclists() -> None:
    tracks = tracks_of([(0, 1, (0, 100), (0, 100), 0)], ("Cyclist",))
    with pytest.raises(BadTracks, match="COCO has no class Cyclist"):
        list(BOX_WRITERS["coco"].lines(tracks))
