"""What the detections of a frame of every drive cost against its tracks, and who matches."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

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
    """Rows of `tracks` and of `detections` that were compared, in that order."""
    costs: Float[Array, " k"]
    """What each pair costs; all others are impossible, as those with inf are."""
    motions: FrameMotions
    """Of the cameras, one row per drive."""
    roads: DriveRoads
    """What is known of the road of each drive before the detections."""

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
    """A track and a detection of its drive, in the order of tracks."""
    unmatched_tracks: Int[Array, " l"]
    """The other tracks, ascending."""
    unmatched_detections: Int[Array, " b"]
    """The detections that begin tracks where their score is high enough, ascending."""
