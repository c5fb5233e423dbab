"""How objects looked when they were last seen."""

from dataclasses import replace

import numpy as np

from tests.tracker.samples import LEVEL, beliefs_at
from tracker.beliefs import Beliefs, Lift
from tracker.dynamics import ConstantPosition, ConstantVelocity
from tracker.ego_motion import compensate_ego_motion
from tracker.types import Detections
from tracker.types.embedding import Embedding

KNOWN = Embedding(np.array([[1.0, 2.0], [3.0, 4.0]]))


def test_it_is_the_column_of_the_detections_or_nothing() -> None:
    boxes = [[600.0, 165.0, 660.0, 245.0]]
    assert Embedding.of(Detections.of(boxes)) is None
    seen = Detections.of(boxes, descriptor=np.ones((1, 3)))
    lifted = Lift()(seen, LEVEL).embedding
    assert lifted is not None
    np.testing.assert_array_equal(lifted.descriptor, np.ones((1, 3)))


def test_what_is_not_known_now_is_as_it_was_before() -> None:
    blind = Embedding(np.array([[np.nan, 0.0], [9.0, 9.0]]))
    np.testing.assert_array_equal(blind.filled_from(KNOWN).descriptor, [[1.0, 2.0], [9.0, 9.0]])
    assert KNOWN.filled_from(blind) is KNOWN
    assert blind.filled_from(None) is blind


def test_it_rides_with_a_belief_through_time_and_motion() -> None:
    before = replace(beliefs_at((0.0, 20.0), (3.0, 30.0)), embedding=KNOWN)
    blind = replace(before, embedding=KNOWN.unknown(2))
    for dynamics in (ConstantPosition(), ConstantVelocity()):
        later, moved = dynamics.predict(before, 0.1)
        carried = compensate_ego_motion(later, LEVEL, np.eye(4), np.zeros((6, 6)), moved)
        for seen in (blind, replace(before, embedding=None)):
            now = dynamics.update(carried, seen)
            assert now.embedding is not None
            np.testing.assert_array_equal(now.embedding.descriptor, KNOWN.descriptor)
        fresh = dynamics.update(
            carried, replace(before, embedding=Embedding(KNOWN.descriptor + 1.0))
        )
        assert fresh.embedding is not None
        np.testing.assert_array_equal(fresh.embedding.descriptor, KNOWN.descriptor + 1.0)


def test_parts_that_know_nothing_get_empty_rows_beside_those_that_know() -> None:
    known = beliefs_at((0.0, 20.0))
    unknown = Lift()(Detections.of([[600.0, 165.0, 660.0, 245.0]]), LEVEL)
    both = Beliefs.concatenate((unknown, known, Beliefs.empty(), known.select([])))
    assert both.embedding is not None
    np.testing.assert_array_equal(np.isnan(both.embedding.descriptor[:, 0]), [True, False])
    assert both.shape_pose is not None
    assert Beliefs.concatenate((unknown, unknown)).embedding is None
    assert len(KNOWN.unknown(0)) == 0


def test_new_rows_that_know_nothing_leave_what_the_others_know() -> None:
    known, lookless = beliefs_at((0.0, 20.0), (3.0, 20.0)), beliefs_at((0.0, 20.0))
    lookless = replace(lookless, embedding=None)
    updated = replace(known, embedding=KNOWN).updated(np.array([1]), lookless)
    np.testing.assert_array_equal(updated.embedding.descriptor[0], KNOWN.descriptor[0])
    assert np.isnan(updated.embedding.descriptor[1]).all()
    learned = replace(known, embedding=None).updated(np.array([0]), beliefs_at((0.0, 20.0)))
    np.testing.assert_array_equal(np.isnan(learned.embedding.descriptor[:, 0]), [False, True])
