"""One name, one number; and sequences put together."""

import json

import pytest

from benchmarks.metrics.cases import random_case
from mot_sim.metrics import Scores, combine, evaluate_sequence
from tracker.errors import BadConfig, UnknownName


def scores_of(seed: int, rules: str = "trackeval") -> Scores:
    """Scores of one random case."""
    case = random_case(seed)
    return evaluate_sequence(case.truth, case.output, case.frame_count, rules)


def test_a_score_is_found_by_its_name():
    scores = scores_of(5)
    assert scores.hota is not None
    assert scores["HOTA"] == scores.hota.HOTA.mean()
    assert scores["MOTA"] == scores.clear.MOTA


def test_an_unknown_score_names_its_neighbour():
    with pytest.raises(UnknownName, match="Did you mean 'MOTA'"):
        scores_of(5)["MTOA"]


@pytest.mark.parametrize("rules", ["trackeval", "devkit2018"])
def test_scores_are_plain_numbers_for_json(rules: str):
    scores = scores_of(5, rules)
    as_dict = scores.as_dict()
    assert json.loads(json.dumps(as_dict)) == as_dict
    assert all(type(number) in (int, float) for number in scores.numbers().values())


def test_values_over_alpha_come_as_lists():
    by_alpha = scores_of(5).as_dict()["by_alpha"]
    assert {len(values) for values in by_alpha.values()} == {19}


def test_nothing_cannot_be_combined():
    with pytest.raises(BadConfig, match="at least one"):
        combine([])


def test_scores_of_different_rules_cannot_be_combined():
    with pytest.raises(BadConfig, match="same rules"):
        combine([scores_of(5), scores_of(5, "devkit2018")])
