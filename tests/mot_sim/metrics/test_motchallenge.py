"""MOTChallenge's rules: TrackEval's scores, and what each rule is for."""

import json

import numpy as np
import pytest

from benchmarks.metrics.compare_motchallenge import CASES, FRAMES, GOLDEN_FILE, made_case
from mot_sim.metrics.motchallenge import motchallenge_scores
from tracker.errors import BadTracks, UnknownName
from tracker.types import Tracks

GOLDEN = json.loads(GOLDEN_FILE.read_text())["rows"]


@pytest.mark.parametrize("seed", range(CASES))
def test_made_cases_score_as_trackeval_says(seed: int) -> None:
    case = made_case(seed)
    scores = motchallenge_scores(case.truth, case.classes, case.counted, case.output, FRAMES)
    golden = GOLDEN[f"case-{seed:02d}"]
    ours = {name: scores[name] for name in golden}
    assert ours == pytest.approx(golden, rel=0.0, abs=1e-9)


BOXES = np.array([[0, 0, 20, 40], [100, 0, 120, 40], [200, 0, 220, 40.0]])
ALL = Tracks(np.zeros(3, np.int64), np.arange(3), BOXES)


def scored(classes: list[int], counted: list[bool], kind: str = "Pedestrian") -> tuple[float, ...]:
    """Hits, misses and false positives where every label is answered."""
    scores = motchallenge_scores(ALL, np.array(classes), np.array(counted), ALL, 1, kind)
    return tuple(scores[name] for name in ("CLR_TP", "CLR_FN", "CLR_FP"))


def test_distractors_take_their_answers_with_them_and_other_classes_do_not() -> None:
    assert scored([1, 1, 1], [True] * 3) == (3, 0, 0)
    assert scored([1, 8, 7], [True, False, False]) == (1, 0, 0)
    assert scored([1, 3, 1], [True, True, True]) == (2, 0, 1)
    assert scored([1, 1, 1], [True, False, True]) == (2, 0, 1)
    assert scored([1, 3, 8], [True, True, True], "Car") == (1, 0, 1)
    assert scored([2, 3, 8], [True, True, True], "Cyclist") == (1, 0, 1)


def test_output_of_another_class_is_left_out() -> None:
    output = ALL.replaced(kinds=np.array(["Pedestrian", "car", "PEDESTRIAN"]))
    classes, counted = np.array([1, 1, 1]), np.ones(3, bool)
    scores = motchallenge_scores(ALL, classes, counted, output, 1)
    assert (scores["CLR_TP"], scores["CLR_FN"], scores["CLR_FP"]) == (2, 1, 0)


def test_what_cannot_be_scored_is_named() -> None:
    with pytest.raises(UnknownName, match="class 'Tram'"):
        scored([1, 1, 1], [True] * 3, "Tram")
    with pytest.raises(BadTracks, match="3 labels, 2 classes and 3 marks"):
        scored([1, 1], [True] * 3)
