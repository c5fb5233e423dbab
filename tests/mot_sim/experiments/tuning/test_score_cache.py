"""Scores on disk: what comes back can be combined to the last digit."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.experiments.score_cache import ScoreCache, as_plain, of_plain
from mot_sim.metrics import RULES, Scores, combine, evaluate_sequence
from tracker.types import Tracks


def scores(rules: str, ids: list[int]) -> Scores:
    """Of a drive of three frames with one car, whose output bears these ids."""
    boxes = np.array([[10.0, 10, 60, 60]] * 3)
    truth = Tracks(np.arange(3), np.zeros(3, np.int64), boxes)
    return evaluate_sequence(truth, Tracks(np.arange(3), np.array(ids), boxes + 1.0), 3, rules)


@pytest.mark.parametrize("rules", sorted(RULES))
def test_scores_that_were_kept_combine_like_those_that_were_not(rules: str, tmp_path: Path) -> None:
    parts = {"a": scores(rules, [1, 1, 1]), "b": scores(rules, [1, 2, 2])}
    kept = ScoreCache(tmp_path)
    kept.write("abcd", parts, {"why": "test"})
    found = kept.read("abcd")
    assert found is not None
    assert combine(list(found.values())).numbers() == combine(list(parts.values())).numbers()
    assert as_plain(of_plain(as_plain(parts["b"]))) == as_plain(parts["b"])


def test_what_is_not_there_or_damaged_is_none(tmp_path: Path) -> None:
    kept = ScoreCache(tmp_path)
    assert kept.read("abcd") is None
    kept.write("abcd", {"a": scores("trackeval", [1, 1, 1])}, {})
    text = kept.files.path("abcd").read_text()
    kept.files.path("abcd").write_text(text[: len(text) // 2])
    assert kept.read("abcd") is None
    kept.files.path("abcd").write_text(text.replace('"CLR_TP": 3', '"CLR_TP": 2'))
    assert kept.read("abcd") is None
