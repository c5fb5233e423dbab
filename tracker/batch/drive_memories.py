"""What a tracker remembers of each of many drives, beside its tracks; one row per drive."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.batch.prepared_frames import FrameMotions
from tracker.car_filter import CarFilter, RoadMemory
from tracker.existence import (
    LEAVING_MARGIN_PIXELS,
    MAX_COVERED_SHARE,
    MAX_PROBABILITY,
    MIN_KNOWN_HITS,
    DetectorStatistics,
    ExistenceFilter,
)
from tracker.lifecycle import MAX_CONSECUTIVE_STEPS, ActiveTracks
from tracker.types import Camera
from tracker.types.rows import Rows


@dataclass(frozen=True, eq=False)
class DriveRoads(Rows):
    """`RoadMemory` of every drive."""

    slope: Float[Array, " e"]
    """How much lower the road lies per metre of distance."""
    slope_var: Float[Array, " e"]
    """Its variance."""
    traffic: Float[Array, "e 5 2"]
    """Seconds of traffic in each strip: the camera's way, and oncoming."""
    camera_velocity_cov: Float[Array, "e 2 2"]
    """Covariance of the camera's velocity, m^2/s^2."""
    flatness: Float[Array, " e"]
    """How much likelier the boxes are on a flat road, nats."""

    @classmethod
    def unknown(cls, count: int) -> "DriveRoads":
        """Nothing known yet."""
        rows = [RoadMemory()] * count
        return cls(*(np.array([row[at] for row in rows], float) for at in range(5)))

    def predicted(
        self, cars: CarFilter, motions: FrameMotions
    ) -> tuple["DriveRoads", Float[Array, " e"]]:
        """After the motions of a frame; the slopes before they fell back to 0 in that time."""
        std = cars.road.slope_std
        flatness = motions.kept[:, 0] * self.flatness
        traffic = self.traffic * motions.kept[:, 2, None, None]
        velocity = motions.velocity_cov
        velocity = np.where(np.isnan(velocity), self.camera_velocity_cov, velocity)
        if std == 0.0:
            none = np.zeros(len(self))
            return DriveRoads(none, none, traffic, velocity, flatness), none
        moved = self.slope + motions.rise
        var = motions.squared * np.minimum(self.slope_var, std**2)
        var = var + (1.0 - motions.squared) * std**2
        return DriveRoads(motions.kept[:, 1] * moved, var, traffic, velocity, flatness), moved

    def roughness(self, cars: CarFilter) -> Float[Array, " e"]:
        """The factor of each drive's road, see `RoughnessModel`."""
        of = cars.roughness
        return np.array([of(RoadMemory(flatness=each)) for each in self.flatness.tolist()])

    def after_boxes(
        self, cars: CarFilter, sums: Float[Array, "e 3"], counts: Int[Array, " e"]
    ) -> "DriveRoads":
        """After boxes of so many cars of each drive, of which the sums tell."""
        flatness = self.flatness + 0.5 * sums[:, 2] / cars.roughness.repetition
        if cars.road.slope_std == 0.0:
            return self.replaced(flatness=flatness)
        before = 1.0 / np.minimum(self.slope_var, cars.road.slope_std**2)
        total = before + sums[:, 0]
        slope = (before * self.slope + sums[:, 1]) / total
        seen = counts > 0
        return self.replaced(
            slope=np.where(seen, slope, self.slope),
            slope_var=np.where(seen, 1.0 / total, self.slope_var),
            flatness=np.where(seen, flatness, self.flatness),
        )


@dataclass(frozen=True, eq=False)
class DriveDetectors(Rows):
    """`DetectorStatistics` of every drive."""

    hits: Int[Array, " e"]
    """How many of `tries` were detected."""
    tries: Int[Array, " e"]
    """Frames in which a known track was detected, or missed in plain view."""
    confirmed: Int[Array, " e"]
    """How many of `newborns` were detected again."""
    newborns: Int[Array, " e"]
    """First detections whose next frame told."""

    @classmethod
    def unknown(cls, count: int) -> "DriveDetectors":
        """Nothing known yet."""
        start = vars(DetectorStatistics())
        return cls(*(np.full(count, start[name]) for name in cls.__match_args__))

    def learned(
        self,
        matched: tuple[ActiveTracks, Int[Array, " k"]],
        unmatched: tuple[ActiveTracks, Int[Array, " l"]],
        covered: Float[Array, " l"],
        dt: Float[Array, " e"],
        camera: Camera,
    ) -> "DriveDetectors":
        """After a frame: `ExistenceFilter.learn`. Tracks with the drive of each."""
        count, (seen, of_seen), (missed, of_missed) = len(self), matched, unmatched
        one_step = MAX_CONSECUTIVE_STEPS * dt
        known = seen.hits >= MIN_KNOWN_HITS
        again = (seen.hits == 1) & (seen.time_since_update <= one_step[of_seen])
        boxes, first = missed.beliefs.boxes, missed.time_since_update <= one_step[of_missed]
        right = camera.image_size[0] - 1.0 - LEAVING_MARGIN_PIXELS
        plain = (
            first
            & (covered < MAX_COVERED_SHARE)
            & (boxes[:, 0] >= LEAVING_MARGIN_PIXELS)
            & (boxes[:, 2] <= right)
        )
        hits, confirmed, misses, vanished = (
            np.bincount(drives[which], minlength=count)
            for drives, which in (
                (of_seen, known),
                (of_seen, again),
                (of_missed, plain & (missed.hits >= MIN_KNOWN_HITS)),
                (of_missed, plain & (missed.hits == 1)),
            )
        )
        return DriveDetectors(
            self.hits + hits,
            self.tries + hits + misses,
            self.confirmed + confirmed,
            self.newborns + confirmed + vanished,
        )

    def detected(self, how: ExistenceFilter) -> Float[Array, " e"]:
        """P_D of every drive's."""
        prior = how.detection_prior
        return (self.hits + how.detection_probability * prior) / (self.tries + prior)

    def newborn_worth(self, how: ExistenceFilter) -> Float[Array, " e"]:
        """The share of their score that first detections count, see `ExistenceFilter.newborn`."""
        prior = how.birth_prior
        confirmed = self.confirmed + how.birth_probability * prior
        worth = confirmed / (self.newborns + prior) / np.maximum(self.detected(how), 0.5)
        return np.minimum(1.0, worth)


def existence_after(
    how: ExistenceFilter,
    learned: DriveDetectors,
    matched: tuple[ActiveTracks, Int[Array, " k"], Float[Array, " k"]],
    unmatched: tuple[ActiveTracks, Int[Array, " l"], Float[Array, " l"]],
    born: tuple[Int[Array, " b"], Float[Array, " b"]],
) -> tuple[Float[Array, " k"], Float[Array, " l"], Float[Array, " b"]]:
    """The probabilities after a frame: `ExistenceFilter.hit`, `miss` and `newborn`.

    matched: tracks, drives, scores. unmatched: tracks, drives, covered shares. born: drives and
    scores.
    """
    worth, detected = learned.newborn_worth(how), learned.detected(how)

    def newborn(drives: Array, scores: Array) -> Array:
        return np.minimum(np.maximum(scores, 0.0) * worth[drives], MAX_PROBABILITY)

    seen, of_seen, scores = matched
    odds = (
        seen.existence / (1.0 - seen.existence) * (how.likelihood_ratio * np.maximum(scores, 0.0))
    )
    hit = np.minimum(np.maximum(odds / (1.0 + odds), newborn(of_seen, scores)), MAX_PROBABILITY)
    tracks, of_missed, covered = unmatched
    missed = 1.0 - detected[of_missed] * (1.0 - covered)
    miss = tracks.existence * missed / (1.0 - tracks.existence * (1.0 - missed))
    return hit, miss, newborn(*born)


def slopes_of(
    roads: DriveRoads, moved: Float[Array, " e"], cars: CarFilter, motions: FrameMotions
) -> tuple[Float[Array, "e 4"], Float[Array, "e 3"]]:
    """`RoadStep.numbers` of every drive, and its stds off the road with its roughness."""
    roughness = roads.roughness(cars)
    steps, off_road = np.empty((len(roads), 4)), np.empty((len(roads), 3))
    steps[:, 0], steps[:, 1] = motions.turn, motions.dt
    steps[:, 2], steps[:, 3] = roughness * moved, roughness * roads.slope
    off_road[:, :2], off_road[:, 2] = cars.motion.off_road_std, roughness
    return steps, off_road


__all__ = ["DriveDetectors", "DriveRoads", "existence_after", "slopes_of"]
