"""What the truth says of tracks, row by row: found, missed, neutral, false, named anew."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int
from numpy import ndarray as Array

from mot_sim.metrics.breaks import Breaks, Matches
from mot_sim.metrics.preprocessing import counted_output, prepare_sequence
from tracker.types import Tracks


@dataclass(frozen=True, eq=False)
class Verdicts:
    """The labels and the tracks of a drive by TrackEval's rules, as `mot_sim.metrics` counts them.

    found, missed: labels that must be found. neutral: labels that need not be (vans, strongly
    hidden or cut cars). false: rows of tracks that are false positives. switches: a row each.
    All in the order of frames; ids and boxes are those of the given tables.
    """

    found: Tracks
    missed: Tracks
    neutral: Tracks
    false: Tracks
    switches: Breaks

    @classmethod
    def of(cls, truth: Tracks, output: Tracks, frame_count: int) -> "Verdicts":
        """Raises BadTracks for rows that cannot be scored."""
        contest = prepare_sequence(truth, output, frame_count)
        matches = Matches.of(truth, output, frame_count)
        labels, rows = contest.overlaps.truth, contest.overlaps.output
        hit = _among(labels, matches.frames, matches.cars)
        right = _among(rows, matches.frames, matches.track_ids)
        return cls(
            labels.select(hit & ~contest.neutral),
            labels.select(~hit & ~contest.neutral),
            labels.select(contest.neutral),
            rows.select(counted_output(contest) & ~right),
            Breaks.of(matches).switches,
        )


def _among(tracks: Tracks, frames: Int[Array, " k"], ids: Int[Array, " k"]) -> Bool[Array, " n"]:
    """Which rows stand in a list of (frame, id)."""
    listed = set(zip(frames.tolist(), ids.tolist(), strict=True))
    rows = zip(tracks.frames.tolist(), tracks.ids.tolist(), strict=True)
    return np.array([row in listed for row in rows], bool)
