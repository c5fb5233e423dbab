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


def test_scores_of_cuboids_are_bounded_by_their_names() -> None:
    found = bounds_of({"mota3d@2m": 0.6, "centre_median": 1.0, "samota@0.25": 0.1, "motp@2m": 1.5})
    assert [each.metric for each in found] == [
        "MOTA3D@2m",
        "centre_median",
        "sAMOTA@0.25",
        "MOTP@2m",
    ]
    assert [each.is_upper for each in found] == [False, True, False, True]
    assert all(each.is_spatial for each in found)
    assert not bounds_of({"mota": 0.1})[0].is_spatial


@pytest.mark.parametrize(
    "name", ["heading_over_90_moving", "IDSW@0.5", "CLR_FP@2m", "radial_median"]
)
def test_errors_and_mistakes_of_cuboids_are_at_most(name: str) -> None:
    assert bounds_of({name: 0.5})[0].word == "at most"


@pytest.mark.parametrize("name", ["MOTP@0.5", "within_2m", "heading_known_true", "LocA3D"])
def test_what_is_good_in_3d_is_at_least(name: str) -> None:
    assert not Bound(name, 0.5).is_upper


@pytest.mark.parametrize("name", ["centre_nees", "speed_inside_2_sigma", "matched_rows", "PTR@0.5"])
def test_scores_whose_ideal_lies_between_have_no_bound(name: str) -> None:
    with pytest.raises(BadConfig, match=f"bound {name}: neither more nor less of it is better"):
        bounds_of({name: 0.5})


def test_rates_in_3d_are_fractions() -> None:
    with pytest.raises(BadConfig, match=r"rates are fractions, 0\.6"):
        bounds_of({"MOTA3D@2m": 60})
    assert bounds_of({"motp@2m": 1.5})[0].value == 1.5  # metres
