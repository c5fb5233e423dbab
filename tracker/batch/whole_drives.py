"""Whole drives, followed side by side: the rows that one tracker per drive gives, bit for bit."""

from collections.abc import Sequence

import numpy as np
from numpy import ndarray as Array

from tracker.batch.batch_tracker import BatchTracker
from tracker.batch.prepared_frames import PreparedFrames
from tracker.costs import ImageOverlap, Reprojection, Volume
from tracker.tracker import Tracker
from tracker.types import Tracks

# What costs of these kinds give for a pair is the same however many pairs are asked for at once.
COSTS_OF_EACH = (ImageOverlap, Reprojection, Volume)
# The parts of a tracker that the batch computes for all drives at once.
PARTS = (
    "lift", "dynamics", "suppress", "associate", "lifecycle", "score_scale", "existence",
    "box_filter", "camera_rotation_filter", "car_filter", "gap_rows",
)  # fmt: skip
OURS = "tracker."  # how the modules of our parts are called


def follows_together(tracker: object) -> bool:
    """Whether `track_drives` gives what this tracker does: a `Tracker` of our parts, with
    geometric costs.

    Parts of the user's own would not be asked; costs of theirs, and those that read cues, may hang
    on which pairs they are asked for.
    """
    if type(tracker) is not Tracker or tracker.explain:
        return False
    parts = [getattr(tracker, name) for name in PARTS]
    is_ours = all(part is None or type(part).__module__.startswith(OURS) for part in parts)
    return is_ours and all(type(cost) in COSTS_OF_EACH for _, cost in tracker.costs)


def track_drives(
    tracker: Tracker, drives: Sequence[PreparedFrames], numbers: Sequence[Sequence[int]]
) -> list[Tracks]:
    """What the tracker puts out for each of one or more drives, alone in its world: without
    cuboids.

    drives: each prepared for this tracker. numbers: the number of each of their frames.
    """
    together, first = drives[0], [1]
    for frames in drives[1:]:
        first.append(len(together))
        together = frames.after(together)
    starts, lengths = np.array(first), np.array([len(frames) - 1 for frames in drives])
    batch, parts, steps = BatchTracker(tracker, len(drives)), [Tracks.empty()], []
    for step in range(int(lengths.max())):
        if step:
            batch.reset(np.flatnonzero(lengths == step))
        compared = batch.compare(together, np.where(step < lengths, starts + step, 0))
        parts.append(batch.apply_match(compared, compared.match_each(tracker)).output)
        steps.append(len(parts[-1]))
    rows = Tracks.concatenate(parts)
    at = np.repeat(np.arange(len(steps)), steps)
    return [
        _of_drive(rows, at, np.flatnonzero(rows.frames == drive), np.array(mine, np.int64))
        for drive, mine in enumerate(numbers)
    ]


def _of_drive(rows: Tracks, at: Array, which: Array, numbers: Array) -> Tracks:
    """Some rows, with the numbers of their drive's frames."""
    own = rows.select(which)
    return Tracks(numbers[at[which]], own.ids, own.boxes, own.scores)


__all__ = ["follows_together", "track_drives"]
