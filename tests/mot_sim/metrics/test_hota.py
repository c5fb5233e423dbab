"""HOTA where it can be worked out by hand."""

import numpy as np
import pytest

from benchmarks.metrics.cases import tracks
from mot_sim.metrics import ALPHAS, Hota, evaluate_sequence
from mot_sim.metrics.hota import alignment
from mot_sim.metrics.matching import Overlaps

BOX = (0.0, 0.0, 40.0, 30.0)
FAR = (500.0, 0.0, 540.0, 40.0)
PARKED = [(frame, 1, BOX) for frame in range(4)]


def hota(labels: list[tuple], output: list[tuple]) -> Hota:
    """HOTA by TrackEval's rules over ten frames."""
    scores = evaluate_sequence(tracks(labels), tracks(output), 10).hota
    assert scores is not None
    return scores


def test_alphas_are_nineteen():
    np.testing.assert_allclose(ALPHAS, np.arange(1, 20) / 20.0)


def test_a_name_changed_halfway_halves_the_association():
    # Each match shares two frames with its track of four: 2 / (4 + 2 - 2).
    scores = hota(PARKED, [(0, 5, BOX), (1, 5, BOX), (2, 6, BOX), (3, 6, BOX)])
    np.testing.assert_allclose(scores.AssA, 0.5)
    np.testing.assert_allclose(scores.AssRe, 0.5)
    np.testing.assert_allclose(scores.AssPr, 1.0)
    np.testing.assert_allclose(scores.DetA, 1.0)
    np.testing.assert_allclose(scores.HOTA, np.sqrt(0.5))
    np.testing.assert_allclose(scores.OWTA, np.sqrt(0.5))


def test_a_missed_frame_costs_detection_and_association():
    scores = hota(PARKED, [(frame, 5, BOX) for frame in range(3)])
    np.testing.assert_allclose(scores.DetRe, 0.75)
    np.testing.assert_allclose(scores.DetPr, 1.0)
    np.testing.assert_allclose(scores.AssA, 0.75)
    np.testing.assert_allclose(scores.HOTA, 0.75)


def test_stricter_alphas_drop_a_loose_match():
    scores = hota([(0, 1, BOX)], [(0, 5, (0.0, 0.0, 40.0, 60.0))])  # overlap 1/2
    np.testing.assert_array_equal(scores.HOTA_TP, ALPHAS < 0.51)
    np.testing.assert_array_equal(scores.HOTA_FP, ALPHAS > 0.51)
    np.testing.assert_allclose(scores.LocA, np.where(ALPHAS < 0.51, 0.5, 1.0))
    assert scores.numbers()["HOTA"] == pytest.approx(10 / 19)
    assert scores.numbers()["HOTALocA(0)"] == pytest.approx(0.5)


def test_a_frame_is_matched_by_the_ids_that_go_together_elsewhere():
    # In frame 0 box 6 fits better, but 5 is the label's partner in all other frames.
    near = (2.0, 0.0, 42.0, 30.0)
    output = [(0, 5, near), (0, 6, BOX), *((frame, 5, BOX) for frame in range(1, 4))]
    scores = hota(PARKED, output)
    assert scores.HOTA_TP[0] == 4
    assert scores.AssA[0] == 1.0


def test_alignment_of_tracks_that_never_meet_others_is_their_shared_time():
    labels, output = PARKED, [(frame, 5, BOX) for frame in range(2)]
    everything = np.ones(4, dtype=bool), np.ones(2, dtype=bool)
    overlaps = Overlaps.between(tracks(labels), tracks(output)).keep(*everything)
    np.testing.assert_allclose(alignment(overlaps), 2 / (4 + 2 - 2))


def test_association_is_averaged_over_all_matches_when_combined():
    switched = hota(PARKED, [(0, 5, BOX), (1, 5, BOX), (2, 6, BOX), (3, 6, BOX)])
    perfect = hota(PARKED * 1, PARKED)
    none = hota([], [(0, 5, FAR)])
    both = Hota.combine([switched, perfect, none])
    np.testing.assert_allclose(both.AssA, 0.75)
    np.testing.assert_allclose(both.DetA, 8 / 9)
    np.testing.assert_allclose(both.LocA, 1.0)


@pytest.mark.parametrize(
    ("labels", "output"), [([], []), (PARKED, []), ([], PARKED), (PARKED, [(0, 5, FAR)])]
)
def test_without_a_match_hota_is_zero_and_the_overlap_one(labels: list, output: list):
    scores = hota(labels, output)
    assert scores.HOTA_FN.tolist() == [len(labels)] * 19
    assert scores.HOTA_FP.tolist() == [len(output)] * 19
    assert not scores.HOTA.any()
    assert (scores.LocA == 1.0).all()
