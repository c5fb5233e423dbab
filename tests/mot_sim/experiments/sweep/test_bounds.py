"""Bounds of scores: which way they hold, and which cannot be."""

import pytest

from mot_sim.experiments.sweep.bounds import Bound, bounds_of
from mot_sim.metrics import evaluate_sequence
from tracker import Tracks
from tracker.errors import BadConfig, TrackingError, UnknownName


@pytest.mark.parametrize(
    ("metric", "score", "holds"),
    [
        ("MOTA", 0.5, True), ("MOTA", 0.49, False), ("MT", 1.0, True), ("CLR_TP", 0.0, False),
        ("IDSW", 0.5, True), ("IDSW", 0.51, False), ("CLR_FP", 0.6, False), ("ML", 0.0, True),
    ],
)  # fmt: skip
def test_rates_and_finds_are_at_least_mistakes_at_most(
    metric: str, score: float, holds: bool
) -> None:
    assert Bound(metric, 0.5).holds(score) is holds


def test_scores_go_by_small_letters_titles_and_trackevals_names() -> None:
    found = bounds_of({"mota": 0.1, "fp": 3, "CLR_Re": 0.5, "precision": 0.2, "assa": 0.3})
    assert [each.metric for each in found] == ["MOTA", "CLR_FP", "CLR_Re", "CLR_Pr", "AssA"]
    assert [each.word for each in found] == ["at least", "at most", *["at least"] * 3]


def test_every_score_knows_its_direction() -> None:
    """A perfect output must keep the best possible bound of every mistake: 0."""
    truth = Tracks.empty()
    scores = evaluate_sequence(truth, truth, 1).numbers()
    mistakes = [name for name in scores if Bound(name, 0.0).is_upper]
    assert {"IDSW", "CLR_FP", "CLR_FN", "Frag", "ML", "IDFP", "IDFN"} <= {*mistakes}
    assert not {"HOTA", "MOTA", "CLR_TP", "MT", "IDTP", "IDF1", "MOTP"} & {*mistakes}


@pytest.mark.parametrize(
    ("wanted", "error", "told"),
    [
        ({}, BadConfig, "no bound"),
        ({"motta": 0.5}, UnknownName, "Did you mean 'mota'"),
        ({"hota": 80}, BadConfig, r"rates are fractions, 0\.8\?"),
        ({"idsw": float("nan")}, BadConfig, "give a number"),
        ({"idsw": True}, BadConfig, "give a number"),
    ],
)
def test_bounds_that_cannot_be_are_refused(
    wanted: dict, error: type[TrackingError], told: str
) -> None:
    with pytest.raises(error, match=told):
        bounds_of(wanted)
