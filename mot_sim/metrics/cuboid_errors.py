"""What is wrong with cuboids: where they stand, how they are turned, how large and how fast.

Rows of the output are matched to labels in the image (IoU of at least 1/2), so that the errors of
cuboids far from their car are among them. Neutral labels count: hidden and truncated cars stand
somewhere, too.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.clear import Number
from mot_sim.metrics.consistency import Consistency, brier_score, squared_deviations
from mot_sim.metrics.cuboid_overlap import centre_distance, cuboid_iou
from mot_sim.metrics.cuboid_preparation import require_cuboids, rows_of_class
from mot_sim.metrics.matching import Overlaps, bare_rows
from mot_sim.metrics.preprocessing import checked_columns, match_cars
from tracker.geometry import wrap_angle
from tracker.types import CarEstimates, Cuboids, Rows, Tracks

# Ends of the ranges of distance that errors are shown by, m.
DISTANCE_RANGES = (0.0, 10.0, 20.0, 30.0, 50.0, 80.0)
# A car faces our way, or comes towards us, when its heading is off by less; otherwise it turned.
MAX_ALONG = np.radians(30.0)
# What a heading may be off by before it is wrong, and before it is backwards.
WRONG, BACKWARDS = np.radians(30.0), np.radians(90.0)
NEAR = 2.0  # m; centres within it are right
# A car moves when it is faster than this, m/s: KITTI's labels of parked cars wobble by less.
MIN_SPEED = 1.0
# Where yaw, speed and the logarithms of the size stand in a state, see `CarEstimates`.
YAW, SPEED, SIZE = slice(3, 4), slice(4, 5), slice(5, 8)
# Speeds are taken over this time before and after a frame, s; a second smooths the labels.
SPEED_SPAN = 1.0


@dataclass(frozen=True, eq=False)
class StatedErrors(Rows):
    """Errors in units of the covariance that the output states for them; NaN: it states none."""

    radial_std: Float[Array, " n"]
    """Stated std of the centre along the viewing ray, m."""
    centre: Float[Array, " n"]
    """e' C^-1 e of the centre seen from above, two components."""
    heading: Float[Array, " n"]
    """Of the heading, one component; NaN where it is backwards, which `heading_known` is about."""
    speed: Float[Array, " n"]
    """Of the speed, one component."""
    size: Float[Array, " n"]
    """Of the logarithms of length, height and width, three components."""
    heading_known: Float[Array, " n"]
    """Stated probability that the heading is not the other way round."""

    @classmethod
    def unknown(cls, count: int) -> "StatedErrors":
        """Of output that states nothing."""
        return cls(*(np.full(count, np.nan) for _ in range(6)))

    @property
    def consistency(self) -> dict[str, Consistency]:
        """How honest each stated covariance is."""
        return {
            "centre": Consistency.of(self.centre, 2), "heading": Consistency.of(self.heading, 1),
            "speed": Consistency.of(self.speed, 1), "size": Consistency.of(self.size, 3),
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class CuboidErrors(Rows):
    """One row per label that a row of the output matches in the image; NaN: not known."""

    frames: Int[Array, " n"]
    """Frame of both."""
    truth_ids: Int[Array, " n"]
    """Id of the label."""
    output_ids: Int[Array, " n"]
    """Id of the output."""
    distance: Float[Array, " n"]
    """Of the label from the camera, seen from above, m."""
    bearing: Float[Array, " n"]
    """Of the label, right of straight ahead, rad."""
    centre: Float[Array, " n"]
    """Distance of the two centres, seen from above, m."""
    radial: Float[Array, " n"]
    """How much too far the cuboid stands along the viewing ray, m."""
    lateral: Float[Array, " n"]
    """How much too far to the right of the viewing ray it stands, m."""
    vertical: Float[Array, " n"]
    """How much too low the cuboid stands, m."""
    heading: Float[Array, " n"]
    """The cuboid's yaw less the label's, in [-pi, pi), rad."""
    yaw: Float[Array, " n"]
    """The label's yaw, rad; -pi/2: it faces our way."""
    size: Float[Array, "n 3"]
    """Length, height and width less the label's, m."""
    iou: Float[Array, " n"]
    """Intersection over union of the volumes, 0 where the cuboid is not wholly known."""
    speed: Float[Array, " n"]
    """The label's, over the ground, m/s; NaN without the camera's motion."""
    found_speed: Float[Array, " n"]
    """The output's speed: as stated, or else as its cuboids move, m/s."""
    drift: Float[Array, " n"]
    """How fast the output's cuboids move over the ground, m/s."""
    stated: StatedErrors
    """The errors against the uncertainty that the output states."""

    @property
    def moving(self) -> Bool[Array, " n"]:
        """Labels that move."""
        return self.speed > MIN_SPEED

    @property
    def parked(self) -> Bool[Array, " n"]:
        """Labels that stand."""
        return self.speed <= MIN_SPEED

    @property
    def oncoming(self) -> Bool[Array, " n"]:
        """Labels that face the camera."""
        return np.abs(np.asarray(wrap_angle(self.yaw - np.pi / 2))) < MAX_ALONG

    @property
    def turned(self) -> Bool[Array, " n"]:
        """Labels that face neither our way nor the camera."""
        ahead = np.abs(np.asarray(wrap_angle(self.yaw + np.pi / 2))) < MAX_ALONG
        return ~(ahead | self.oncoming)

    def from_above(self) -> tuple[Float[Array, "n 2"], Float[Array, "n 2"]]:
        """Where labels and cuboids stand: metres right of and ahead of the camera."""
        ahead = np.stack([np.sin(self.bearing), np.cos(self.bearing)], axis=1)
        aside = np.stack([np.cos(self.bearing), -np.sin(self.bearing)], axis=1)
        places = self.distance[:, None] * ahead
        return places, places + self.radial[:, None] * ahead + self.lateral[:, None] * aside

    def groups(self) -> dict[str, Bool[Array, " n"]]:
        """The rows by what the car does: all, moving, parked, oncoming, turned."""
        return {
            "all": np.ones(len(self), dtype=bool), "moving": self.moving, "parked": self.parked,
            "oncoming": self.oncoming, "turned": self.turned,
        }  # fmt: skip

    def numbers(self) -> dict[str, Number]:
        """Every score by its name: medians and shares over all rows; NaN over none."""
        headings = {
            name.removesuffix("_all"): value
            for group, rows in self.groups().items()
            for name, value in (
                (f"heading_over_30_{group}", over(self.heading[rows], WRONG)),
                (f"heading_over_90_{group}", over(self.heading[rows], BACKWARDS)),
            )
        }
        return {
            "matched_rows": len(self),
            "cuboid_known": share(np.isfinite(self.centre)),
            "centre_median": median(self.centre),
            "centre_p90": quantile(self.centre, 0.9),
            "within_2m": share(self.centre[np.isfinite(self.centre)] <= NEAR),
            "radial_median": median(self.radial),
            "lateral_median": median(self.lateral),
            "vertical_median": median(self.vertical),
            **headings,
            "length_error": median(self.size[:, 0]),
            "height_error": median(self.size[:, 1]),
            "width_error": median(self.size[:, 2]),
            "iou_3d": mean(self.iou),
            "speed_error": median((self.found_speed - self.speed)[self.moving]),
            "parked_over_1mps": over(self.found_speed[self.parked], MIN_SPEED),
            "parked_drift": median(self.drift[self.parked]),
            **self.honesty(),
        }

    def honesty(self) -> dict[str, Number]:
        """Shares inside 1 and 2 sigma and NEES of each stated covariance, and of the heading's
        stated chance the mean, how often it came true, and the Brier score."""
        numbers: dict[str, Number] = {}
        for what, consistency in self.stated.consistency.items():
            numbers |= consistency.numbers(what)
        chances, right = self.stated.heading_known, self.heading_right
        known = np.isfinite(chances) & np.isfinite(right)
        return numbers | {
            "heading_known": mean(chances[known]),
            "heading_known_true": mean(right[known]),
            "heading_known_brier": brier_score(chances, right),
        }

    @property
    def heading_right(self) -> Float[Array, " n"]:
        """1 where the cuboid faces the label's way, 0 where it is backwards, NaN: not known."""
        right = np.abs(self.heading) <= BACKWARDS
        return np.where(np.isfinite(self.heading), right, np.nan)

    def by_distance(self) -> list[tuple[str, "CuboidErrors"]]:
        """The rows by the label's distance, with the name of each range."""
        place = np.searchsorted(DISTANCE_RANGES, self.distance, side="right")
        return [
            (f"{low:.0f}-{high:.0f} m", self.select(place == number))
            for number, (low, high) in enumerate(pairwise(DISTANCE_RANGES), 1)
        ]


def median(errors: Float[Array, " n"]) -> float:
    """The median size of the errors that are known; NaN without any."""
    return quantile(errors, 0.5)


def mean(numbers: Float[Array, " n"]) -> float:
    """The mean; NaN of none."""
    return float(numbers.mean()) if len(numbers) else np.nan


def quantile(errors: Float[Array, " n"], part: float) -> float:
    """What a part of the known errors does not exceed in size; NaN without any."""
    known = np.abs(errors[np.isfinite(errors)])
    return float(np.quantile(known, part)) if len(known) else np.nan


def over(errors: Float[Array, " n"], limit: float) -> float:
    """The share of the known errors that exceed a limit in size; NaN without any."""
    return share(np.abs(errors[np.isfinite(errors)]) > limit)


def share(holds: Bool[Array, " n"]) -> float:
    """The share of rows where it holds; NaN of none."""
    return float(holds.mean()) if len(holds) else np.nan


def cuboid_errors(
    truth: Tracks,
    output: Tracks,
    frame_count: int,
    Ts_world_road: Float[Array, "m 4 4"] | None = None,
    frame_rate: float = 10.0,
    kind: str = "Car",
) -> CuboidErrors:
    """The errors of one sequence, both tables in the road frame of the row's frame.

    Ts_world_road: for each frame where the road frame stands in a fixed world; without it no car
    has a speed over the ground. What the output states of its states (`Tracks.estimates`) is held
    against the errors. Raises BadTracks as `prepare_sequence`, and for tables without cuboids.
    """
    truth, output = checked_columns(truth, "truth"), checked_columns(output, "output")
    labels = rows_of_class(truth, kind)
    ours = rows_of_class(output, kind, with_similar=False)
    overlaps = Overlaps.between(
        _bare(truth, labels, frame_count, "truth"), _bare(output, ours, frame_count, "output")
    )
    pairs = match_cars(overlaps)
    rows, columns = labels[overlaps.rows[pairs]], ours[overlaps.columns[pairs]]
    theirs = require_cuboids(truth, "truth").select(rows)
    found = require_cuboids(output, "output").select(columns)
    known = np.isfinite(theirs.base).all(axis=1)
    rows, columns = rows[known], columns[known]
    theirs, found = theirs.select(known), found.select(known)
    drift = ground_speeds(output, Ts_world_road, frame_rate)
    distance = np.hypot(theirs.base[:, 0], theirs.base[:, 2])
    ray = theirs.base[:, ::2] / np.maximum(distance, 1e-9)[:, None]
    off = (found.base - theirs.base)[:, ::2]
    speed = ground_speeds(truth, Ts_world_road, frame_rate)[rows]
    heading = np.asarray(wrap_angle(found.yaw - theirs.yaw))
    estimates = None if output.estimates is None else output.estimates.select(columns)
    return CuboidErrors(
        frames=truth.frames[rows],
        truth_ids=truth.ids[rows],
        output_ids=output.ids[columns],
        distance=distance,
        bearing=np.arctan2(theirs.base[:, 0], theirs.base[:, 2]),
        centre=centre_distance(found, theirs),
        radial=(off * ray).sum(axis=1),
        lateral=off[:, 0] * ray[:, 1] - off[:, 1] * ray[:, 0],
        vertical=found.base[:, 1] - theirs.base[:, 1],
        heading=heading,
        yaw=theirs.yaw,
        size=found.size - theirs.size,
        iou=cuboid_iou(theirs, found),
        speed=speed,
        found_speed=drift[columns] if estimates is None else estimates.speed,
        drift=drift[columns],
        stated=_stated(theirs, found, heading, speed, estimates),
    )


def _stated(
    theirs: Cuboids,
    found: Cuboids,
    heading: Float[Array, " n"],
    speed: Float[Array, " n"],
    estimates: CarEstimates | None,
) -> StatedErrors:
    """The errors of matched rows in units of what the output states."""
    if estimates is None:
        return StatedErrors.unknown(len(heading))
    covs = estimates.covs
    turn = np.where(np.abs(heading) <= BACKWARDS, heading, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.log(found.size) - np.log(theirs.size)
    ray = theirs.base[:, ::2] / np.maximum(np.hypot(*theirs.base[:, ::2].T), 1e-9)[:, None]
    return StatedErrors(
        np.sqrt(np.einsum("ni,nij,nj->n", ray, covs[:, :3:2, :3:2], ray)),
        squared_deviations((found.base - theirs.base)[:, ::2], covs[:, :3:2, :3:2]),
        squared_deviations(turn[:, None], covs[:, YAW, YAW]),
        squared_deviations((estimates.speed - speed)[:, None], covs[:, SPEED, SPEED]),
        squared_deviations(size, covs[:, SIZE, SIZE]),
        estimates.heading_known,
    )


def _bare(tracks: Tracks, rows: Int[Array, " k"], frame_count: int, where: str) -> Tracks:
    """Frames, ids and boxes of some rows, checked."""
    chosen = tracks.select(rows)
    return bare_rows(chosen, np.ones(len(chosen), dtype=bool), frame_count, where)


def ground_speeds(
    tracks: Tracks, Ts_world_road: Float[Array, "m 4 4"] | None, frame_rate: float
) -> Float[Array, " n"]:
    """How fast each row's cuboid moves over the ground, m/s.

    Its way from the first to the last row of its id within SPEED_SPAN, over the time between.
    NaN without the camera's motion, without another such row, and for ids below 0.
    """
    speeds = np.full(len(tracks), np.nan)
    if Ts_world_road is None or tracks.cuboids is None:
        return speeds
    rows = np.flatnonzero(np.isfinite(tracks.cuboids.base).all(axis=1) & (tracks.ids >= 0))
    rows = rows[np.lexsort((tracks.frames[rows], tracks.ids[rows]))]
    if not len(rows):
        return speeds
    frames = tracks.frames[rows]
    T = Ts_world_road[frames]
    places = np.einsum("nij,nj->ni", T[:, :3, :3], tracks.cuboids.base[rows]) + T[:, :3, 3]
    span = round(SPEED_SPAN * frame_rate)
    numbers = np.unique(tracks.ids[rows], return_inverse=True)[1]
    moments = numbers * (int(frames.max()) + 2 * span + 2) + frames
    first = np.searchsorted(moments, moments - span)
    last = np.searchsorted(moments, moments + span, side="right") - 1
    seconds = (frames[last] - frames[first]) / frame_rate
    way = np.linalg.norm(places[last] - places[first], axis=1)
    speeds[rows] = np.divide(way, seconds, out=np.full(len(rows), np.nan), where=seconds > 0.0)
    return speeds
