"""Eq. 6: shape and pose, weighted by their doubt."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, beliefs_at, pairing_of
from tracker import Detections, Frame, Tracker
from tracker.beliefs import Beliefs, Lift
from tracker.costs import ImageOverlap, ShapeAndPose, weighted_sum
from tracker.errors import MissingCue
from tracker.types.shape_pose import ShapePose

COST = ShapeAndPose(eta_shape=0.5, eta_pose=0.25, shape_floor=0.0, yaw_floor=0.0)


def looking(shape: list[float], yaw: float, std: tuple[float, ...] = (0.1, 0.2, 0.2)) -> Beliefs:
    """A car 20 m ahead with this shape and pose, known this well (yaw, coefficients)."""
    cov = np.diag(np.square(std))[None]
    looks = ShapePose(np.array([shape]), np.array([yaw]), cov)
    return replace(beliefs_at((0.0, 20.0)), shape_pose=looks)


def cost(before: Beliefs, now: Beliefs, by: ShapeAndPose = COST) -> float:
    return by(pairing_of(before, now)).item()


def test_a_hand_computed_case() -> None:
    """lambda differs by (0.3, -0.4), variances 0.04 + 0.04: 0.25 / 0.08 = 3.125.

    Yaw by 0.2, variance 0.01 + 0.01: 2. Together 0.5 * 3.125 + 0.25 * 2 = 2.0625.
    """
    expected = 1.0 - np.exp(-0.5 * 2.0625)
    assert cost(looking([0.1, 0.5], 1.0), looking([0.4, 0.1], 1.2)) == pytest.approx(expected)


def test_poses_on_both_sides_of_pi_are_close() -> None:
    near = cost(looking([0.0, 0.0], np.pi - 0.05), looking([0.0, 0.0], -np.pi + 0.05))
    assert near == pytest.approx(cost(looking([0.0, 0.0], -0.05), looking([0.0, 0.0], 0.05)))
    assert near < 0.2


def test_the_less_is_known_the_less_a_difference_counts() -> None:
    sure = cost(looking([0.0, 0.0], 0.0), looking([0.4, 0.0], 0.2))
    doubted = (0.5, 1.0, 1.0)
    unsure = cost(looking([0.0, 0.0], 0.0, doubted), looking([0.4, 0.0], 0.2, doubted))
    assert 0.0 < unsure < sure < 1.0


def test_nobody_is_surer_than_the_floors() -> None:
    exact = (0.0, 0.0, 0.0)
    floored = replace(COST, shape_floor=0.2, yaw_floor=0.1)
    pair = looking([0.0, 0.0], 0.0, exact), looking([0.2, 0.0], 0.1, exact)
    assert cost(*pair, floored) == pytest.approx(1.0 - np.exp(-0.5 * (0.5 + 0.25)))


@pytest.mark.parametrize("which", ["shape", "yaw", "cov"])
def test_a_row_that_is_not_trusted_gives_no_cue_and_the_other_weights_renormalise(which) -> None:
    before = beliefs_at((0.0, 20.0), (4.0, 25.0))
    now = beliefs_at((0.2, 20.0), (4.2, 25.0))
    getattr(now.shape_pose, which)[1] = np.nan
    pairing = pairing_of(before, now)
    costs, columns = ShapeAndPose()(pairing), pairing.pairs[1]
    assert np.isnan(costs[columns == 1]).all()
    assert np.isfinite(costs[columns == 0]).all()
    mixed = weighted_sum(pairing, ((0.5, ShapeAndPose()), (0.5, ImageOverlap())))
    overlap = ImageOverlap()(pairing)
    np.testing.assert_allclose(mixed.total[columns == 1], overlap[columns == 1])
    assert mixed.unmeasured == (columns == 1).sum()


@pytest.mark.parametrize("whose", ["tracks", "detections"])
def test_a_whole_column_that_is_missing_is_an_error_with_its_cure(whose: str) -> None:
    with_, without = beliefs_at((0.0, 20.0)), replace(beliefs_at((0.0, 20.0)), shape_pose=None)
    pair = (without, with_) if whose == "tracks" else (with_, without)
    with pytest.raises(MissingCue, match=rf"these {whose} do not have.*`pose_cov`"):
        COST(pairing_of(*pair))


def detections(*rows: tuple[float, float, float]) -> Detections:
    """Boxes 20 m ahead from this u on, with this first coefficient and this yaw."""
    boxes = np.array([[u, 165.0, u + 60.0, 245.0] for u, _, _ in rows]).reshape(-1, 4)
    n = len(rows)
    return Detections(
        boxes,
        np.full(n, 0.9),
        yaw=np.array([yaw for _, _, yaw in rows]),
        shape=np.array([[first, 0.0] for _, first, _ in rows]).reshape(n, 2),
        pose_cov=np.tile(0.001 * np.eye(3), (n, 1, 1)),
    )


def frames(*shown: Detections) -> list[Frame]:
    return [Frame(i, 0.1 * i, rows, np.eye(4) if i else None) for i, rows in enumerate(shown)]


def tracker() -> Tracker:
    return replace(Tracker.default(LEVEL), costs=((1.0, ShapeAndPose()),))


def ids(some: Tracker, given: list[Frame]) -> list[list[int]]:
    """The ids of each frame's detections, from left to right."""
    found = []
    for frame in given:
        tracks = some.step(frame)
        found.append(tracks.ids[np.argsort(tracks.boxes[:, 0])].tolist())
    return found


def test_two_cars_that_change_places_are_told_apart_by_their_looks() -> None:
    van, coupe = (0.5, -1.5), (-0.5, -1.5)
    given = frames(detections((600.0, *van), (650.0, *coupe)),
                   detections((600.0, *coupe), (650.0, *van)))  # fmt: skip
    first, second = ids(tracker(), given)
    assert second == first[::-1]


def test_looks_are_remembered_through_empty_frames_and_frames_without_a_fit() -> None:
    van, coupe = (0.5, -1.5), (-0.5, -1.5)
    shown = detections((600.0, *van), (650.0, *coupe))
    blind = detections((600.0, np.nan, np.nan), (650.0, np.nan, np.nan))
    swapped = detections((600.0, *coupe), (650.0, *van))
    mixed = replace(tracker(), costs=((0.9, ShapeAndPose()), (0.1, ImageOverlap(0.1))))
    found = ids(mixed, frames(shown, Detections.empty(), blind, Detections.empty(), swapped))
    assert found[1] == found[3] == []
    assert found[2] == found[0]
    assert found[4] == found[0][::-1]


def test_without_the_columns_nothing_is_carried() -> None:
    boxes = Detections.of([[600.0, 165.0, 660.0, 245.0]], [0.9])
    assert Lift()(boxes, LEVEL).shape_pose is None
    default = Tracker.default(LEVEL)
    for frame in frames(boxes, boxes):
        default.step(frame)
    assert default.state.tracks.beliefs.shape_pose is None
    with pytest.raises(MissingCue):
        ids(tracker(), frames(boxes, boxes))
