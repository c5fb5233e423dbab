"""Two cars near each other in the image: they cross, or they look alike."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float, Int, Shaped
from numpy import ndarray as Array

from mot_sim.diagnosis.context_events import EventRow
from mot_sim.diagnosis.runs_of_frames import runs_of_frames
from mot_sim.metrics.overlaps import same_frame_pairs
from tracker.geometry import box_intersection
from tracker.types import Rows, Tracks

MAX_PAIR_GAP_FRAMES = 5  # frames that two cars may be apart for without ending a meeting
LOOK_ALIKE_MARGIN = 0.5  # look-alikes are near when boxes grown by this part of their sides touch


def box_crossings(cars: Tracks) -> Iterator[EventRow]:
    """Meetings of two cars whose boxes share area and whose centres change sides meanwhile."""
    for a, b, frames, rows_a, rows_b in shared_areas(cars, cars.boxes):
        middle = cars.boxes[:, 0] + cars.boxes[:, 2]
        side = np.sign(middle[rows_a] - middle[rows_b])
        if (side > 0).any() and (side < 0).any():
            yield "crossing", int(frames[0]), int(frames[-1]), a, b, np.nan


def look_alike_pairs(
    cars: Tracks, ids: Int[Array, " n"], looks: Shaped[Array, " n"]
) -> Iterator[EventRow]:
    """Meetings of two cars of one look. looks: of ids, which increase; equal: they look alike."""
    look = looks[np.searchsorted(ids, cars.ids)] if len(ids) else looks
    sides = LOOK_ALIKE_MARGIN * 0.5 * (cars.boxes[:, 2:] - cars.boxes[:, :2])
    grown = np.concatenate((cars.boxes[:, :2] - sides, cars.boxes[:, 2:] + sides), axis=1)
    for a, b, frames, rows_a, rows_b in shared_areas(cars, grown):
        if look[rows_a[0]] == look[rows_b[0]]:
            yield "look-alike", int(frames[0]), int(frames[-1]), a, b, np.nan


def shared_areas(
    cars: Tracks, boxes: Float[Array, "n 4"]
) -> Iterator[tuple[int, int, Int[Array, " k"], Int[Array, " k"], Int[Array, " k"]]]:
    """Each time that the boxes of two cars share area: both ids, the frames, the rows of both."""
    pairs = CarPairs.of(cars, boxes)
    keys = np.stack((pairs.firsts, pairs.seconds), axis=1)
    if not len(keys):
        return
    every, which = np.unique(keys, axis=0, return_inverse=True)
    for number, (a, b) in enumerate(every.tolist()):
        own = pairs.select(np.flatnonzero(which.ravel() == number))
        for span in runs_of_frames(own.frames, MAX_PAIR_GAP_FRAMES):
            part = own.select(span)
            yield a, b, part.frames, part.rows_a, part.rows_b


class CarPairs(Rows):
    """Two rows of a table each, in one frame."""

    __match_args__ = ("frames", "firsts", "seconds", "rows_a", "rows_b")

    def __init__(self, *columns: Int[Array, " n"]) -> None:
        self.frames, self.firsts, self.seconds, self.rows_a, self.rows_b = columns

    @classmethod
    def of(cls, cars: Tracks, boxes: Float[Array, "n 4"]) -> "CarPairs":
        """Of cars whose boxes share area, the lower id first; in the order of frames."""
        rows, others = same_frame_pairs(cars.frames, cars.frames)
        low = cars.ids[rows] < cars.ids[others]
        rows, others = rows[low], others[low]
        near = box_intersection(boxes[rows], boxes[others]) > 0.0
        rows, others = rows[near], others[near]
        return cls(cars.frames[rows], cars.ids[rows], cars.ids[others], rows, others)


__all__ = ["box_crossings", "look_alike_pairs"]
