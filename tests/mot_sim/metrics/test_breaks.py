"""Switches and fragments one by one: as many as the metrics count, where they are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.metrics import evaluate_sequence
from mot_sim.metrics.breaks import Breaks, Matches, Verdicts, box_of, counted_cars
from tracker.types import Tracks

BOX = np.array([100.0, 100.0, 180.0, 160.0])
PLACE = np.array([10.0, 10.0, 70.0, 60.0])
OTHER = PLACE + 200.0
FAR = PLACE + 500.0


def tracks(rows: list[tuple[int, int, float]], **columns: object) -> Tracks:
    """Rows (frame, id, place): boxes of one size, so many pixels to the right."""
    frames, ids, places = (np.array(column) for column in zip(*rows, strict=True))
    boxes = BOX + np.array([1.0, 0.0, 1.0, 0.0]) * places[:, None].astype(float)
    return Tracks(frames.astype(np.int64), ids.astype(np.int64), boxes, **columns)  # type: ignore[arg-type]


def random_drive(rng: np.random.Generator) -> tuple[Tracks, Tracks, int]:
    """A few cars, vans and hidden ones, and an output that misses, swaps and invents."""
    count = int(rng.integers(1, 30))
    rows = [
        (frame, car, 200.0 * car + rng.normal(0.0, 3.0))
        for frame in range(count)
        for car in range(4)
        if rng.random() < 0.9
    ] or [(0, 0, 0.0)]
    truth = tracks(
        rows,
        kinds=np.where(rng.random(len(rows)) < 0.1, "Van", "Car"),
        truncation=(rng.random(len(rows)) < 0.05).astype(np.int64),
        occlusion=rng.integers(0, 4, len(rows)),
    )
    names = rng.permutation(8)
    given = [
        (frame, int(names[(car + (rng.random() < 0.1)) % 8]), place + rng.normal(0.0, 20.0))
        for frame, car, place in rows
        if rng.random() < 0.8
    ]
    unique = {(frame, name): (frame, name, place) for frame, name, place in given}
    output = tracks(list(unique.values())) if unique else Tracks.empty()
    return truth, output, count


@given(st.integers(0, 10_000))
def test_the_sums_are_idsw_and_frag_of_the_metrics(seed: int) -> None:
    truth, output, count = random_drive(np.random.default_rng(seed))
    scores = evaluate_sequence(truth, output, count)
    breaks = Breaks.of(Matches.of(truth, output, count))
    assert int(breaks.switched.sum()) == scores["IDSW"]
    assert int(breaks.broken.sum()) == scores["Frag"]
    assert (breaks.switched | breaks.broken).all()


def test_a_switch_and_a_fragment_are_where_they_happen() -> None:
    truth = tracks([(frame, 5, 0.0) for frame in range(10)])
    output = tracks(
        [(frame, 7, 0.0) for frame in (0, 1, 2, 4)] + [(frame, 9, 0.0) for frame in (5, 6, 7, 8, 9)]
        # Something else in every frame, so that no frame is without output.
        + [(frame, 1, 500.0) for frame in range(10)]
    )  # fmt: skip
    breaks = Breaks.of(Matches.of(truth, output.select(np.argsort(output.frames)), 10))
    assert breaks.before.tolist() == [2, 4]
    assert breaks.frames.tolist() == [4, 5]
    assert breaks.cars.tolist() == [5, 5]
    assert breaks.old_track_ids.tolist() == [7, 7]
    assert breaks.track_ids.tolist() == [7, 9]
    assert breaks.switched.tolist() == [False, True]
    assert breaks.broken.tolist() == [True, False]
    assert breaks.weight.tolist()[1] == 4  # frames under 7; under 9 there are five
    assert len(breaks.switches) == 1


@pytest.mark.parametrize("rows", [[], [(0, 1, 0.0)]])
def test_nothing_breaks_without_two_matches(rows: list[tuple[int, int, float]]) -> None:
    there = tracks(rows) if rows else Tracks.empty()
    for truth, output in ((there, there), (there, Tracks.empty()), (Tracks.empty(), there)):
        assert len(Breaks.of(Matches.of(truth, output, 3))) == 0


def test_only_labels_that_count_are_counted() -> None:
    truth = tracks(
        [(0, 1, 0.0), (0, 2, 200.0), (0, 3, 400.0)],
        kinds=np.array(["Car", "Van", "Car"]), occlusion=np.array([0, 0, 3]),
    )  # fmt: skip
    assert counted_cars(truth, 1).ids.tolist() == [1]
    assert box_of(truth, 2, 0) is not None
    assert box_of(truth, 2, 1) is None


def labelled(rows: list[tuple[int, int, np.ndarray]], kinds: list[str] | None = None) -> Tracks:
    frames, ids, boxes = zip(*rows, strict=True)
    named = None if kinds is None else np.array(kinds)
    return Tracks(np.array(frames), np.array(ids), np.array(boxes), kinds=named)


TRUTH = labelled(
    [(0, 1, PLACE), (0, 2, OTHER), (1, 1, PLACE), (1, 2, OTHER), (1, 5, FAR), (2, 1, PLACE)],
    ["Car", "Car", "Car", "Car", "Van", "Car"],
)
OUTPUT = labelled(
    [(0, 7, PLACE), (1, 8, PLACE), (1, 9, FAR + 300.0), (1, 4, FAR), (2, 8, PLACE + 2.0)]
)


def test_a_hand_made_case_is_told_row_by_row() -> None:
    verdicts = Verdicts.of(TRUTH, OUTPUT, 3)
    assert verdicts.found.frames.tolist() == [0, 1, 2]
    assert list(zip(verdicts.missed.frames, verdicts.missed.ids, strict=True)) == [(0, 2), (1, 2)]
    assert verdicts.neutral.ids.tolist() == [5]
    assert verdicts.false.ids.tolist() == [9]  # 4 lies on the van: neither right nor wrong
    assert verdicts.switches.frames.tolist() == [1]
    assert (verdicts.switches.old_track_ids.tolist(), verdicts.switches.track_ids.tolist()) == (
        [7],
        [8],
    )


def test_the_rows_are_as_many_as_the_metrics_count() -> None:
    rng = np.random.default_rng(4)
    truth = labelled([(f, i, PLACE + 90.0 * i) for f in range(30) for i in range(5)])
    kept = truth.select(rng.random(len(truth)) > 0.2)
    ids = np.where(rng.random(len(kept)) > 0.8, kept.ids + 10, kept.ids)
    shift = rng.normal(0.0, 8.0, (len(kept), 4))
    output = Tracks(kept.frames, ids, kept.boxes + shift)
    verdicts, scores = Verdicts.of(truth, output, 30), evaluate_sequence(truth, output, 30)
    assert len(verdicts.found) == scores["CLR_TP"] > 0
    assert len(verdicts.missed) == scores["CLR_FN"] > 0
    assert len(verdicts.false) == scores["CLR_FP"] > 0
    assert len(verdicts.switches) == scores["IDSW"] > 0


def test_without_tracks_all_is_missed_and_without_truth_all_is_false() -> None:
    nobody = Tracks.empty()
    assert len(Verdicts.of(TRUTH, nobody, 3).missed) == 5
    assert len(Verdicts.of(nobody, OUTPUT, 3).false) == len(OUTPUT)
    assert not len(Verdicts.of(nobody, nobody, 3).switches)
