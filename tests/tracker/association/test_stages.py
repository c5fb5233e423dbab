"""Matching in two stages: sure detections choose first."""

import numpy as np
import pytest

from tracker.association import Greedy, Hungarian, match_in_stages

INF = np.inf


def test_a_strong_detection_takes_the_track_that_a_weak_one_fits_better() -> None:
    costs = np.array([[0.1, 0.5]])
    match = match_in_stages(costs, np.array([False, True]), Hungarian())
    assert match.pairs.tolist() == [[0, 1]]
    assert match.unmatched_detections.tolist() == [0]


def test_weak_detections_take_what_is_left_of_the_tracks() -> None:
    costs = np.array([[0.2, 0.1, INF], [INF, 0.3, 0.4], [0.9, 0.9, 0.1]])
    match = match_in_stages(costs, np.array([True, False, False]), Hungarian())
    assert sorted(match.pairs.tolist()) == [[0, 0], [1, 1], [2, 2]]
    assert len(match.unmatched_tracks) == len(match.unmatched_detections) == 0


@pytest.mark.parametrize("associate", [Hungarian(0.8), Greedy(0.8)])
def test_when_all_are_strong_there_is_one_stage(associate) -> None:
    costs = np.random.default_rng(0).random((4, 5))
    ours, theirs = match_in_stages(costs, np.ones(5, bool), associate), associate(costs)
    np.testing.assert_array_equal(ours.pairs, theirs.pairs)
    np.testing.assert_array_equal(ours.unmatched_detections, theirs.unmatched_detections)


@pytest.mark.parametrize("associate", [Hungarian(0.8), Greedy(0.8)])
def test_when_all_are_weak_the_second_stage_does_everything(associate) -> None:
    costs = np.random.default_rng(1).random((4, 5))
    ours, theirs = match_in_stages(costs, np.zeros(5, bool), associate), associate(costs)
    np.testing.assert_array_equal(ours.pairs, theirs.pairs)


@pytest.mark.parametrize("shape", [(0, 3), (3, 0), (0, 0), (3, 2)])
def test_every_row_and_column_is_in_one_place(shape: tuple[int, int]) -> None:
    costs = np.random.default_rng(2).random(shape)
    match = match_in_stages(costs, np.arange(shape[1]) % 2 == 0, Hungarian(0.5))
    assert sorted([*match.pairs[:, 0], *match.unmatched_tracks]) == list(range(shape[0]))
    assert sorted([*match.pairs[:, 1], *match.unmatched_detections]) == list(range(shape[1]))
