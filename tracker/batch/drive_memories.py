"""What a tracker remembers of each of many drives, beside its tracks; one row per drive."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.batch.prepared_frames import FrameMotions
from tracker.car_filter import CarFilter, RoadMemory
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


__all__ = ["DriveRoads", "slopes_of"]
