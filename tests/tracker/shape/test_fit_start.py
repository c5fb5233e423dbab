"""The scan over all yaws."""

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, PITCHED
from tests.tracker.shape.drawn import MODEL, keypoints_of
from tracker.geometry import wrap_angle
from tracker.shape.fit_start import (
    YAW_COUNT,
    Rays,
    rays_to,
    scan_yaws,
    starts,
    view_bin,
    visibility_score,
)
from tracker.shape.projection import SHAPE, YAW, X, Z

BASE = np.array([[-3.0, 0.0, 12.0], [2.0, 0.0, 25.0], [0.0, 0.0, 8.0]])
ANGLES = np.array([0.0, 2.0, -1.5])


def rays_of(camera) -> Rays:
    keypoints = keypoints_of(MODEL, np.zeros((3, 5)), BASE, ANGLES, camera)
    rays, centre = rays_to(keypoints[:, :, :2], camera)
    k = rays.shape[1]
    return Rays(
        rays,
        np.ones((3, k)),
        np.tile(MODEL.basis.mean, (3, 1, 1)),
        np.tile(MODEL.point_var, (3, 1)),
        centre,
        np.full(3, 2.0 / 700.0),
    )


@pytest.mark.parametrize("camera", [LEVEL, PITCHED])
def test_the_mean_car_is_found_within_the_grid(camera) -> None:
    cost, place = scan_yaws(rays_of(camera))
    best = cost.argmin(axis=1)
    off = wrap_angle(best * (2 * np.pi / YAW_COUNT) - ANGLES)
    assert (np.abs(off) <= np.pi / YAW_COUNT + 0.05).all()
    np.testing.assert_allclose(place[np.arange(3), best], BASE[:, ::2], atol=0.3)


def test_starts_are_far_apart_in_yaw() -> None:
    found = starts(rays_of(LEVEL), MODEL, np.ones((3, 36), bool), 4, SHAPE + 5)
    for row in found:
        yaws = row[:, YAW]
        apart = np.abs(wrap_angle(yaws[:, None] - yaws))[~np.eye(4, dtype=bool)]
        assert apart.min() > np.radians(44.0)
    assert (found[:, :, SHAPE:] == 0.0).all()
    np.testing.assert_allclose(found[:, 0, [X, Z]], BASE[:, ::2], atol=0.3)


def test_what_was_found_tells_front_from_back() -> None:
    """The points of the tail are seen: a car that drives away is likelier than one that comes."""
    away, coming = -np.pi / 2, np.pi / 2
    seen = np.array([["tail" in name or "rear_b" in name for name in MODEL.basis.points]])
    place = np.array([[[0.0, 20.0], [0.0, 20.0]]])
    score = visibility_score(
        MODEL, seen, np.array([[away, coming]]), place, np.array([0, -1.65, 0])
    )
    assert score[0, 0] > score[0, 1] + 5.0


def test_directions_wrap_into_the_bins() -> None:
    np.testing.assert_array_equal(view_bin(np.radians([1.0, 361.0, -1.0, 179.0])), [0, 0, 71, 35])
