"""Births, coasting, deaths, ids."""

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, beliefs_at
from tracker.lifecycle import ActiveTracks, Lifecycle, in_view


def unseen_for(*unseen: float) -> ActiveTracks:
    """Tracks 10, 11, ... that were not seen for so long, side by side 20 m ahead."""
    n = len(unseen)
    beliefs = beliefs_at(*[(2.0 * i, 20.0) for i in range(n)])
    ids, times, innovations = np.arange(10, 10 + n), np.array(unseen), np.full((n, 4), np.nan)
    scores = np.where(times > 0.0, np.nan, 0.9)
    return ActiveTracks(ids, beliefs, times, np.full(n, 3), np.full(n, 0.9), innovations, scores)


def test_those_seen_again_keep_their_ids_and_count_one_hit_more() -> None:
    before = unseen_for(0.1, 0.4)
    updated = beliefs_at((4.0, 20.0), (0.0, 30.0))
    scores = np.array([0.8, 0.9])
    seen = before.seen_again(updated, scores, np.array([0.5, 0.7]), np.zeros((2, 4)))
    assert seen.ids.tolist() == [10, 11]
    assert seen.time_since_update.tolist() == [0.0, 0.0]
    assert seen.hits.tolist() == [4, 4]
    assert seen.existence.tolist() == [0.5, 0.7]
    np.testing.assert_array_equal(seen.beliefs.cuboids.base[:, 0], [4.0, 0.0])


def test_births_take_consecutive_ids_in_the_order_of_detections() -> None:
    observed = beliefs_at((0.0, 20.0), (3.0, 20.0))
    born = ActiveTracks.born(observed, np.array([0.9, 0.95]), np.array([0.4, 0.8]), next_id=7)
    assert born.ids.tolist() == [7, 8]
    assert born.hits.tolist() == [1, 1]
    assert born.existence.tolist() == [0.4, 0.8]
    assert np.isnan(born.innovations).all()


def test_the_unseen_are_remembered_up_to_the_longest_gap() -> None:
    lost = unseen_for(0.5, 1.0, 1.1)
    assert Lifecycle(max_gap=1.0).living(lost, LEVEL).ids.tolist() == [10, 11]


def test_a_gap_is_not_shorter_for_the_rounding_of_its_steps() -> None:
    """Thirty steps of a tenth are three seconds, also where they sum to a little more."""
    times = (np.arange(500)[:, None] + np.arange(31)) / 10
    gaps = np.add.accumulate(np.diff(times), axis=1)[:, -1]
    assert gaps.max() > 3.0
    for gap in {gaps.min(), gaps.max()}:
        three_seconds = Lifecycle(max_gap=3.0).living(unseen_for(gap), LEVEL)
        assert three_seconds.ids.tolist() == [10]


def test_who_is_seen_lives_on_even_outside_the_view() -> None:
    everyone = unseen_for(0.0, 0.1, 0.0)
    everyone.beliefs.boxes[:] = [-90.0, 100.0, -10.0, 200.0]
    assert Lifecycle(max_gap=9.0).living(everyone, LEVEL).ids.tolist() == [10, 12]


def test_without_memory_every_lost_track_ends() -> None:
    assert len(Lifecycle(max_gap=0.0).living(unseen_for(0.1, 0.1), LEVEL)) == 0


def test_no_track_lost_is_no_track() -> None:
    assert len(Lifecycle(max_gap=9.0).living(ActiveTracks.empty(), LEVEL)) == 0


def test_the_coasting_keep_how_long_they_were_unseen() -> None:
    coasting = Lifecycle(max_gap=9.0).living(unseen_for(0.4, 0.7), LEVEL)
    assert coasting.time_since_update.tolist() == [0.4, 0.7]
    assert coasting.hits.tolist() == [3, 3]


@pytest.mark.parametrize(
    ("box", "seen"),
    [
        ([-50.0, 100, 10, 200], True),
        ([-50.0, 100, -1, 200], False),
        ([1240.0, 100, 1300, 200], True),
        ([1242.0, 100, 1300, 200], False),
        ([100.0, -90, 200, -1], False),
        ([100.0, 374, 200, 500], False),
        ([100.0, 373, 200, 500], True),
    ],
)
def test_a_track_whose_expected_box_has_left_the_image_is_out_of_view(box, seen) -> None:
    beliefs = beliefs_at((0.0, 20.0))
    beliefs.boxes[0] = box
    assert in_view(beliefs, LEVEL).tolist() == [seen]


def test_a_track_that_fell_behind_is_out_of_view_whatever_its_box() -> None:
    beliefs = beliefs_at((0.0, 20.0), (0.0, 20.0))
    beliefs.cuboids.base[1, 2] = -2.0
    assert in_view(beliefs, LEVEL).tolist() == [True, False]


def test_a_lost_track_out_of_view_ends_at_once() -> None:
    expected = unseen_for(0.1, 0.1)
    expected.beliefs.boxes[0] = [-90.0, 100, -10, 150]
    assert Lifecycle(max_gap=9.0).living(expected, LEVEL).ids.tolist() == [11]


def test_of_no_tracks_none_is_in_view() -> None:
    assert in_view(ActiveTracks.empty().beliefs, LEVEL).shape == (0,)
    assert len(ActiveTracks.empty()) == 0
