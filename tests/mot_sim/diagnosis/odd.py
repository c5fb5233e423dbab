"""Trackers that break where they are told to."""

import numpy as np

from tracker import Camera, Frame, Tracker, Tracks


class NewNameAtTen:
    """The default tracker, but every car has another name from frame 10 on."""

    def __init__(self, camera: Camera) -> None:
        self.inner = Tracker.default(camera)

    def step(self, frame: Frame) -> Tracks:
        """The rows of this frame."""
        rows = self.inner.step(frame)
        more = 1000 if frame.index >= 10 else 0
        return Tracks(rows.frames, rows.ids + np.int64(more), rows.boxes, rows.scores)


class FailsAtFive:
    """It gives nothing until it raises."""

    def step(self, frame: Frame) -> Tracks:
        """Nothing."""
        if frame.index == 5:
            raise ValueError("five is too many")
        return Tracks.empty()
