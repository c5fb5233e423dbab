"""CLEAR on cases small enough to count on fingers."""

import numpy as np
import pytest

from benchmarks.metrics.cases import tracks
from mot_sim.metrics import Clear, Scores, evaluate_sequence

BOX = (0.0, 0.0, 40.0, 30.0)
FAR = (500.0, 0.0, 540.0, 40.0)
PARKED = [(frame, 1, BOX) for frame in range(4)]


def clear(labels: list[tuple], output: list[tuple]) -> Clear:
    """CLEAR scores by TrackEval's rules over ten frames."""
    scores: Scores = evaluate_sequence(tracks(labels), tracks(output), 10)
    assert isinstance(scores.clear, Clear)
    return scores.clear


def test_one_id_switch_costs_one_of_four():
    scores = clear(PARKED, [(0, 5, BOX), (1, 5, BOX), (2, 6, BOX), (3, 6, BOX)])
    assert (scores.IDSW, scores.CLR_TP, scores.CLR_FP, scores.CLR_FN) == (1, 4, 0, 0)
    assert scores.MOTA == 0.75
    assert scores.MODA == 1.0
    assert scores.MOTP == 1.0
    assert scores.MTR == 1.0


def test_a_switch_counts_across_a_gap():
    assert clear(PARKED, [(0, 5, BOX), (3, 6, BOX)]).IDSW == 1


def test_a_name_that_goes_over_to_another_label_switches_both():
    labels = [*PARKED, *((frame, 2, FAR) for frame in range(4))]
    output = [(0, 5, BOX), (0, 6, FAR), (1, 6, BOX), (1, 5, FAR)]
    assert clear(labels, output).IDSW == 2


def test_one_gap_is_one_fragment_and_one_miss():
    others = [(frame, 2, FAR) for frame in range(4)]
    output = [(frame, 5, BOX) for frame in (0, 2, 3)]
    scores = clear([*PARKED, *others], [*output, *((frame, 7, FAR) for frame in range(4))])
    assert (scores.Frag, scores.CLR_FN, scores.IDSW) == (1, 1, 0)


def test_a_frame_without_any_output_makes_no_fragment():
    scores = clear(PARKED, [(frame, 5, BOX) for frame in (0, 2, 3)])
    assert (scores.Frag, scores.CLR_FN) == (0, 1)


def test_a_name_is_kept_although_another_box_fits_better():
    near = (5.0, 0.0, 45.0, 30.0)
    scores = clear(PARKED[:2], [(0, 5, BOX), (1, 5, near), (1, 6, BOX)])
    assert (scores.IDSW, scores.CLR_FP) == (0, 1)
    assert scores.MOTP_sum == pytest.approx(1.0 + 35.0 / 45.0)


def test_a_name_is_kept_over_an_empty_frame():
    near = (5.0, 0.0, 45.0, 30.0)
    assert clear(PARKED[:3], [(0, 5, BOX), (2, 5, near), (2, 6, BOX)]).IDSW == 0


def test_an_overlap_of_exactly_half_is_a_match():
    scores = clear([(0, 1, BOX)], [(0, 5, (0.0, 0.0, 40.0, 60.0))])
    assert (scores.CLR_TP, scores.MOTP) == (1, 0.5)


@pytest.mark.parametrize(
    ("found", "verdict"), [(10, "MT"), (9, "MT"), (8, "PT"), (2, "PT"), (1, "ML"), (0, "ML")]
)
def test_tracks_are_judged_by_the_part_that_is_tracked(found: int, verdict: str):
    labels = [(frame, 1, BOX) for frame in range(10)]
    output = [(frame, 5, BOX) for frame in range(found)] + [(0, 9, FAR)]
    scores = clear(labels, output)
    assert {"MT": scores.MT, "PT": scores.PT, "ML": scores.ML}[verdict] == 1
    assert scores.MT + scores.PT + scores.ML == 1


def test_logarithm_softens_the_switches():
    output = [(frame, frame, BOX) for frame in range(4)]
    softened = clear(PARKED, output).numbers()
    assert softened["IDSW"] == 3
    assert softened["MOTAL"] == pytest.approx(1.0 - np.log10(3) / 4.0)


def test_false_alarms_pull_below_zero():
    scores = clear(
        [(0, 1, BOX)], [(0, name, FAR) for name in range(1)] + [(1, 5, FAR), (2, 5, FAR)]
    )
    assert scores.MOTA == -3.0
    assert scores.FP_per_frame == 0.3
    assert scores.CLR_F1 == 0.0


def test_output_alone_scores_nothing_alone_but_counts_in_the_sum():
    alone = clear([], [(0, 5, BOX), (1, 5, BOX)])
    assert (alone.CLR_FP, alone.MOTA, alone.MLR, alone.CLR_Frames) == (2, 0.0, 1.0, 0)
    both = Clear.combine([alone, clear(PARKED, [(frame, 5, BOX) for frame in range(4)])])
    assert (both.CLR_FP, both.MOTA, both.MLR) == (2, 0.5, 0.0)


def test_labels_alone_are_lost():
    alone = clear(PARKED, [])
    assert (alone.CLR_FN, alone.ML, alone.MOTA, alone.MLR) == (4, 1, 0.0, 1.0)


def test_nothing_scores_nothing():
    scores = clear([], [])
    assert (scores.CLR_TP, scores.CLR_FP, scores.CLR_FN, scores.MOTP) == (0, 0, 0, 0.0)
