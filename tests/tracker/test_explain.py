"""Why a detection got its identity."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.samples import LEVEL, Car, drive
from tracker import Detections, Frame, Tracker
from tracker.explain import runner_ups

INF = np.inf


def explained() -> Tracker:
    """The paper's tracker after two frames: two cars near each other, one far to the left."""
    tracker = Tracker.paper(LEVEL)
    tracker.explain = True
    for frame in drive([Car(-10.0, 20.0), Car(0.0, 20.0), Car(1.5, 21.0)], count=2).frames:
        tracker.step(frame)
    return tracker


def test_gated_pairs_have_no_costs_and_the_others_all() -> None:
    why = explained().explanation
    assert why.frame == 1
    assert why.ids.tolist() == [0, 1, 2]
    neighbours = [[False, True, True], [True, False, False], [True, False, False]]
    assert why.gated.tolist() == neighbours
    for part in why.parts.values():
        np.testing.assert_array_equal(np.isnan(part), why.gated)
    np.testing.assert_array_equal(np.isinf(why.total), why.gated)


def test_the_parts_make_the_total_and_the_right_pairs_are_matched() -> None:
    tracker = explained()
    why = tracker.explanation
    assert list(why.parts) == ["Volume", "Reprojection"]
    mean = 0.6 * why.parts["Volume"] + 0.4 * why.parts["Reprojection"]
    compared = ~why.gated
    tie = why.total[compared] - mean[compared]
    assert (tie >= 0.0).all()
    assert (tie <= tracker.tie_break).all()
    np.testing.assert_array_equal(why.matched, np.eye(3, dtype=bool))


def test_the_runner_up_is_the_cheapest_other_pair_of_row_and_column_by_hand() -> None:
    total = np.array([[0.1, 0.4, INF], [0.3, 0.2, INF], [INF, INF, 0.5]])
    by_hand = [[0.3, 0.1, 0.1], [0.1, 0.3, 0.2], [0.1, 0.2, INF]]
    np.testing.assert_array_equal(runner_ups(total), by_hand)
    why = explained().explanation
    assert why.runner_up[0, 0] == INF
    assert why.runner_up[1, 1] == min(why.total[1, 2], why.total[2, 1])


@given(st.integers(0, 5), st.integers(0, 5))
def test_runner_ups_have_the_shape_of_the_costs(n: int, m: int) -> None:
    assert runner_ups(np.random.default_rng(n + m).random((n, m))).shape == (n, m)


def test_sentences_name_track_detection_cues_and_runner_up_matched_pairs_first() -> None:
    why = explained().explanation
    lines = why.lines()
    assert len(lines) == 5
    assert lines[0].startswith("frame 1: track ")
    assert [": matched at " in line for line in lines] == [True] * 3 + [False] * 2
    assert all("refused" in line for line in lines[3:])
    alone = next(line for line in lines if "track 0" in line)
    assert alone.endswith("runner-up inf")
    total = why.total[0, 0]
    assert f"with detection 0: matched at {total:.3f} (Volume 0.000, Reprojection 0.000)" in alone


def test_a_frame_without_detections_or_tracks_is_explained_by_nothing() -> None:
    tracker = Tracker.paper(LEVEL)
    tracker.explain = True
    tracker.step(Frame(0, 0.0, Detections.empty()))
    assert tracker.explanation.total.shape == (0, 0)
    assert tracker.explanation.lines() == []
    tracker.step(Frame(1, 0.1, Detections.of([[600, 180, 650, 230]])))
    assert tracker.explanation.total.shape == (0, 1)
    tracker.step(Frame(2, 0.2, Detections.empty()))
    assert tracker.explanation.total.shape == (1, 0)
    assert tracker.explanation.lines() == []


def test_nothing_is_explained_unless_asked_for_and_reset_forgets_it() -> None:
    silent = Tracker.paper(LEVEL)
    silent.step(Frame(0, 0.0, Detections.empty()))
    assert silent.explanation is None
    tracker = explained()
    tracker.reset()
    assert tracker.explanation is None


@pytest.mark.parametrize("preset", [Tracker.paper, Tracker.default])
def test_explaining_changes_no_identity(preset) -> None:
    silent, talking = preset(LEVEL), preset(LEVEL)
    talking.explain = True
    for frame in drive([Car(0.0, 20.0), Car(1.5, 21.0, velocity=(0.0, 5.0))], count=5).frames:
        np.testing.assert_array_equal(silent.step(frame).ids, talking.step(frame).ids)
