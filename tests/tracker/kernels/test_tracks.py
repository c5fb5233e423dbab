"""Kernels of the tracks' own steps, lifting to existence, equal plain NumPy."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.kernels import plain_tracks as plain
from tests.tracker.kernels.plain_existence import plain_existence, plain_written
from tests.tracker.samples import LEVEL, PITCHED
from tracker.beliefs import Beliefs, Lift
from tracker.box_filter import BoxFilter, Gains
from tracker.costs import GatedPairs, ImageOverlap
from tracker.costs.gating import project_cuboids
from tracker.dynamics import ConstantPosition, ConstantVelocity, acceleration_noise
from tracker.ego_motion import RoadMotion, compensate_ego_motion
from tracker.existence import DetectorStatistics, ExistenceFilter
from tracker.geometry import homogeneous, rotation_y
from tracker.lifecycle import ActiveTracks, Partners
from tracker.suppression import Suppression
from tracker.types import Camera, Cuboids, Detections

seeds, counts, cameras = (
    st.integers(0, 2**32 - 1),
    st.integers(0, 7),
    st.sampled_from([LEVEL, PITCHED]),
)


def some_boxes(rng: np.random.Generator, count: int) -> np.ndarray:
    """In, across and beyond the image; points, columns, copies; above and below the horizon."""
    low = rng.uniform((-200.0, 0.0), (1300.0, 420.0), (count, 2))
    sides = rng.choice([0.0, 1e-6, 30.0, 200.0, 3000.0], (count, 2)) * rng.uniform(0.5, 1.0)
    boxes = np.concatenate((low, low + sides), axis=1)
    copies = rng.random(count) < 0.3
    boxes[copies] = boxes[rng.integers(0, max(count, 1), copies.sum())] + rng.choice([0.0, 3.0])
    return boxes


def some_detections(rng: np.random.Generator, count: int) -> Detections:
    """With scores of any scale, some of them equal."""
    return Detections(some_boxes(rng, count), rng.choice([-0.5, 0.4, 0.9, 0.95, 1.5], count))


def some_beliefs(rng: np.random.Generator, count: int) -> Beliefs:
    """Anywhere, also behind the camera."""
    base = rng.uniform((-40.0, -1.0, -20.0), (40.0, 1.0, 120.0), (count, 3))
    roots = rng.normal(0.0, 1.0, (count, 4, 4))
    cuboids = Cuboids(base, rng.uniform(-9.0, 9.0, count), rng.uniform(0.5, 5.0, (count, 3)))
    covs = roots @ roots.transpose(0, 2, 1)
    return Beliefs(cuboids, rng.normal(0.0, 5.0, (count, 2)), covs, some_boxes(rng, count))


def same_columns(found: Beliefs, expected: Beliefs) -> None:
    for one, other in (
        (found.cuboids.base, expected.cuboids.base),
        (found.cuboids.yaw, expected.cuboids.yaw),
        (found.velocity, expected.velocity),
        (found.cov, expected.cov),
        (found.boxes, expected.boxes),
    ):
        scale = 1.0 + np.abs(other).max(initial=0.0)
        np.testing.assert_allclose(one / scale, other / scale, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("use_box_height", [False, True])
@given(seed=seeds, count=counts, camera=cameras)
def test_lifting(seed, count, camera, use_box_height) -> None:  # type: ignore[no-untyped-def]
    rng, lift = np.random.default_rng(seed), Lift(use_box_height=use_box_height)
    seen = some_detections(rng, count)
    measured = replace(
        seen, yaw=rng.uniform(-9.0, 9.0, count), size=rng.uniform(1.0, 9.0, (count, 3))
    )
    for given_boxes in (seen, measured):
        same_columns(lift(given_boxes, camera), plain.plain_lift(lift, given_boxes, camera))


@given(seeds, counts, cameras, st.booleans(), st.floats(-0.3, 0.3))
def test_ego_motion_and_correction(seed, count, camera, moves, turn) -> None:  # type: ignore[no-untyped-def]
    rng = np.random.default_rng(seed)
    beliefs, root = some_beliefs(rng, count), rng.normal(0.0, 0.01, (6, 6))
    moved = rng.normal(0.0, 2.0, (count, 2)) if moves else None
    motion = homogeneous(rotation_y(turn), rng.normal(0.0, 1.0, 3)), root @ root.T, moved
    found = compensate_ego_motion(beliefs, camera, *motion)
    same_columns(found, plain.plain_compensated(beliefs, camera, *motion))
    seen = some_beliefs(rng, count)
    dynamics = ConstantVelocity()
    same_columns(dynamics.update(found, seen), plain.plain_correction(found, seen))


@given(seeds, cameras, st.floats(-3.0, 3.0))
def test_what_a_motion_does_to_the_road(seed: int, camera: Camera, turn: float) -> None:
    T = homogeneous(rotation_y(turn), np.random.default_rng(seed).normal(0.0, 1.0, 3))
    found, T_road = RoadMotion.of(T, camera), camera.T_road_cam @ T @ camera.T_cam_road
    K_R = camera.K @ T[:3, :3]
    np.testing.assert_allclose(found.T_road, T_road, atol=1e-12)
    np.testing.assert_allclose(found.H, K_R @ camera.K_inverse, atol=1e-9)
    np.testing.assert_allclose(found.shift, camera.K @ T[:3, 3], atol=1e-9)
    np.testing.assert_allclose(found.by_moved, K_R @ camera.T_cam_road[:3, :3:2], atol=1e-9)
    across = T_road[0, 2] - T_road[2, 0], T_road[0, 0] + T_road[2, 2]
    np.testing.assert_allclose(found.turn, np.arctan2(*across), atol=1e-12)


@given(seeds, counts, st.sampled_from([0.0, 0.1, 3.0]))
def test_uncertainty_grows_with_time(seed: int, count: int, dt: float) -> None:
    beliefs, F = some_beliefs(np.random.default_rng(seed), count), np.eye(4)
    later, moved = ConstantVelocity(2.0).predict(beliefs, dt)
    F[0, 2] = F[1, 3] = dt
    expected = F @ beliefs.cov @ F.T + acceleration_noise(dt, 2.0)
    np.testing.assert_allclose(later.cov, expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(moved, beliefs.velocity * dt)
    still, nothing = ConstantPosition((1.0, 5.0)).predict(beliefs, dt)
    noise = np.diag([dt**2, 25.0 * dt**2, 0.0, 0.0])
    np.testing.assert_allclose(still.cov, beliefs.cov + noise, rtol=1e-12)
    assert nothing is None


@given(seeds, counts, counts, cameras, st.sampled_from([0.0, 1.0, 30.0]))
def test_gating(seed, count, others, camera, sigmas) -> None:  # type: ignore[no-untyped-def]
    rng = np.random.default_rng(seed)
    beliefs, seen = some_beliefs(rng, count), some_beliefs(rng, others)
    region, expected = beliefs.region(sigmas), plain.plain_region(beliefs, sigmas)
    np.testing.assert_allclose(region.size, expected.size, rtol=1e-9, atol=1e-9)
    areas = project_cuboids(region, camera)
    np.testing.assert_allclose(areas, plain.plain_project_cuboids(region, camera), atol=1e-8)
    boxes = Detections(seen.boxes, np.ones(others))
    pairing = GatedPairs(beliefs, seen, boxes, camera, sigmas, 0.5)
    rows, columns = plain.plain_pairs(pairing.search_areas, seen.boxes)
    np.testing.assert_array_equal(pairing.pairs, (rows, columns))
    costs = plain.plain_overlap_cost(beliefs.boxes[rows], seen.boxes[columns], 0.3)
    np.testing.assert_allclose(ImageOverlap(0.1, drift=0.6)(pairing), costs, atol=1e-9)
    matrix = np.full((count, others), np.inf)
    matrix[rows, columns] = costs
    np.testing.assert_array_equal(pairing.matrix(costs), matrix)


@pytest.mark.parametrize("of_sure", [None, 0.7])
@given(seed=seeds, count=st.integers(0, 12))
def test_suppression(seed: int, count: int, of_sure: float | None) -> None:
    seen = some_detections(np.random.default_rng(seed), count)
    suppress = Suppression(min_score=0.3, max_iou=0.4, max_iou_of_sure=of_sure)
    found, expected = suppress(seen, LEVEL), plain.plain_suppression(suppress, seen, LEVEL)
    np.testing.assert_array_equal(found.boxes, expected.boxes)
    np.testing.assert_array_equal(found.scores, expected.scores)


@given(seeds, counts, st.sampled_from([0.0, 0.1]))
def test_the_box_filter(seed: int, count: int, dt: float) -> None:
    rng, smooth = np.random.default_rng(seed), BoxFilter()
    tracks = ActiveTracks.born(some_beliefs(rng, count), np.ones(count), np.ones(count), 0)
    before = rng.uniform(-0.5, 0.5, (count, 4))
    before[rng.random(count) < 0.3] = np.nan
    since = dt * rng.choice([1.0, 1.0, 3.0], count)
    tracks = tracks.replaced(
        innovations=before, hits=rng.integers(1, 9, count), time_since_update=since
    )
    boxes = tracks.beliefs.boxes + rng.normal(0.0, 5.0, (count, 4))
    learned = Gains(
        rng.uniform(0.2, 1.0, (3, 4)), rng.uniform(0.0, 90.0, (3, 1)), rng.uniform(0.0, 9.0, (3, 4))
    )
    found = smooth(learned, tracks, boxes, dt, LEVEL)
    expected = plain.plain_filter(smooth, learned, tracks, boxes, dt, LEVEL)
    np.testing.assert_allclose(found.boxes, expected.boxes, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.innovations, expected.innovations, atol=1e-9)
    for one, other in zip(found.learned, expected.learned, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9)


def some_tracks(rng: np.random.Generator, count: int, dt: float) -> ActiveTracks:
    """Young and old, seen and unseen, likely and not."""
    tracks = ActiveTracks.born(some_beliefs(rng, count), np.ones(count), np.ones(count), 0)
    return tracks.replaced(
        hits=rng.integers(1, 6, count),
        time_since_update=dt * rng.choice([0.0, 1.0, 1.005, 3.0], count),
        existence=rng.choice([0.0, 1e-9, 0.5, 0.999], count),
        scores=rng.choice([np.nan, 0.9], count),
    )


def some_partners(rng: np.random.Generator, count: int, found: int) -> Partners:
    """Some tracks with some detections, in any order; some others begin tracks."""
    both = rng.integers(0, min(count, found) + 1)
    rows, columns = rng.permutation(count), rng.permutation(found)
    born = columns[both:][rng.random(found - both) < 0.5]
    return Partners(rows[:both], columns[:both], np.sort(rows[both:]), np.sort(born))


@given(seeds, counts, counts, cameras, st.sampled_from([0.0, 0.1]))
def test_existence(seed, count, others, camera, dt) -> None:  # type: ignore[no-untyped-def]
    rng, how = np.random.default_rng(seed), ExistenceFilter()
    counted = DetectorStatistics(*rng.integers(0, 1000, 4).tolist())
    tracks, partners = some_tracks(rng, count, dt), some_partners(rng, count, others)
    seen = Detections(some_boxes(rng, others), rng.uniform(-0.5, 5.0, others))
    frame = counted, tracks, partners, seen, dt, camera
    found, expected = how(*frame), plain_existence(how, *frame)
    np.testing.assert_array_equal(found.tracks, expected.tracks)
    np.testing.assert_array_equal(found.born, expected.born)
    assert found.detector == expected.detector
    for since_look in (0.0, dt):
        written = how.written(tracks, since_look)
        np.testing.assert_array_equal(written, plain_written(how, tracks, since_look))
