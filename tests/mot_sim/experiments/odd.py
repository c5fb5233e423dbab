"""Trackers that go wrong, each in its way, and some that are only foreign."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker import Camera, Frame, Tracker, Tracks


def rows(frame: Frame, ids: object, boxes: object = None) -> Tracks:
    """Rows of a frame with these ids; unchecked."""
    ids = np.asarray(ids)
    given = np.tile([10.0, 10.0, 50.0, 40.0], (len(ids), 1)) if boxes is None else boxes
    return Tracks(np.full(len(ids), frame.index), ids, np.asarray(given), np.ones(len(ids)))


class Raises:
    """Fails in its third frame."""

    def step(self, frame: Frame) -> Tracks:
        if frame.index == 2:
            raise ZeroDivisionError("no car at all")
        return Tracks.empty()


class Leaves:
    """Ends the process that asks it."""

    def step(self, frame: Frame) -> Tracks:
        raise SystemExit(3)


class Boxes:
    """Gives every box as a car of its own, and no cuboid."""

    def step(self, frame: Frame) -> Tracks:
        return rows(frame, range(len(frame.found)), frame.found.boxes)


class GivesNaN:
    def step(self, frame: Frame) -> Tracks:
        return rows(frame, [4], [[np.nan, 0.0, 1.0, 1.0]])


class Twice:
    def step(self, frame: Frame) -> Tracks:
        return rows(frame, [7, 7])


class WrongShape:
    def step(self, frame: Frame) -> object:
        found = rows(frame, [1, 2])
        object.__setattr__(found, "boxes", np.zeros((2, 5)))
        return found


class Negative:
    def step(self, frame: Frame) -> Tracks:
        return rows(frame, [-1])


class Late:
    """Gives the rows of the frame before."""

    def step(self, frame: Frame) -> Tracks:
        found = rows(frame, [1])
        return Tracks(found.frames - 1, found.ids, found.boxes, found.scores)


class GivesNothing:
    def step(self, frame: Frame) -> None:
        return None


class NoTracker:
    """Has neither step nor update."""


class Updates:
    """The default tracker behind the interface that most libraries have."""

    def __init__(self, camera: Camera, min_score: float = 0.0) -> None:
        self.min_score, self.frame, self.next = min_score, 0, 0

    def update(self, boxes: Float[Array, "n 4"], scores: Float[Array, " n"]) -> Array:
        """Every box is somebody new."""
        kept = boxes[scores >= self.min_score]
        ids = self.next + np.arange(len(kept))
        self.next += len(kept)
        boxes[:] = np.nan  # it may do with its copy what it likes
        return np.column_stack((kept, ids))


class Later:
    """The default tracker, whose rows come a frame late; twice: and once more in the end."""

    def __init__(self, camera: Camera, twice: bool = False) -> None:
        self.inner, self.last, self.twice = Tracker.default(camera), Tracks.empty(), twice

    def step(self, frame: Frame) -> Tracks:
        before, self.last = self.last, self.inner.step(frame)
        self.given = before
        return before

    def finish(self) -> Tracks:
        return Tracks.concatenate([self.given, self.last]) if self.twice else self.last


def built(camera: Camera) -> Tracker:
    """Ours, through a callable."""
    return Tracker.default(camera)


class Pairs:
    """Answers with (ids, boxes)."""

    def update(self, boxes: Array, scores: Array) -> tuple[Array, Array]:
        return np.arange(len(boxes)), boxes
