"""What a KITTI label file says of the truth: cars, and DontCare where a car is too small."""

import numpy as np
from jaxtyping import Bool
from numpy import ndarray as Array

from mot_sim.simulation.truth.table import Truth
from tracker.types import Cuboids, Tracks

# KITTI's labels end at about 80 m (the 99.9th percentile of the given sequences) and 15 pixels
# (the 1st percentile of the heights); what is smaller or farther lies in DontCare regions.
MIN_HEIGHT = 15.0
MAX_DISTANCE = 80.0
DONT_CARE = "DontCare"


def labels(truth: Truth) -> Tracks:
    """The tracks as KITTI labels them; small and far cars that are seen are DontCare, id -1.

    Such cars of which nothing is seen have no label at all. Everything else keeps its row.
    """
    tracks, ignored = truth.tracks, too_small(truth)
    kept = np.flatnonzero(~ignored | (truth.pixels > 0))
    tracks, ignored = tracks.select(kept), ignored[kept]
    assert tracks.kinds is not None
    assert tracks.cuboids is not None
    assert tracks.truncation is not None
    assert tracks.occlusion is not None
    hole = np.where(ignored, np.nan, 1.0)
    cuboids = Cuboids(
        tracks.cuboids.base * hole[:, None],
        tracks.cuboids.yaw * hole,
        tracks.cuboids.size * hole[:, None],
    )
    return Tracks(
        tracks.frames,
        np.where(ignored, -1, tracks.ids),
        tracks.boxes,
        None,
        np.where(ignored, DONT_CARE, tracks.kinds),
        np.where(ignored, -1, tracks.truncation),
        np.where(ignored, -1, tracks.occlusion),
        cuboids,
    )


def too_small(truth: Truth) -> Bool[Array, " n"]:
    """Which cars KITTI's annotators would have left out."""
    cuboids = truth.tracks.cuboids
    assert cuboids is not None
    height = truth.amodal_boxes[:, 3] - truth.amodal_boxes[:, 1]
    distance = np.hypot(cuboids.base[:, 0], cuboids.base[:, 2])
    return (height < MIN_HEIGHT) | (distance > MAX_DISTANCE)
