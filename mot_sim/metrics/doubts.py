"""What makes a score meaningless although it can be computed: nothing to score, other frames."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.metrics.matching import Overlaps
from mot_sim.metrics.preprocessing import MIN_OVERLAP, kind_is, prepare_sequence
from tracker.types import Tracks, kinds_said, spelled_as_kitti

# Frames by which results are shifted to see whether they fit better there.
SHIFTS = (-3, -2, -1, 1, 2, 3)
# A shift is named when it raises the summed overlap by this part, over so many boxes.
MIN_GAIN = 1.02
MIN_BOXES = 20


def why_nothing_is_scored(tracks: Tracks, kind: str = "Car") -> str | None:
    """What rows hold when none is of that class with an id; None when some are, or no row is."""
    if not len(tracks):
        return None
    scored = kind_is(tracks, kind, True)
    if not scored.any():
        kinds = spelled_as_kitti(np.asarray(tracks.kinds))
        return f"hold {kinds_said(kinds)}, and no {kind}, which alone is scored"
    if not (scored & (tracks.ids >= 0)).any():
        return (
            f"have ids below 0 in all rows of {kind}; such rows name no object and are not scored"
        )
    return None


def doubts_of(truth: Tracks, output: Tracks, frame_count: int, kind: str = "Car") -> list[str]:
    """Sentences about what is likely wrong with these results; none for sound ones.

    Rows of which none is scored are not among them: `evaluate` says so itself. Raises as
    `prepare_sequence`.
    """
    empty = [what for what, rows in (("labels", truth), ("results", output)) if not len(rows)]
    if empty or why_nothing_is_scored(truth, kind) or why_nothing_is_scored(output, kind):
        return [f"the {what} hold no row" for what in empty]
    overlaps = prepare_sequence(truth, output, frame_count, kind).overlaps
    best = {shift: _fit(overlaps, shift) for shift in (0, *SHIFTS)}
    shift = max(best, key=lambda moved: (best[moved].sum(), -abs(moved)))
    hits = int((best[shift] >= MIN_OVERLAP).sum())
    if shift and hits >= MIN_BOXES and best[shift].sum() > MIN_GAIN * best[0].sum():
        frames = f"{abs(shift)} frame{'s' if abs(shift) > 1 else ''}"
        way = "earlier" if shift < 0 else "later"
        return [
            f"the results fit the labels better {frames} {way} (overlap summed over the boxes "
            f"{best[shift].sum():.0f} instead of {best[0].sum():.0f}): frames count from 0"
        ]
    if not (best[0] >= MIN_OVERLAP).any():
        return [
            f"none of {len(overlaps.output)} boxes meets a label with half its area: are they of "
            "this drive, and x_min y_min x_max y_max in pixels of the full image?"
        ]
    return []


def _fit(overlaps: Overlaps, shift: int) -> Float[Array, " m"]:
    """For each box of the output, moved by so many frames, its largest overlap with a label."""
    moved = overlaps.output.replaced(frames=overlaps.output.frames + shift)
    there = Overlaps.between(overlaps.truth, moved) if shift else overlaps
    best = np.zeros(len(moved))
    np.maximum.at(best, there.columns, there.iou)
    return best
