"""What the detections of a frame of every drive cost against its tracks, and who matches."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.association import match_in_stages
from tracker.batch.drive_memories import DriveRoads
from tracker.batch.prepared_frames import FrameMotions
from tracker.beliefs import Beliefs
from tracker.costs import GatedPairs
from tracker.lifecycle import ActiveTracks
from tracker.tracker import Tracker
from tracker.types import Detections


class DrivePairs(GatedPairs):
    """`GatedPairs` of many drives: only tracks and detections of one drive meet."""

    def __init__(
        self,
        one: Tracker,
        tracks: tuple[Beliefs, Int[Array, " _"]],
        found: tuple[Beliefs, Detections, Int[Array, " _"]],
        seconds: float,
    ) -> None:
        (expected, starts), (observed, detections, column_starts) = tracks, found
        self.__dict__.update(
            expected=expected,
            observed=observed,
            detections=detections,
            camera=one.camera,
            sigmas=one.sigmas,
            seconds=seconds,
        )
        self.__dict__.update(self.gated(starts, column_starts))

    def of(self, chosen: Bool[Array, " k"], seconds: float) -> "DrivePairs":
        """Some of the pairs, of drives whose last frame was so many seconds before."""
        part = object.__new__(DrivePairs)
        part.__dict__.update(self.__dict__)
        rows, columns = self.pairs
        object.__setattr__(part, "pairs", (rows[chosen], columns[chosen]))
        object.__setattr__(part, "seconds", seconds)
        return part


@dataclass(frozen=True, eq=False)
class BatchCosts:
    """What the detections of a frame of every drive cost against its tracks."""

    tracks: ActiveTracks
    """The tracks of all drives as predicted, without cars."""
    starts: Int[Array, " _"]
    """Where those of each drive begin, and the last ones end."""
    detections: Detections
    """The detections of all drives."""
    observed: Beliefs
    """The same, lifted to the road."""
    columns: Int[Array, " _"]
    """Where those of each drive begin, and the last ones end."""
    pairs: tuple[Int[Array, " k"], Int[Array, " k"]]
    """Rows of `tracks`, ascending, and of `detections` that were compared."""
    costs: Float[Array, " k"]
    """What each pair costs; all others are impossible, as those with inf are."""
    motions: FrameMotions
    """Of the cameras, one row per drive."""
    roads: DriveRoads
    """What is known of the road of each drive before the detections."""

    def matrices(self) -> Iterator[Float[Array, "n m"]]:
        """The costs of each drive, as `CostMatrix` has them."""
        (rows, columns), costs = self.pairs, self.costs
        bounds = rows.searchsorted(self.starts).tolist()
        sizes = zip(self.starts.tolist(), self.columns.tolist(), bounds, strict=True)
        for (top, left, first), (bottom, right, last) in pairwise(sizes):
            matrix = np.full((bottom - top, right - left), np.inf)
            if last > first:
                mine = slice(first, last)
                matrix[rows[mine] - top, columns[mine] - left] = costs[mine]
            yield matrix

    def match_each(self, one: Tracker) -> "BatchMatch":
        """The match that a tracker alone with each drive makes."""
        strong = self.detections.scores >= one.strong_score
        pairs, lost, new = [], [], []
        for drive, matrix in enumerate(self.matrices()):
            top, left = self.starts[drive], self.columns[drive]
            columns = strong[left : self.columns[drive + 1]]
            match = match_in_stages(matrix, columns, one.associate)
            pairs.append(match.pairs + (top, left))
            lost.append(match.unmatched_tracks + top)
            new.append(match.unmatched_detections + left)
        return BatchMatch(np.concatenate(pairs), np.concatenate(lost), np.concatenate(new))

    @cached_property
    def track_drives(self) -> Int[Array, " n"]:
        """The drive of each track."""
        return np.repeat(np.arange(len(self.starts) - 1), np.diff(self.starts))

    @cached_property
    def detection_drives(self) -> Int[Array, " m"]:
        """The drive of each detection."""
        return np.repeat(np.arange(len(self.columns) - 1), np.diff(self.columns))


@dataclass(frozen=True, eq=False)
class BatchMatch:
    """Which detections are of which tracks, in all drives; rows and columns of `BatchCosts`."""

    pairs: Int[Array, "p 2"]
    """A track and a detection of its drive, drive by drive. Sums over matched tracks keep the order
    within a drive, and so do the tracks of drives where all were matched."""
    unmatched_tracks: Int[Array, " l"]
    """The other tracks, ascending."""
    unmatched_detections: Int[Array, " b"]
    """The detections that begin tracks where their score is high enough, ascending."""

    def order_after(self, drives: Int[Array, " n"]) -> Int[Array, " n"]:
        """In which order the tracks of these drives stand after it: the old one, or in drives
        where all were matched that of the pairs."""
        order, rows = np.arange(len(drives)), self.pairs[:, 0]
        is_whole = np.ones(drives.max(initial=0) + 1, bool)
        is_whole[drives[self.unmatched_tracks]] = False
        order[is_whole[drives]] = rows[is_whole[drives[rows]]]
        return order
