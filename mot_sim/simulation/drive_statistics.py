"""How our car and the others drive, and what labels show of them, in the same way of any drive.

Recorded drives and runs of scenes give the same two things: the poses of our car and the labels.
All is measured from these, so that a scene can be held against recorded drives. Positions of
labels are noisy: speeds and accelerations are slopes of quadratics fitted to a second of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.simulation.scene import Rollout
from mot_sim.simulation.traffic.kitti_replay import REPLAYED_KINDS, world_poses
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from mot_sim.simulation.truth import Truth, labels
from tracker.geometry import box_iou, wrap_angle
from tracker.types import Tracks

MINUTE = 60.0  # seconds
SMOOTHED_FRAMES = 11  # over which a slope is fitted
END_FRAMES = 5  # of a track, whose mean place counts as its first or last
PARKED_METRES = 2.0  # that the ends of a parked car's track may be apart: far labels wander so
PARKED_SPEED = 1.0  # m/s from end to end at most, so that short tracks of slow cars are not parked
LABEL_METRES = 0.5  # by which labels wander in a moment
EGO_DRIVING_SPEED = 0.5  # m/s
DRIVING_SPEED = 2.0  # m/s, of others: above what labels of standing cars show
FOLLOWING_SPEED = 3.0  # m/s, from which headways and lane changes are measured
LANE_HALF_METRES = 1.5  # beside the way that we drive later, for a car ahead in our lane
MAX_HEADWAY_METRES = 80.0
ALIKE_RADIANS = np.radians(30.0)  # headings that count as the same direction
CROSSING_RADIANS = np.radians((45.0, 135.0))
# A lane change: in five seconds a car shifts sideways by more than the labels' noise and less than
# two lanes, and heads as before, so that a bend is none.
CHANGE_FRAMES = 50
CHANGE_METRES = (2.2, 5.5)
CHANGE_RADIANS = np.radians(3.0)


@dataclass(frozen=True, eq=False)
class MeasuredDrive:
    """A drive as it is measured: who was where, by the labels of cars and vans."""

    name: str
    """Of the sequence, or of the scene and its seed."""
    egos: Float[Array, "t 3"]
    """x, y (metres) and heading (radians) of our car in every frame, in the plane of the road."""
    cars: Tracks
    """The labels with their cuboids in the road frame, in the order of ids and frames."""
    Ts_world_cam: Float[Array, "t 4 4"] | None = None
    """Poses of the camera; None: how it pitches is not measured."""

    @classmethod
    def of_labels(
        cls,
        name: str,
        egos: Float[Array, "t 3"],
        tracks: Tracks,
        Ts_world_cam: Float[Array, "t 4 4"] | None = None,
    ) -> "MeasuredDrive":
        """From all labels; those of other classes and DontCare are left out."""
        assert tracks.kinds is not None
        rows = np.flatnonzero(np.isin(tracks.kinds, REPLAYED_KINDS))
        order = np.lexsort((tracks.frames[rows], tracks.ids[rows]))
        return cls(name, egos, tracks.select(rows[order]), Ts_world_cam)

    @classmethod
    def of_rollout(cls, rollout: Rollout, truth: Truth) -> "MeasuredDrive":
        """From a run of a scene and what is true in it, by the labels that KITTI would have."""
        name = f"{rollout.scene.name} {rollout.seed}"
        Ts_world_cam = rollout.scene.rig.Ts_world_cam(rollout.traffic)
        return cls.of_labels(name, rollout.traffic.ego, labels(truth), Ts_world_cam)

    def __len__(self) -> int:
        return len(self.egos)

    @property
    def minutes(self) -> float:
        """How long it is."""
        return len(self) * STEP_SECONDS / MINUTE

    @cached_property
    def ego_speed(self) -> Float[Array, " t"]:
        """Of our car along its heading, m/s."""
        velocity = slopes(self.egos[:, :2])
        return velocity[:, 0] * np.cos(self.egos[:, 2]) + velocity[:, 1] * np.sin(self.egos[:, 2])

    @property
    def ego_drives(self) -> Bool[Array, " t"]:
        """In which frames our car does not stand; how it drives is measured in these."""
        return np.abs(self.ego_speed) > EGO_DRIVING_SPEED

    @cached_property
    def poses(self) -> Float[Array, "n 3"]:
        """x, y, heading of the cars, in the plane of `egos`."""
        return world_poses(self.cars, self.egos)

    @cached_property
    def pieces(self) -> list[slice]:
        """Rows of the cars' tracks, cut where frames are missing."""
        return _runs(self.cars, np.ones(len(self.cars), dtype=bool))

    @cached_property
    def velocity(self) -> Float[Array, "n 2"]:
        """Of the cars, m/s."""
        return self._by_piece(self.poses[:, :2])

    @cached_property
    def speed(self) -> Float[Array, " n"]:
        """Of the cars along their headings, m/s."""
        heading = self.poses[:, 2]
        return self.velocity[:, 0] * np.cos(heading) + self.velocity[:, 1] * np.sin(heading)

    @cached_property
    def acceleration(self) -> Float[Array, " n"]:
        """Change of the cars' speed, m/s^2."""
        return self._by_piece(self.speed[:, None])[:, 0]

    @cached_property
    def tracks(self) -> list[slice]:
        """Rows of each car."""
        cuts = np.flatnonzero(np.diff(self.cars.ids)) + 1
        ends = [*cuts.tolist(), len(self.cars)] if len(self.cars) else []
        return [slice(a, b) for a, b in zip([0, *ends[:-1]], ends, strict=True)] if ends else []

    @cached_property
    def parked_tracks(self) -> Bool[Array, " k"]:
        """Which cars stay where they are as long as they have a label."""
        found = []
        for rows in self.tracks:
            places, count = self.poses[rows, :2], min(END_FRAMES, (rows.stop - rows.start + 1) // 2)
            moved = np.hypot(*(places[-count:].mean(axis=0) - places[:count].mean(axis=0)))
            frames = self.cars.frames[rows]
            seconds = (frames[-1] - frames[0]) * STEP_SECONDS
            found.append(moved < min(PARKED_METRES, LABEL_METRES + PARKED_SPEED * seconds))
        return np.array(found, dtype=bool)

    @cached_property
    def is_driving(self) -> Bool[Array, " n"]:
        """Which rows are of cars that drive in that frame."""
        parked = np.zeros(len(self.cars), dtype=bool)
        for rows, stays in zip(self.tracks, self.parked_tracks, strict=True):
            parked[rows] = stays
        return ~parked & (np.abs(self.speed) > DRIVING_SPEED)

    def _by_piece(self, values: Float[Array, "n k"]) -> Float[Array, "n k"]:
        found = np.zeros_like(values)
        for rows in self.pieces:
            found[rows] = slopes(values[rows])
        return found


def slopes(values: Float[Array, "n k"], frames: int = SMOOTHED_FRAMES) -> Float[Array, "n k"]:
    """Change a second of a series, from quadratics fitted to so many frames; 0 of one alone.

    At the ends, and where the series is shorter, fewer frames are on one side.
    """
    from scipy.signal import savgol_filter  # noqa: PLC0415, importing mot_sim waits for no SciPy

    window = min(frames, len(values) - 1 + len(values) % 2)
    if window < 3:
        moved = np.gradient(values, STEP_SECONDS, axis=0) if len(values) > 1 else 0.0 * values
        return np.asarray(moved)
    found = savgol_filter(values, window, 2, deriv=1, delta=STEP_SECONDS, axis=0)
    return np.asarray(found, dtype=np.float64)


def pitch_steps(drive: MeasuredDrive) -> Float[Array, " m"]:
    """Radians by which the camera pitches from each frame to the next."""
    if drive.Ts_world_cam is None:
        return np.zeros(0)
    R_world_cam = drive.Ts_world_cam[:, :3, :3]
    R_before_now = R_world_cam[:-1].swapaxes(1, 2) @ R_world_cam[1:]
    return np.arctan2(R_before_now[:, 2, 1], R_before_now[:, 2, 2])


def headways(drive: MeasuredDrive) -> Float[Array, " m"]:
    """Seconds to the rear of the next car in our lane, of each frame in which there is one.

    The lane is the way that our car drives later; straight on behind the end of the drive.
    """
    found = []
    way = _way_ahead(drive.egos)
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(way[:, :2], axis=0).T))))
    rears = 0.5 * drive.cars.cuboids.size[:, 0] if drive.cars.cuboids is not None else np.zeros(0)
    for frame in np.flatnonzero(drive.ego_speed > FOLLOWING_SPEED).tolist():
        rows = np.flatnonzero(drive.cars.frames == frame)
        end = int(np.searchsorted(along, along[frame] + MAX_HEADWAY_METRES))
        ahead = way[frame:end]
        apart = drive.poses[rows, None, :2] - ahead[None, :, :2]
        nearest = np.argmin(np.hypot(apart[..., 0], apart[..., 1]), axis=1)
        apart, heading = apart[np.arange(len(rows)), nearest], ahead[nearest, 2]
        c, s = np.cos(heading), np.sin(heading)
        aside = np.abs(c * apart[:, 1] - s * apart[:, 0])
        metres = along[frame + nearest] - along[frame] + c * apart[:, 0] + s * apart[:, 1]
        turned = np.abs(np.asarray(wrap_angle(drive.poses[rows, 2] - heading)))
        metres = metres - rears[rows]
        there = (aside < LANE_HALF_METRES) & (turned < ALIKE_RADIANS) & (metres > 0.0)
        if (there & (metres < MAX_HEADWAY_METRES)).any():
            found.append(metres[there].min() / drive.ego_speed[frame])
    return np.array(found, dtype=float)


def _way_ahead(egos: Float[Array, "t 3"]) -> Float[Array, "m 3"]:
    """The poses, and a straight way on."""
    on = np.arange(1.0, MAX_HEADWAY_METRES + 1.0)
    heading = egos[-1, 2]
    on = on[:, None] * (np.cos(heading), np.sin(heading), 0.0)
    return np.concatenate((egos, egos[-1] + on))


def lane_changes(drive: MeasuredDrive) -> int:
    """How often our car, or another as long as it has labels, changes its lane."""
    paths = [drive.egos[:, :2], *(drive.poses[rows, :2] for rows in drive.pieces)]
    return sum(map(_changes_of, paths))


def _changes_of(places: Float[Array, "n 2"]) -> int:
    """Of one way, with a place a frame."""
    if len(places) <= CHANGE_FRAMES:
        return 0
    velocity = slopes(places)
    heading = np.unwrap(np.arctan2(velocity[:, 1], velocity[:, 0]))
    before, after = heading[:-CHANGE_FRAMES], heading[CHANGE_FRAMES:]
    middle = 0.5 * (before + after)
    moved = places[CHANGE_FRAMES:] - places[:-CHANGE_FRAMES]
    aside = np.abs(np.cos(middle) * moved[:, 1] - np.sin(middle) * moved[:, 0])
    slow = np.hypot(velocity[:, 0], velocity[:, 1]) < FOLLOWING_SPEED
    before_that = np.concatenate(([0], np.cumsum(slow)))
    all_fast = before_that[CHANGE_FRAMES + 1 :] == before_that[: -CHANGE_FRAMES - 1]
    low, high = CHANGE_METRES
    changed = (np.abs(after - before) < CHANGE_RADIANS) & (aside > low) & (aside < high) & all_fast
    count, last = 0, -CHANGE_FRAMES
    for frame in np.flatnonzero(changed).tolist():
        if frame - last >= CHANGE_FRAMES:
            count, last = count + 1, frame
    return count


def overlaps(drive: MeasuredDrive) -> Float[Array, " m"]:
    """IoU of each car's boxes of two frames in a row."""
    cars = drive.cars
    same = (np.diff(cars.ids) == 0) & (np.diff(cars.frames) == 1)
    first = np.flatnonzero(same)
    return np.asarray(box_iou(cars.boxes[first], cars.boxes[first + 1]))


def occluded_seconds(drive: MeasuredDrive) -> Float[Array, " m"]:
    """How long each time lasts in which a car is largely occluded."""
    runs = _runs(drive.cars, _is_occluded(drive))
    return np.array([(each.stop - each.start) * STEP_SECONDS for each in runs], dtype=float)


def _is_occluded(drive: MeasuredDrive) -> Bool[Array, " n"]:
    assert drive.cars.occlusion is not None
    return drive.cars.occlusion >= 2


def _runs(cars: Tracks, there: Bool[Array, " n"]) -> list[slice]:
    """Rows of one car in frames in a row that are all there."""
    rows = np.flatnonzero(there)
    ends = (np.diff(rows) != 1) | (np.diff(cars.ids[rows]) != 0) | (np.diff(cars.frames[rows]) != 1)
    cuts = np.flatnonzero(ends) + 1
    return [slice(int(part[0]), int(part[-1]) + 1) for part in np.split(rows, cuts) if len(part)]


def _frame_counts(drive: MeasuredDrive) -> Int[Array, " t"]:
    return np.bincount(drive.cars.frames, minlength=len(drive))


def _crossing(drive: MeasuredDrive) -> Bool[Array, " m"]:
    """Of each row of a driving car, whether it heads across our heading."""
    rows = np.flatnonzero(drive.is_driving)
    off = np.abs(
        np.asarray(wrap_angle(drive.poses[rows, 2] - drive.egos[drive.cars.frames[rows], 2]))
    )
    return (off > CROSSING_RADIANS[0]) & (off < CROSSING_RADIANS[1])


def _relative_speeds(drive: MeasuredDrive) -> Float[Array, " n"]:
    """Along our heading, less ours; m/s, a row each."""
    heading = drive.egos[drive.cars.frames, 2]
    along = drive.velocity[:, 0] * np.cos(heading) + drive.velocity[:, 1] * np.sin(heading)
    return along - drive.ego_speed[drive.cars.frames]


def _heights(drive: MeasuredDrive) -> Float[Array, " n"]:
    return drive.cars.boxes[:, 3] - drive.cars.boxes[:, 1]


Sampled = Callable[[MeasuredDrive], Array | int]
Summary = Callable[[Array], float]


def _quantile(share: float) -> Summary:
    return lambda samples: float(np.quantile(samples, share))


def _mean(samples: Array) -> float:
    return float(np.mean(samples))


@dataclass(frozen=True, eq=False)
class DriveStatistic:
    """One thing that is measured of drives."""

    title: str
    """What it is, with its unit."""
    samples: Sampled
    """All values of a drive; or a count alone, of what is counted by the minute."""
    summary: Summary | None
    """One number of many values; None: counts by the minute, which have no distribution."""

    def of(self, drives: Sequence[MeasuredDrive]) -> float:
        """Of these drives as if they were one; NaN where it was never to be seen."""
        found = np.concatenate([np.atleast_1d(self.samples(drive)) for drive in drives])
        if self.summary is None:
            return float(found.sum()) / sum(drive.minutes for drive in drives)
        return self.summary(found) if len(found) else float("nan")

    def shown(self, drives: Sequence[MeasuredDrive]) -> list[Array]:
        """The samples of each drive that has some."""
        found = (np.atleast_1d(self.samples(drive)) for drive in drives)
        return [each for each in found if len(each)]


DRIVE_STATISTICS: Mapping[str, DriveStatistic] = {
    "ego_standing": DriveStatistic("we stand, share", lambda d: ~d.ego_drives, _mean),
    "ego_speed": DriveStatistic(
        "our speed, m/s", lambda d: d.ego_speed[d.ego_drives], _quantile(0.5)
    ),
    "ego_yaw_rate": DriveStatistic(
        "our |yaw rate|, 90 %, deg/s",
        lambda d: np.degrees(np.abs(slopes(d.egos[:, 2:])[d.ego_drives, 0])),
        _quantile(0.9),
    ),
    "ego_acceleration": DriveStatistic(
        "our |acceleration|, 90 %, m/s2",
        lambda d: np.abs(slopes(d.ego_speed[:, None])[d.ego_drives, 0]),
        _quantile(0.9),
    ),
    "pitch_step": DriveStatistic(
        "pitch of the camera, change in a frame, deg",
        lambda d: np.degrees(np.abs(pitch_steps(d))),
        _quantile(0.5),
    ),
    "acceleration": DriveStatistic(
        "|acceleration| of driving cars, m/s2",
        lambda d: np.abs(d.acceleration[d.is_driving]),
        _quantile(0.5),
    ),
    "relative_speed": DriveStatistic(
        "speed of cars less ours, m/s", _relative_speeds, _quantile(0.5)
    ),
    "headway": DriveStatistic("headway to the car ahead, s", headways, _quantile(0.5)),
    "lane_changes": DriveStatistic("lane changes a minute", lane_changes, None),
    "parked": DriveStatistic("parked cars, share", lambda d: d.parked_tracks, _mean),
    "crossing": DriveStatistic("driving cars that cross, share", _crossing, _mean),
    "cars": DriveStatistic("cars a frame", _frame_counts, _mean),
    "ids": DriveStatistic("cars a minute", lambda d: len(d.tracks), None),
    "iou": DriveStatistic("IoU of boxes in a row", overlaps, _quantile(0.5)),
    "low_iou": DriveStatistic("IoU of boxes in a row, 10 %", overlaps, _quantile(0.1)),
    "occluded": DriveStatistic("largely occluded, share", _is_occluded, _mean),
    "occlusion_run": DriveStatistic("length of occlusions, s", occluded_seconds, _quantile(0.5)),
    "height": DriveStatistic("height of boxes, px", _heights, _quantile(0.5)),
    "tall": DriveStatistic("height of boxes, 90 %, px", _heights, _quantile(0.9)),
}
