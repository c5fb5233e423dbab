"""Detected cuboids: where they stand is taken as it is; boxes without one are back-projected."""

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, Car, drive
from tracker import Detections, Frame, Tracks, cuboid_tracker
from tracker.beliefs import Lift
from tracker.cuboid_tracker import CuboidLift
from tracker.errors import BadDetections, MissingCue
from tracker.types import Cuboids

BOXES = [[500.0, 150.0, 560.0, 200.0], [700.0, 150.0, 760.0, 200.0]]
STANDS = Cuboids(np.array([[-3.0, 0.0, 25.0], [4.0, 0.1, 22.0]]), np.array([1.5, -1.6]),
                 np.array([[4.2, 1.6, 1.8], [3.6, 1.4, 1.6]]))  # fmt: skip


def detected(known: tuple[bool, bool] = (True, True)) -> Detections:
    hole = np.where(known, 1.0, np.nan)
    return Detections.of(
        BOXES, [0.9, 0.9], base=STANDS.base * hole[:, None], yaw=STANDS.yaw * hole,
        size=STANDS.size * hole[:, None],
    )  # fmt: skip


def test_beliefs_stand_where_the_cuboids_do() -> None:
    beliefs = CuboidLift(place_std=0.2)(detected(), LEVEL)
    for column in ("base", "yaw", "size"):
        np.testing.assert_array_equal(getattr(beliefs.cuboids, column), getattr(STANDS, column))
    np.testing.assert_allclose(beliefs.cov[:, :2, :2], np.tile(np.eye(2) * 0.04, (2, 1, 1)))


def test_a_box_without_a_cuboid_is_back_projected() -> None:
    plain = Lift()(Detections.of(BOXES, [0.9, 0.9]), LEVEL)
    mixed = CuboidLift()(detected((True, False)), LEVEL)
    np.testing.assert_array_equal(mixed.cuboids.base[0], STANDS.base[0])
    np.testing.assert_array_equal(mixed.cuboids.base[1], plain.cuboids.base[1])
    np.testing.assert_array_equal(mixed.cov[1], plain.cov[1])
    assert len(CuboidLift()(Detections.empty(), LEVEL)) == 0


def test_boxes_alone_are_refused_with_what_is_missing() -> None:
    with pytest.raises(MissingCue, match=r"no cuboids: .* `base`, `yaw` and `size` .*--cuboids"):
        CuboidLift()(Detections.of(BOXES, [0.9, 0.9]), LEVEL)


def test_tracks_keep_to_the_cuboids_and_their_ids() -> None:
    cars = [Car(-4.0, 30.0), Car(4.0, 40.0), Car(-1.5, 60.0, yaw=np.pi / 2, velocity=(0.0, -6.0))]
    seen = drive(cars, lambda t: (0.2 * t, 6.0 * t, 0.0), count=20)
    tracker = cuboid_tracker(LEVEL)
    rows: list[Tracks] = []
    true: list[Cuboids] = []
    for frame in seen.frames:
        # One metre farther than the boxes say: only the cuboids can tell.
        lifted = Lift(use_box_height=True)(frame.found, LEVEL).cuboids
        base = lifted.base + np.array([0.0, 0.0, 1.0])
        given = frame.found.replaced(base=base, yaw=lifted.yaw, size=lifted.size)
        rows.append(tracker.step(Frame(frame.index, frame.time, given, frame.T_now_before)))
        true.append(lifted.replaced(base=base))
    assert {len(each) for each in rows[5:]} == {3}
    assert len({row for each in rows for row in each.ids.tolist()}) == 3
    for each, cuboids in zip(rows[10:], true[10:], strict=True):
        assert each.cuboids is not None
        nearest = np.abs(each.cuboids.base[:, None, 2] - cuboids.base[None, :, 2]).min(axis=1)
        assert nearest.max() < 0.5


@pytest.mark.parametrize("size", [[0.0, 1.5, 1.6], [4.0, -1.0, 1.6]])
def test_sizes_that_are_not_positive_are_refused(size: list[float]) -> None:
    with pytest.raises(BadDetections, match=r"size .* of box 1 is not positive: give metres"):
        Detections.of(BOXES, [1, 1], size=np.array([[4.0, 1.5, 1.6], size]))
