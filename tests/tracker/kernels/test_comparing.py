"""Kernels of costs equal plain NumPy."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tests.tracker.kernels import plain_costs as plain
from tests.tracker.kernels.test_tracks import cameras, counts, seeds, some_beliefs
from tracker.beliefs import Beliefs
from tracker.costs import Appearance, GatedPairs, Reprojection, ShapeAndPose, Volume
from tracker.types import Camera, Detections
from tracker.types.embedding import Embedding
from tracker.types.shape_pose import ShapePose


def with_looks(beliefs: Beliefs, rng: np.random.Generator, length: int) -> Beliefs:
    """With shapes, yaws and descriptors, NaN in some rows."""
    n, unknown = len(beliefs), rng.random(len(beliefs)) < 0.2
    shape, yaw = rng.normal(0.0, 0.3, (n, length)), rng.uniform(-9.0, 9.0, n)
    roots = rng.normal(0.0, 0.2, (n, length + 1, length + 1))
    shape[unknown] = np.nan
    yaw[rng.random(n) < 0.2] = np.nan
    pose = ShapePose(shape, yaw, roots @ roots.transpose(0, 2, 1))
    look = np.where(unknown[:, None], np.nan, rng.normal(0.0, 0.3, (n, length)))
    return beliefs.replaced(shape_pose=pose, embedding=Embedding(look))


@given(seeds, counts, counts, st.integers(1, 9), cameras, st.sampled_from([0.0, 1.0, 30.0]))
def test_costs(  # type: ignore[no-untyped-def]
    seed: int, count: int, others: int, length: int, camera: Camera, sigmas
) -> None:
    rng = np.random.default_rng(seed)
    beliefs, seen = (with_looks(some_beliefs(rng, n), rng, length) for n in (count, others))
    found = Detections(seen.boxes, np.ones(others))
    pairing = GatedPairs(beliefs, seen, found, camera, sigmas)
    close = {"rtol": 1e-9, "atol": 1e-9}
    np.testing.assert_allclose(Volume()(pairing), plain.plain_volume(pairing), **close)
    areas = plain.plain_reprojection(pairing)
    np.testing.assert_allclose(Reprojection()(pairing), areas, **close)
    distances = plain.plain_image_distance(pairing)
    np.testing.assert_allclose(pairing.image_distance, distances, **close)
    cost = ShapeAndPose()
    looks = cost.squares(beliefs.shape_pose, seen.shape_pose, *pairing.pairs)
    for one, other in zip(looks, plain.plain_looks(cost, pairing), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-7, atol=1e-9)
    squares = plain.plain_square_distances(pairing)
    np.testing.assert_allclose(Appearance(1.0)(pairing), -np.expm1(-squares), **close)
