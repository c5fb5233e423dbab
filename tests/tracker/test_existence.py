"""The probability of existence: what newborns, hits and misses are worth."""

from typing import NamedTuple

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, beliefs_at
from tracker.errors import BadConfig
from tracker.existence import DetectorStatistics, ExistenceFilter
from tracker.geometry import covered_share
from tracker.lifecycle import ActiveTracks, Partners
from tracker.types import Detections

DT = 0.1
CLEAN, CLUTTERED = DetectorStatistics(950, 1000, 190, 200), DetectorStatistics(800, 1000, 40, 200)


def tracks(existence: list[float], hits: int = 9, unseen: float = DT) -> ActiveTracks:
    """Tracks side by side, in the middle of the image."""
    n = len(existence)
    beliefs = beliefs_at(*[(2.0 * i, 20.0) for i in range(n)])
    innovations = np.full((n, 4), np.nan)
    return ActiveTracks(
        np.arange(n),
        beliefs,
        np.full(n, unseen),
        np.full(n, hits),
        np.array(existence),
        innovations,
        np.full(n, np.nan if unseen else 0.9),
    )


class After(NamedTuple):
    """The probabilities of the tracks that were seen and lost, and of newborns."""

    matched: np.ndarray
    unmatched: np.ndarray
    born: np.ndarray
    detector: DetectorStatistics


def after_frame(
    statistics: DetectorStatistics = DetectorStatistics(),
    seen: ActiveTracks | None = None,
    lost: ActiveTracks | None = None,
    scores: list[float] | None = None,
    born: list[float] | None = None,
    boxes: np.ndarray | None = None,
    existence_filter: ExistenceFilter = ExistenceFilter(),
) -> After:
    """What the filter makes of tracks that were seen and lost, and of newborns, in a step."""
    none = tracks([])
    seen, lost = none if seen is None else seen, none if lost is None else lost
    given = np.full(len(seen), 0.9) if scores is None else np.array(scores)
    fresh = np.array([] if born is None else born, float)
    others = np.zeros((0, 4)) if boxes is None else boxes
    k, b, n = len(given), len(fresh), len(seen) + len(lost)
    # those of the tracks and newborns cover nothing
    found = Detections(
        np.concatenate((np.zeros((k + b, 4)), others)),
        np.concatenate((given, fresh, np.zeros(len(others)))),
    )
    partners = Partners(np.arange(k), np.arange(k), np.arange(k, n), k + np.arange(b))
    everyone = ActiveTracks.concatenate((seen, lost))
    after = existence_filter(statistics, everyone, partners, found, DT, LEVEL)
    return After(after.tracks[:k], after.tracks[k:], after.born, after.detector)


def test_a_miss_is_bayes_rule() -> None:
    """P(exists | missed) = e (1 - P_D) / (1 - e P_D), by hand with P_D = .8."""
    existence_filter = ExistenceFilter(detection_prior=1e-9)
    statistics = DetectorStatistics(hits=80, tries=100)
    lost = tracks([0.9], hits=2)  # of which nothing is learned
    after = after_frame(statistics, lost=lost, existence_filter=existence_filter).unmatched
    np.testing.assert_allclose(after, 0.9 * 0.2 / (1.0 - 0.9 * 0.8))


def test_who_is_hidden_cannot_be_missed() -> None:
    lost = tracks([0.9, 0.9])
    nearer = lost.beliefs.boxes[:1] + [-5.0, -5.0, 5.0, 5.0]
    after = after_frame(CLEAN, lost=lost, boxes=nearer).unmatched
    np.testing.assert_allclose(after[0], 0.9)
    assert after[1] < 0.5


def test_a_hit_never_says_less_than_a_first_detection() -> None:
    update = after_frame(CLEAN, tracks([1e-6, 0.5]), scores=[0.9, 0.9], born=[0.9])
    np.testing.assert_allclose(update.matched[0], update.born[0])
    assert update.matched[1] > 0.9


def test_newborns_of_a_clean_detector_are_written_at_once_of_a_cluttered_one_later() -> None:
    existence_filter = ExistenceFilter()
    clean = tracks(after_frame(CLEAN, born=[0.95]).born.tolist(), hits=1, unseen=0.0)
    doubtful = tracks(after_frame(CLUTTERED, born=[0.95]).born.tolist(), hits=1, unseen=0.0)
    assert existence_filter.written(clean).tolist() == [True]
    assert existence_filter.written(doubtful).tolist() == [False]
    again = after_frame(CLUTTERED, doubtful, scores=[0.95]).matched
    twice = tracks(again.tolist(), hits=2, unseen=0.0)
    assert existence_filter.written(twice).tolist() == [True]


def test_a_prediction_is_written_for_a_while_and_never_after_one_hit() -> None:
    existence_filter = ExistenceFilter()
    assert existence_filter.written(tracks([0.9, 0.9], unseen=0.3)).all()
    assert not existence_filter.written(tracks([0.9], unseen=3.0)).any()
    assert not existence_filter.written(tracks([0.999], hits=1, unseen=0.1)).any()


def test_the_statistics_count_hits_misses_and_newborns_once() -> None:
    statistics = after_frame(seen=tracks([0.9, 0.9]), lost=tracks([0.9])).detector
    assert statistics == DetectorStatistics(hits=2, tries=3, confirmed=0, newborns=0)
    young = tracks([0.5], hits=1)
    statistics = after_frame(seen=young, lost=young).detector
    assert statistics == DetectorStatistics(hits=0, tries=0, confirmed=1, newborns=2)
    late = tracks([0.5], hits=1, unseen=5 * DT)
    assert after_frame(seen=late, lost=late).detector == DetectorStatistics()


def test_hidden_and_leaving_cars_tell_nothing_of_the_detector() -> None:
    lost = tracks([0.9, 0.9])
    lost.beliefs.boxes[1] = [0.0, 150.0, 50.0, 200.0]
    nearer = lost.beliefs.boxes[:1] + [-5.0, -5.0, 5.0, 5.0]
    assert after_frame(lost=lost, boxes=nearer).detector == DetectorStatistics()


@pytest.mark.parametrize(
    "wrong",
    [
        {"threshold": 1.0},
        {"detection_probability": 0.0},
        {"mean_lifetime": 0.0},
        {"birth_prior": np.inf},
    ],
)
def test_settings_that_are_no_probabilities_or_times_are_refused(wrong) -> None:
    with pytest.raises(BadConfig, match=next(iter(wrong))):
        ExistenceFilter(**wrong)


@pytest.mark.parametrize(
    "statistics", [DetectorStatistics(), CLEAN, CLUTTERED, DetectorStatistics(0, 10**6, 0, 10**6)]
)
def test_probabilities_stay_probabilities(statistics) -> None:
    existence, scores = tracks([0.0, 1e-9, 0.5, 0.999]), [0.0, 1.0, 5.0, 0.3]
    update = after_frame(statistics, existence, existence, scores, scores)  # scores beyond 1 are
    for values in (update.matched, update.unmatched, update.born):  # no reason to fail
        assert ((values >= 0.0) & (values < 1.0)).all()


def test_only_what_ends_lower_in_the_image_covers() -> None:
    car = np.array([[100.0, 100, 200, 200]])
    nearer = np.array([[150.0, 100, 300, 260]])
    assert covered_share(car, nearer).tolist() == [0.5]
    assert covered_share(nearer, car).tolist() == [0.0]
    assert covered_share(car, np.zeros((0, 4))).tolist() == [0.0]
    assert covered_share(np.zeros((0, 4)), car).shape == (0,)


def test_a_newborn_that_leaves_is_no_clutter() -> None:
    """One stands in plain view and vanishes, one at the border is leaving."""
    young = tracks([0.9, 0.9], hits=1)
    young.beliefs.boxes[1] = [0.0, 150.0, 50.0, 200.0]
    assert after_frame(lost=young).detector == DetectorStatistics(newborns=1)


def test_a_newborn_is_predicted_where_nothing_looks_until_it_was_missed() -> None:
    young = tracks([0.95], hits=1, unseen=0.3)
    assert ExistenceFilter().written(young, since_look=0.3).all()
    assert not ExistenceFilter().written(young, since_look=0.2).any()
