"""Tracks detected cuboids, those of a LiDAR detector: the default tracker, placed by them."""

from dataclasses import dataclass, replace

import numpy as np

from tracker.beliefs import Beliefs, Lift
from tracker.errors import MissingCue
from tracker.tracker import Tracker
from tracker.types import Camera, Cuboids, Detections


@dataclass(frozen=True)
class CuboidLift(Lift):
    """Beliefs stand where the detector's cuboids do; back-projects only boxes without one.

    Unlike the paper, whose detections are boxes. As AB3DMOT: yaw and size are those measured.
    """

    place_std: float = 0.15
    """Std of the place of a cuboid along road x and z, metres; PointRCNN on KITTI: .1 at the
    median. More: tracks follow their cuboids less closely."""

    def __call__(self, detections: Detections, camera: Camera) -> Beliefs:
        """One belief a detection; see `Detections.base`. Raises MissingCue where none has one."""
        beliefs = super().__call__(detections, camera)
        if not len(detections):
            return beliefs
        if detections.base is None:
            raise MissingCue(
                "these detections have no cuboids: give Detections the columns `base`, `yaw` and "
                "`size` (mot-sim: --cuboids, with a detector that has some), or take the tracker "
                "default"
            )
        known = np.isfinite(detections.base).all(axis=1)
        base = np.where(known[:, None], detections.base, beliefs.cuboids.base)
        cov = beliefs.cov.copy()
        cov[known, :2, :2] = np.eye(2) * self.place_std**2
        cuboids = Cuboids(base, beliefs.cuboids.yaw, beliefs.cuboids.size)
        return beliefs.replaced(cuboids=cuboids, cov=cov)


def cuboid_tracker(camera: Camera) -> Tracker:
    """The default tracker for detections with cuboids (`Detections.base`, yaw and size).

    The same association and life of tracks as for boxes; what is put out are the cuboids, filtered.
    """
    return replace(Tracker.default(camera), lift=CuboidLift(use_box_height=True), car_filter=None)
