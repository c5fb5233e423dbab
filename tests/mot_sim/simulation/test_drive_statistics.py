"""Statistics of drives that are made by hand."""

import numpy as np
import pytest

from mot_sim.simulation.drive_statistics import DRIVE_STATISTICS, MeasuredDrive, slopes
from tracker.types import Cuboids, Tracks

FRAMES, SPEED = 100, 10.0
Way = tuple[np.ndarray, np.ndarray]  # frames, and x, y, heading in each


def straight(x: float, y: float, heading: float, speed: float, frames: range) -> Way:
    """A car that keeps its speed; x, y: in the first of its frames."""
    at, step = np.array(frames), 0.1 * speed * np.arange(len(frames))
    return at, np.stack(
        (x + step * np.cos(heading), y + step * np.sin(heading), 0 * step + heading), 1
    )


def drive_of(
    *cars: Way, egos: np.ndarray | None = None, occluded: tuple[int, ...] = ()
) -> MeasuredDrive:
    """Labels of these cars, each 4 m long; the first one is largely occluded in some frames."""
    if egos is None:
        egos = straight(0.0, 0.0, 0.0, SPEED, range(FRAMES))[1]
    frames = np.concatenate([each[0] for each in cars]).astype(np.int64)
    ids = np.repeat(np.arange(len(cars)), [len(each[0]) for each in cars])
    poses = np.concatenate([each[1] for each in cars])
    apart, heading = poses[:, :2] - egos[frames, :2], egos[frames, 2]
    c, s = np.cos(heading), np.sin(heading)
    forward, right = c * apart[:, 0] + s * apart[:, 1], c * apart[:, 1] - s * apart[:, 0]
    base = np.stack((right, 0 * right, forward), axis=1)
    size = np.tile((4.0, 1.5, 1.8), (len(frames), 1))
    tracks = Tracks(
        frames, ids, np.tile((100.0, 100.0, 160.0, 140.0), (len(frames), 1)), None,
        np.full(len(frames), "Car"), np.zeros(len(frames), np.int64),
        2 * ((ids == 0) & np.isin(frames, occluded)).astype(np.int64),
        Cuboids(base, poses[:, 2] - heading - 0.5 * np.pi, size),
    )  # fmt: skip
    return MeasuredDrive.of_labels("by hand", egos, tracks)


def measured(name: str, *drives: MeasuredDrive) -> float:
    return DRIVE_STATISTICS[name].of(drives)


def test_cars_ahead_parked_and_crossing_are_told_apart() -> None:
    ahead = straight(30.0, 0.0, 0.0, SPEED, range(FRAMES))
    parked = straight(60.0, 4.0, 0.0, 0.0, range(50))
    crossing = straight(90.0, -20.0, 0.5 * np.pi, 5.0, range(30, 80))
    drive = drive_of(ahead, parked, crossing, occluded=(10, 11, 12, 13, 40, 41))
    assert measured("ego_speed", drive) == pytest.approx(SPEED)
    assert measured("ego_standing", drive) == 0.0
    assert measured("ego_yaw_rate", drive) == pytest.approx(0.0, abs=1e-9)
    assert measured("headway", drive) == pytest.approx(28.0 / SPEED)
    assert measured("parked", drive) == pytest.approx(1 / 3)
    assert measured("crossing", drive) == pytest.approx(50 / 150)
    assert measured("cars", drive) == 2.0
    assert measured("ids", drive) == 18.0
    assert measured("iou", drive) == 1.0
    assert measured("height", drive) == 40.0
    assert measured("occluded", drive) == pytest.approx(6 / 200)
    assert measured("occlusion_run", drive) == pytest.approx(0.3)
    assert measured("acceleration", drive) == pytest.approx(0.0, abs=1e-6)
    # of 100 rows 0 m/s, of 100 rows -10 m/s
    assert measured("relative_speed", drive) == pytest.approx(-5.0)


def test_a_car_beside_our_lane_is_not_ahead_but_one_round_the_bend_is() -> None:
    beside = drive_of(straight(30.0, 3.5, 0.0, SPEED, range(FRAMES)))
    assert np.isnan(measured("headway", beside))
    angle = 0.02 * np.arange(FRAMES)  # a bend of 50 m radius
    egos = np.stack((50 * np.sin(angle), 50 - 50 * np.cos(angle), angle), axis=1)
    later = np.arange(20, FRAMES)
    leading = drive_of((np.arange(FRAMES - 20), egos[later]), egos=egos)
    assert measured("headway", leading) == pytest.approx(1.8, abs=0.01)
    assert measured("ego_yaw_rate", leading) == pytest.approx(np.degrees(0.2), rel=1e-3)


def test_a_shift_to_the_next_lane_is_a_change_and_a_bend_is_none() -> None:
    share = np.clip((np.arange(FRAMES) - 30) / 30, 0.0, 1.0)
    y = 3.5 * (3 * share**2 - 2 * share**3)
    x = 0.1 * SPEED * np.arange(FRAMES)
    changes = np.arange(FRAMES), np.stack((x + 20.0, y, 0 * x), axis=1)
    assert measured("lane_changes", drive_of(changes)) == 6.0  # one in ten seconds
    angle = 0.01 * np.arange(FRAMES)
    bend = np.stack((100 * np.sin(angle), 100 - 100 * np.cos(angle), angle), axis=1)
    assert measured("lane_changes", drive_of((np.arange(FRAMES), bend), egos=bend)) == 0.0


def test_a_car_that_waits_is_not_parked_and_braking_is_seen() -> None:
    speed = np.clip(10.0 - 0.2 * np.arange(FRAMES), 0.0, None)  # 2 m/s2, then it stands
    x = 20.0 + np.concatenate(([0.0], np.cumsum(0.1 * speed[:-1])))
    drive = drive_of((np.arange(FRAMES), np.stack((x, 0 * x, 0 * x), axis=1)))
    assert measured("parked", drive) == 0.0
    assert measured("acceleration", drive) == pytest.approx(2.0, rel=0.02)


def test_a_drive_without_cars_has_counts_and_no_shares() -> None:
    drive = drive_of(straight(0.0, 0.0, 0.0, 0.0, range(0)))
    assert (measured("cars", drive), measured("ids", drive)) == (0.0, 0.0)
    for name in ("parked", "crossing", "iou", "height", "occluded", "headway", "occlusion_run"):
        assert np.isnan(measured(name, drive)), name
    ahead = drive_of(straight(30.0, 0.0, 0.0, SPEED, range(FRAMES)))
    assert measured("cars", drive, ahead) == 0.5
    assert measured("ids", drive, ahead) == 3.0


def test_the_pitch_of_the_camera_is_followed_from_frame_to_frame() -> None:
    drive = drive_of(straight(30.0, 0.0, 0.0, SPEED, range(FRAMES)))
    assert np.isnan(measured("pitch_step", drive))
    angles = np.radians(np.where(np.arange(FRAMES) % 2, 0.05, 0.0))  # up and down by .05 degrees
    poses = np.tile(np.eye(4), (FRAMES, 1, 1))
    poses[:, 1, 1] = poses[:, 2, 2] = np.cos(angles)
    poses[:, 2, 1], poses[:, 1, 2] = np.sin(angles), -np.sin(angles)
    drive = MeasuredDrive.of_labels("pitching", drive.egos, drive.cars, poses)
    assert measured("pitch_step", drive) == pytest.approx(0.05)


def test_slopes_are_exact_for_quadratics_and_for_few_values() -> None:
    time = 0.1 * np.arange(30)
    assert slopes((3 * time**2)[:, None])[:, 0] == pytest.approx(6 * time, abs=1e-9)
    assert slopes(time[:2, None])[:, 0] == pytest.approx([1.0, 1.0])
    assert slopes(time[:1, None]).tolist() == [[0.0]]
    assert slopes(np.zeros((0, 2))).shape == (0, 2)
