"""The development kit's own way of counting, one habit a test."""

import json
from pathlib import Path

import pytest

from benchmarks.metrics.cases import tracks
from mot_sim.metrics import Devkit2018, evaluate, evaluate_sequence
from tests.mot_sim.metrics.kitti_results import golden_results

GOLDEN_FILE = Path(__file__).parents[2] / "golden" / "metrics_devkit2018.json"
GOLDEN = json.loads(GOLDEN_FILE.read_text())
BOX = (0.0, 0.0, 40.0, 30.0)
FAR = (500.0, 0.0, 540.0, 40.0)
PARKED = [(frame, 1, BOX) for frame in range(5)]


def kit(labels: list[tuple], output: list[tuple]) -> Devkit2018:
    """Scores by the development kit's rules over ten frames."""
    scores = evaluate_sequence(tracks(labels), tracks(output), 10, "devkit2018")
    assert scores.hota is None
    assert scores.identity is None
    assert isinstance(scores.clear, Devkit2018)
    return scores.clear


def test_matches_to_neutral_labels_count_as_found_but_not_as_labels():
    labels = [(0, 1, BOX), (0, 2, FAR, "Van"), (1, 1, BOX)]
    scores = kit(labels, [(0, 5, BOX), (0, 6, FAR)])
    assert (scores.CLR_TP, scores.CLR_FN, scores.CLR_FP, scores.GT_Dets) == (2, 1, 0, 2)
    assert scores.MOTA == 0.5
    assert scores.CLR_Re == pytest.approx(2 / 3)


def test_missed_neutral_labels_are_no_misses():
    scores = kit([(0, 1, BOX, "Car", 1, 0), (0, 2, FAR, "Car", 0, 3), *PARKED[1:]], [(1, 5, BOX)])
    assert (scores.CLR_TP, scores.CLR_FN, scores.GT_Dets) == (1, 3, 4)


def test_low_boxes_and_those_in_dont_care_are_ignored():
    region = (0, -1, (19.0, 0.0, 90.0, 90.0), "DontCare", -1, -1)
    low = (600.0, 0.0, 640.0, 25.0)
    assert kit([region], [(0, 5, BOX), (0, 6, low), (0, 7, FAR)]).CLR_FP == 1


def test_a_switch_needs_two_neighbouring_matches():
    assert kit(PARKED, [(frame, 5 + (frame > 2), BOX) for frame in range(5)]).IDSW == 1
    assert kit(PARKED, [(0, 5, BOX), (1, 5, BOX), (3, 6, BOX), (4, 6, BOX)]).IDSW == 0


def test_a_neutral_row_makes_the_kit_forget_the_name():
    labels = [(frame, 1, BOX, "Car", int(frame == 2), 0) for frame in range(5)]
    scores = kit(labels, [(frame, 5 + (frame > 2), BOX) for frame in range(5)])
    assert (scores.IDSW, scores.Frag) == (0, 0)


def test_a_gap_is_a_fragment_when_the_next_row_is_matched_too():
    assert kit(PARKED, [(frame, 5, BOX) for frame in (0, 1, 3, 4)]).Frag == 1
    assert kit(PARKED, [(frame, 5, BOX) for frame in (0, 1, 3)]).Frag == 0


def test_a_track_found_only_in_its_last_row_is_a_fragment():
    assert kit(PARKED, [(4, 5, BOX)]).Frag == 1
    assert kit(PARKED, [(3, 5, BOX), (4, 5, BOX)]).Frag == 0


def test_no_name_is_kept_for_its_own_sake():
    near = (5.0, 0.0, 45.0, 30.0)
    scores = kit(PARKED[:3], [(0, 5, BOX), (1, 5, near), (1, 6, BOX), (2, 6, BOX)])
    assert (scores.IDSW, scores.CLR_FP) == (1, 1)


def test_three_loose_pairs_go_before_two_tight_ones():
    # Each box is half of the next: labels 1, 2, 4 and output 2, 4, 8 parts high.
    heights = {part: (0.0, 0.0, 40.0, 20.0 * part) for part in (1, 2, 4, 8)}
    labels = [(0, part, heights[part]) for part in (1, 2, 4)]
    scores = kit(labels, [(0, part, heights[part]) for part in (2, 4, 8)])
    assert (scores.CLR_TP, scores.MOTP_sum) == (3, 1.5)


def test_tracks_are_judged_by_their_rows_that_are_not_neutral():
    labels = [(frame, 1, BOX, "Car", int(1 <= frame <= 4), 0) for frame in range(10)]
    scores = kit(labels, [(frame, 5, BOX) for frame in (0, 5, 6, 7, 8)])
    assert (scores.MT, scores.PT, scores.ML) == (1, 0, 0)  # 5 of 6


def test_a_match_on_a_neutral_first_row_counts_as_tracked():
    labels = [(frame, 1, BOX, "Car", int(frame == 0), 0) for frame in range(6)]
    scores = kit(labels, [(0, 5, BOX)])
    assert (scores.MT, scores.PT, scores.ML) == (0, 1, 0)  # 1 of 5


def test_tracks_that_are_always_neutral_are_not_judged():
    scores = kit([(frame, 1, BOX, "Van") for frame in range(5)], [(0, 5, BOX)])
    assert (scores.MT, scores.PT, scores.ML, scores.MTR, scores.MOTA) == (0, 0, 0, 0.0, 0.0)


@pytest.mark.parametrize(("labels", "output"), [([], []), (PARKED, []), ([], PARKED)])
def test_one_side_alone_is_all_errors(labels: list, output: list):
    scores = kit(labels, output)
    assert scores.CLR_TP == 0
    counts = scores.CLR_FN, scores.CLR_FP
    assert counts == (len(labels), len(output))
    assert (scores.MOTA, scores.MOTP, scores.MOTAL) == (0.0, 0.0, 0.0)


@pytest.mark.kitti
@pytest.mark.parametrize("tracker", sorted(GOLDEN))
def test_the_given_sequences_score_as_the_kit_prints(kitti_root: Path, tracker: str):
    scores = evaluate(golden_results(kitti_root, tracker), "devkit2018").combined
    percent = {"MOTA": "MOTA", "MOTP": "MOTP", "Re": "CLR_Re", "Pr": "CLR_Pr"}
    percent |= {"MT": "MTR", "PT": "PTR", "ML": "MLR"}
    counts = {"TP": "CLR_TP", "FP": "CLR_FP", "FN": "CLR_FN", "IDS": "IDSW", "FRAG": "Frag"}
    ours = {printed: round(100.0 * scores[name], 2) for printed, name in percent.items()}
    ours |= {printed: scores[name] for printed, name in counts.items()}
    assert ours == GOLDEN[tracker]
