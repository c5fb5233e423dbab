"""What the truth says of tracks, held against the metrics' own counts."""

import numpy as np

from mot_sim.metrics import evaluate_sequence
from mot_sim.metrics.verdicts import Verdicts
from tracker.types import Tracks

BOX = np.array([10.0, 10.0, 70.0, 60.0])
OTHER = BOX + 200.0
FAR = BOX + 500.0


def tracks(rows: list[tuple[int, int, np.ndarray]], kinds: list[str] | None = None) -> Tracks:
    frames, ids, boxes = zip(*rows, strict=True)
    named = None if kinds is None else np.array(kinds)
    return Tracks(np.array(frames), np.array(ids), np.array(boxes), kinds=named)


TRUTH = tracks(
    [(0, 1, BOX), (0, 2, OTHER), (1, 1, BOX), (1, 2, OTHER), (1, 5, FAR), (2, 1, BOX)],
    ["Car", "Car", "Car", "Car", "Van", "Car"],
)
OUTPUT = tracks([(0, 7, BOX), (1, 8, BOX), (1, 9, FAR + 300.0), (1, 4, FAR), (2, 8, BOX + 2.0)])


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
    truth = tracks([(f, i, BOX + 90.0 * i) for f in range(30) for i in range(5)])
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
