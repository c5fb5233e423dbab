"""Kernels that put the tracks of a frame together equal the operations of tables, bit by bit."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.kernels.plain_renewal import plain_renewal, same_values
from tests.tracker.kernels.test_tracks import (
    cameras,
    counts,
    seeds,
    some_beliefs,
    some_boxes,
    some_partners,
    some_tracks,
)
from tests.tracker.samples import LEVEL
from tracker.box_filter import BoxFilter
from tracker.car_filter import CarStates
from tracker.costs import GatedPairs
from tracker.dynamics import ConstantPosition, ConstantVelocity, Dynamics
from tracker.ego_motion import CameraMotion
from tracker.existence import DetectorStatistics, ExistenceFilter
from tracker.expectation import Expectation
from tracker.geometry import homogeneous, rotation_y
from tracker.lifecycle import ActiveTracks, Lifecycle
from tracker.renewal import Renewal, Renewed
from tracker.tracker import Tracker
from tracker.types import Detections
from tracker.types.embedding import Embedding
from tracker.types.shape_pose import ShapePose


@dataclass(frozen=True)
class OfOnesOwn(ConstantVelocity):
    """The same dynamics, which no kernel knows."""


def with_cues(beliefs, rng, share):  # type: ignore[no-untyped-def]
    """Beliefs of which some rows have shapes, yaws and looks, or none at all has."""
    n = len(beliefs)
    if share == 0.0:
        return beliefs
    known = rng.random(n) < share
    shape, yaw = np.where(known[:, None], rng.normal(size=(n, 2)), np.nan), rng.normal(size=n)
    pose = ShapePose(shape, np.where(known, yaw, np.nan), np.ones((n, 3, 3)))
    return beliefs.replaced(shape_pose=pose, embedding=Embedding(shape))


@pytest.mark.parametrize("dynamics", [ConstantPosition(), ConstantVelocity(), OfOnesOwn()])
@given(seed=seeds, count=counts, others=counts, filters=st.booleans(), cues=st.booleans())
def test_the_tracks_after_a_frame(dynamics, seed, count, others, filters, cues) -> None:  # type: ignore[no-untyped-def]
    rng, dt = np.random.default_rng(seed), 0.1
    parts = (BoxFilter(), ExistenceFilter()) if filters else (None, None)
    how = Renewal(dynamics, *parts, Lifecycle(max_gap=0.2), LEVEL)
    tracks, partners = some_tracks(rng, count, dt), some_partners(rng, count, others)
    shares = rng.choice([0.0, 0.5, 1.0], 2) if cues else (0.0, 0.0)
    beliefs, observed = (
        with_cues(some_beliefs(rng, n), rng, share)
        for n, share in zip((count, others), shares, strict=True)
    )
    tracks = tracks.replaced(beliefs=beliefs, scores=np.full(count, np.nan))
    found = Detections(observed.boxes, rng.uniform(0.0, 1.0, others))
    learned = DetectorStatistics(5, 7, 2, 3), None
    frame = tracks, partners, observed, found, learned, dt, 70
    after, (expected, places) = how(*frame), plain_renewal(how, *frame)
    by_parts = how.by_parts(*frame)
    np.testing.assert_array_equal(after.places, places)
    if len(expected):  # else there may be a cue of no rows
        same_values(after.tracks, expected)
        same_values(by_parts.tracks, expected)
    assert by_parts.detector == after.detector
    if filters:
        for one, other in zip(by_parts.gains, after.gains, strict=True):
            np.testing.assert_array_equal(one, other)


@given(seeds, counts, counts)
def test_the_cars_behind_the_tracks_of_a_frame(seed: int, count: int, others: int) -> None:
    rng = np.random.default_rng(seed)
    partners, n = some_partners(rng, count, others), count + others
    k, b = len(partners.rows), len(partners.born)

    def cars(number: int) -> CarStates:
        shape = (number, 16, 9)
        return CarStates(rng.random(shape), rng.random((*shape, 9)), rng.random(shape[:2]))

    before, updated, begun = cars(count), cars(k), cars(b)
    old = rng.permutation(count + k)[: rng.integers(0, count + k + 1)]
    places = np.concatenate((old, count + k + partners.born))
    renewed = Renewed(ActiveTracks.empty(), places, DetectorStatistics(), None)
    found = renewed.cars(before, updated, begun)
    everyone = CarStates.concatenate((before, updated, begun))
    same_values(found, everyone.take(np.concatenate((old, count + k + np.arange(b)))))
    assert n >= b


@pytest.mark.parametrize("dynamics", [ConstantPosition(), ConstantVelocity()])
@given(seed=seeds, count=counts, others=counts, camera=cameras)
def test_what_is_expected(  # type: ignore[no-untyped-def]
    dynamics: Dynamics, seed: int, count: int, others: int, camera
) -> None:
    """At once as part after part: motion, ego-motion, then the gate."""
    rng, dt = np.random.default_rng(seed), 0.1
    root = rng.normal(0.0, 0.001, (6, 6))
    T = homogeneous(rotation_y(0.02), rng.normal(0.0, 0.5, 3))
    tracker = replace(Tracker.default(camera), dynamics=dynamics, camera_rotation_filter=None)
    tracks = some_tracks(rng, count, dt).replaced(scores=np.full(count, np.nan))
    tracks = tracks.replaced(beliefs=with_cues(tracks.beliefs, rng, 0.5))
    observed = some_beliefs(rng, others)
    found = Detections(some_boxes(rng, others), np.ones(others))
    motion, seconds = CameraMotion(T, root @ root.T), (dt, tracker.existence.survival(dt))
    tracks_then, _ = tracker.predict_tracks(tracks, motion, dt, found)
    pairs = tracker.gate(tracks_then, observed, found, dt)
    how = dynamics, (T, motion.covariance), seconds, camera, tracker.sigmas
    expectation = Expectation.of(tracks, observed, *how)
    same_values(expectation.tracks, tracks_then)
    given = (expectation.tracks.beliefs, observed), found, (camera, tracker.sigmas, dt)
    at_once = GatedPairs.known(*given, expectation.gated)
    same_values(at_once.expected_regions, pairs.expected_regions)
    np.testing.assert_array_equal(at_once.search_areas, pairs.search_areas)
    np.testing.assert_array_equal(at_once.pairs, pairs.pairs)
