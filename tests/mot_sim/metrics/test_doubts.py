"""Results that cannot mean what they seem to: each is named, and sound ones are not."""

import logging
from collections.abc import Callable

import numpy as np
import pytest

from benchmarks.metrics.cases import tracks
from mot_sim.metrics import evaluate_sequence
from mot_sim.metrics.doubts import doubts_of
from tracker.errors import BadTracks
from tracker.types import Tracks

FRAMES = 40


def drive(shift: int = 0, kind: str = "Car", track_id: int = 1) -> Tracks:
    """A car that moves by 12 px a frame; `shift`: the frames are numbered so much later."""
    rows = [
        (frame + shift, track_id, (12.0 * frame, 100.0, 12.0 * frame + 80.0, 160.0), kind)
        for frame in range(FRAMES)
        if 0 <= frame + shift < FRAMES
    ]
    return tracks(rows)


def test_sound_results_raise_no_doubt():
    assert doubts_of(drive(), drive(), FRAMES) == []


@pytest.mark.parametrize("shift", [1, 2, 3, -1, -2, -3])
def test_results_under_other_frame_numbers_are_named(shift: int):
    (said,) = doubts_of(drive(), drive(shift), FRAMES)
    count = f"{abs(shift)} frame{'s' if abs(shift) > 1 else ''}"
    assert f"fit the labels better {count} {'earlier' if shift > 0 else 'later'}" in said


def test_a_parked_car_fits_everywhere_and_is_no_doubt():
    parked = tracks([(frame, 1, (10.0, 10.0, 90.0, 90.0)) for frame in range(FRAMES)])
    assert doubts_of(parked, parked, FRAMES) == []


def test_boxes_that_meet_no_label_are_named():
    far = drive().replaced(boxes=drive().boxes / 1000.0)
    (said,) = doubts_of(drive(), far, FRAMES)
    assert f"none of {FRAMES} boxes meets a label" in said


def test_empty_tables_are_named():
    assert doubts_of(drive(), Tracks.empty(), FRAMES) == ["the results hold no row"]
    assert doubts_of(Tracks.empty(), drive(), FRAMES) == ["the labels hold no row"]


@pytest.mark.parametrize(
    ("output", "said"),
    [
        (drive(kind="van"), f"results hold {FRAMES} of Van, and no Car, which alone is scored"),
        (drive(kind="Pedestrian"), f"results hold {FRAMES} of Pedestrian"),
        (drive(track_id=-1), "results have ids below 0 in all rows of Car"),
    ],
)
def test_rows_of_which_none_is_scored_are_named(
    caplog: pytest.LogCaptureFixture, output: Tracks, said: str
):
    with caplog.at_level(logging.WARNING):
        assert evaluate_sequence(drive(), output, FRAMES)["HOTA"] == 0.0
    assert said in caplog.text


def unchanged(column: np.ndarray) -> np.ndarray:
    """As it is."""
    return column


@pytest.mark.parametrize("kind", ["uint8", "uint64", "int8", "int32", "float32", "float64"])
@pytest.mark.parametrize("order", [unchanged, np.flip, np.random.default_rng(0).permutation])
def test_rows_of_any_number_type_and_order_score_the_same(
    kind: str, order: Callable[[np.ndarray], np.ndarray]
):
    labels, output = drive(), drive().replaced(boxes=drive().boxes + 3.0)
    rows = order(np.arange(FRAMES))
    other = output.select(rows)
    other = other.replaced(frames=other.frames.astype(kind), ids=other.ids.astype(kind))
    right = evaluate_sequence(labels, output, FRAMES).numbers()
    assert evaluate_sequence(labels, other, FRAMES).numbers() == right
    swapped = evaluate_sequence(other, labels, FRAMES).numbers()
    assert swapped == evaluate_sequence(output, labels, FRAMES).numbers()


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        ("frames", np.full(FRAMES, 0.5), r"output: frame 0.5 of row 0 is not a whole number"),
        ("frames", np.full(FRAMES, np.nan), r"output: frame nan of row 0 is not a whole number"),
        ("ids", np.array(["a"] * FRAMES), r"output: ids are of type .*give whole numbers"),
        ("frames", np.full(FRAMES, 2**63, np.uint64), r"output: frame 9223372036854775808"),
        ("boxes", np.zeros((FRAMES, 5)), r"output: boxes of shape \(40, 5\)"),
    ],
)
def test_columns_that_are_no_whole_numbers_are_refused(column: str, value: np.ndarray, said: str):
    with pytest.raises(BadTracks, match=said):
        evaluate_sequence(drive(), drive().replaced(**{column: value}), FRAMES)
