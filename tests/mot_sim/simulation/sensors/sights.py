"""Sightings made by hand for the tests of the effects."""

import numpy as np

from mot_sim.simulation.rig import Rig
from mot_sim.simulation.sensors import Sightings
from tracker.types import Cuboids

CAMERA = Rig.kitti().camera
STEP = 0.1


def sightings_of(
    ids, frames, visible=1.0, height=60.0, kind="Car", cut=0.0, seen=None, depth=25.0
) -> Sightings:
    """Boxes of a height and twice the width in the middle of the image, side by side by id."""
    ids, frames = np.asarray(ids, np.int64), np.asarray(frames, np.int64)
    count = len(ids)
    high = np.broadcast_to(np.asarray(height, float), (count,)).copy()
    left = 300.0 + 10.0 * (ids % 40)
    boxes = np.stack((left, 200.0 - high / 2, left + 2 * high, 200.0 + high / 2), axis=1)
    base = np.stack((np.zeros(count), np.zeros(count), np.full(count, depth)), axis=1)
    return Sightings(
        frames=frames,
        ids=ids,
        boxes=boxes,
        amodal_boxes=boxes,
        visible_boxes=np.full((count, 4), np.nan) if seen is None else seen,
        visible=np.broadcast_to(np.asarray(visible, float), (count,)).copy(),
        truncation=np.broadcast_to(np.asarray(cut, float), (count,)).copy(),
        depth=np.full(count, depth),
        kinds=np.full(count, kind, dtype="<U8"),
        cuboids=Cuboids(base, np.full(count, 0.3), np.tile([4.0, 1.5, 1.8], (count, 1))),
    )


def crowd(objects=200, frames=100, **more) -> Sightings:
    """Every object in every frame, in the order of frames."""
    return sightings_of(
        np.tile(np.arange(objects), frames), np.repeat(np.arange(frames), objects), **more
    )


def by_object(values, objects=200):
    """Rows of a crowd as (frame, object)."""
    return np.asarray(values).reshape(-1, objects, *np.asarray(values).shape[1:])


def lag_one(values) -> float:
    """The correlation of neighbouring frames, over all objects."""
    return float(np.corrcoef(values[:-1].ravel(), values[1:].ravel())[0, 1])
