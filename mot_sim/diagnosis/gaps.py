"""Frames in which the detector has no box for a car that it had before and has again later."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Int
from numpy import ndarray as Array

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.diagnosis.context_events import NO_PARTNER, EventRow
from mot_sim.diagnosis.runs_of_frames import by_id
from mot_sim.metrics.matching import match
from mot_sim.metrics.overlaps import EPSILON, Overlaps
from mot_sim.metrics.preprocessing import MIN_OVERLAP
from tracker.types import Tracks


def detector_gaps(cars: Tracks, log: DetectionLog, frames: Int[Array, " k"]) -> Iterator[EventRow]:
    """The gaps of every car. frames: those that come.

    A car is detected where a box of any score overlaps its label by half, a box for each car.
    """
    cars = cars.select(np.isin(cars.frames, frames))
    detected = _detected(cars, log)
    for car, rows in by_id(cars.ids):
        seen = np.flatnonzero(detected[rows])
        if not len(seen):
            continue
        inner = rows[seen[0] : seen[-1] + 1]
        # Frames that never come are no gap of the detector, and end none.
        steps = np.searchsorted(frames, cars.frames[inner])
        found = steps[detected[inner]]
        for a, b in zip(found[:-1].tolist(), found[1:].tolist(), strict=True):
            if b > a + 1:
                yield (
                    "detector gap",
                    int(frames[a + 1]),
                    int(frames[b - 1]),
                    car,
                    NO_PARTNER,
                    np.nan,
                )


def _detected(cars: Tracks, log: DetectionLog) -> Array:
    """Which labels have a box; the most overlap in each frame goes first."""
    boxes = Tracks(log.frames, np.arange(len(log.frames)), log.detections.boxes)
    overlaps = Overlaps.between(cars, boxes)
    near = np.flatnonzero(overlaps.iou >= MIN_OVERLAP - EPSILON)
    found = np.zeros(len(cars), bool)
    found[overlaps.rows[match(overlaps, near, overlaps.iou[near])]] = True
    return found


__all__ = ["detector_gaps"]
