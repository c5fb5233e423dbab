"""The probability of existence: what newborns, hits and misses are worth."""

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, beliefs_at
from tracker.errors import BadConfig
from tracker.existence import DetectorStatistics, ExistenceFilter, covered_share
from tracker.lifecycle import ActiveTracks

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


def test_a_miss_is_bayes_rule() -> None:
    """P(exists | missed) = e (1 - P_D) / (1 - e P_D), by hand with P_D = .8."""
    existence_filter = ExistenceFilter(detection_prior=1e-9)
    after = existence_filter.miss(
        tracks([0.9]), np.zeros(1), DetectorStatistics(hits=80, tries=100)
    )
    np.testing.assert_allclose(after, 0.9 * 0.2 / (1.0 - 0.9 * 0.8))


def test_who_is_hidden_cannot_be_missed() -> None:
    after = ExistenceFilter().miss(tracks([0.9, 0.9]), np.array([1.0, 0.0]), CLEAN)
    np.testing.assert_allclose(after[0], 0.9)
    assert after[1] < 0.5


def test_a_hit_never_says_less_than_a_first_detection() -> None:
    existence_filter = ExistenceFilter()
    after = existence_filter.hit(tracks([1e-6, 0.5]), np.array([0.9, 0.9]), CLEAN)
    np.testing.assert_allclose(after[0], existence_filter.newborn(np.array([0.9]), CLEAN)[0])
    assert after[1] > 0.9


def test_newborns_of_a_clean_detector_are_written_at_once_of_a_cluttered_one_later() -> None:
    existence_filter, scores = ExistenceFilter(), np.array([0.95])
    clean = tracks([float(existence_filter.newborn(scores, CLEAN)[0])], hits=1, unseen=0.0)
    doubtful = tracks([float(existence_filter.newborn(scores, CLUTTERED)[0])], hits=1, unseen=0.0)
    assert existence_filter.written(clean).tolist() == [True]
    assert existence_filter.written(doubtful).tolist() == [False]
    twice = tracks(existence_filter.hit(doubtful, scores, CLUTTERED).tolist(), hits=2, unseen=0.0)
    assert existence_filter.written(twice).tolist() == [True]


def test_a_prediction_is_written_for_a_while_and_never_after_one_hit() -> None:
    existence_filter = ExistenceFilter()
    assert existence_filter.written(tracks([0.9, 0.9], unseen=0.3)).all()
    assert not existence_filter.written(tracks([0.9], unseen=3.0)).any()
    assert not existence_filter.written(tracks([0.999], hits=1, unseen=0.1)).any()


def test_the_statistics_count_hits_misses_and_newborns_once() -> None:
    existence_filter = ExistenceFilter()
    seen, lost = tracks([0.9, 0.9]), tracks([0.9])
    statistics = existence_filter.learn(DetectorStatistics(), seen, lost, np.zeros(1), DT, LEVEL)
    assert statistics == DetectorStatistics(hits=2, tries=3, confirmed=0, newborns=0)
    young = tracks([0.5], hits=1)
    statistics = existence_filter.learn(DetectorStatistics(), young, young, np.zeros(1), DT, LEVEL)
    assert statistics == DetectorStatistics(hits=0, tries=0, confirmed=1, newborns=2)
    late = tracks([0.5], hits=1, unseen=5 * DT)
    assert (
        existence_filter.learn(DetectorStatistics(), late, late, np.zeros(1), DT, LEVEL)
        == DetectorStatistics()
    )


def test_hidden_and_leaving_cars_tell_nothing_of_the_detector() -> None:
    lost = tracks([0.9, 0.9])
    lost.beliefs.boxes[1] = [0.0, 150.0, 50.0, 200.0]
    statistics = ExistenceFilter().learn(
        DetectorStatistics(), tracks([]), lost, np.array([0.9, 0.0]), DT, LEVEL
    )
    assert statistics == DetectorStatistics()


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
    existence_filter, existence = ExistenceFilter(), tracks([0.0, 1e-9, 0.5, 0.999])
    scores = np.array([0.0, 1.0, 5.0, 0.3])  # scores beyond 1 are no reason to fail
    for values in (
        existence_filter.hit(existence, scores, statistics),
        existence_filter.miss(existence, np.array([0.0, 0.3, 0.7, 1.0]), statistics),
        existence_filter.newborn(scores, statistics),
    ):
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
    none = tracks([])
    learned = ExistenceFilter().learn(DetectorStatistics(), none, young, np.zeros(2), DT, LEVEL)
    assert learned == DetectorStatistics(newborns=1)


def test_a_newborn_is_predicted_where_nothing_looks_until_it_was_missed() -> None:
    young = tracks([0.95], hits=1, unseen=0.3)
    assert ExistenceFilter().written(young, since_look=0.3).all()
    assert not ExistenceFilter().written(young, since_look=0.2).any()
