"""CLEAR row by row: each switch and fragment, and whether labels and boxes are right or wrong."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.clear import match_in_time
from mot_sim.metrics.preprocessing import counted_output, prepare_sequence, scored_rows
from tracker.types import Rows, Tracks


@dataclass(frozen=True, eq=False)
class Matches(Rows):
    """CLEAR's matched pairs, by car, then by frame."""

    frames: Int[Array, " n"]
    """Frame of each pair, counted from 0."""
    cars: Int[Array, " n"]
    """Ids of the labels."""
    track_ids: Int[Array, " n"]
    """Ids of the output."""
    steps: Int[Array, " n"]
    """Number of the frame among those with labels and output; between neighbours in this count
    there is no fragment."""

    @classmethod
    def of(cls, truth: Tracks, output: Tracks, frame_count: int, kind: str = "Car") -> "Matches":
        """By TrackEval's rules, see `scored_rows`. Raises as `prepare_sequence`."""
        prepared = prepare_sequence(truth, output, frame_count, kind)
        overlaps = scored_rows(prepared)
        if not len(overlaps.truth) or not len(overlaps.output):
            return cls(*(np.zeros(0, np.int64) for _ in range(4)))
        cars = prepared.overlaps.truth.ids[~prepared.neutral]
        track_ids = prepared.overlaps.output.ids[counted_output(prepared)]
        busy = np.intersect1d(overlaps.truth.frames, overlaps.output.frames)
        pairs = match_in_time(overlaps, busy)
        frames = overlaps.frames[pairs]
        steps = np.searchsorted(busy, frames)
        found = cls(frames, cars[overlaps.rows[pairs]], track_ids[overlaps.columns[pairs]], steps)
        return found.select(np.lexsort((found.frames, found.cars)))

    def of_car(self, car: int) -> "Matches":
        """Those of one car."""
        first, last = np.searchsorted(self.cars, [car, car + 1])
        return self.select(slice(int(first), int(last)))


@dataclass(frozen=True, eq=False)
class Breaks(Rows):
    """One row per switch or fragment of a car, by frame, then by car."""

    before: Int[Array, " n"]
    """Last matched frame before it."""
    frames: Int[Array, " n"]
    """First matched frame after it."""
    cars: Int[Array, " n"]
    """Ids of the labels."""
    old_track_ids: Int[Array, " n"]
    """Id of the output before it."""
    track_ids: Int[Array, " n"]
    """Id of the output after it."""
    switched: Bool[Array, " n"]
    """Whether it counts in IDSW; each row is switched, broken or both."""
    broken: Bool[Array, " n"]
    """Whether it counts in Frag."""
    weight: Int[Array, " n"]
    """Matched frames since the car's last switch or until its next one, whichever are fewer: how
    much of its identity is torn off."""

    @classmethod
    def of(cls, matches: Matches) -> "Breaks":
        """The switches and fragments of some matches."""
        a, b = matches.select(slice(0, -1)), matches.select(slice(1, None))
        same = a.cars == b.cars
        switched = same & (a.track_ids != b.track_ids)
        broken = same & (b.steps > a.steps + 1)
        rows = np.flatnonzero(switched | broken)
        runs = _run_lengths(switched, same, len(matches))
        found = cls(
            a.frames[rows],
            b.frames[rows],
            b.cars[rows],
            a.track_ids[rows],
            b.track_ids[rows],
            switched[rows],
            broken[rows],
            np.minimum(runs[rows], runs[rows + 1]),
        )
        return found.select(np.lexsort((found.cars, found.frames)))

    @property
    def switches(self) -> "Breaks":
        """Only the switches."""
        return self.select(self.switched)


def _run_lengths(
    switched: Bool[Array, " m"], same: Bool[Array, " m"], count: int
) -> Int[Array, " n"]:
    """For each match, how many in a row have its track id."""
    if not count:
        return np.zeros(0, np.int64)
    run = np.concatenate(([0], np.cumsum(switched | ~same)))
    return np.bincount(run)[run]


def counted_cars(truth: Tracks, frame_count: int) -> Tracks:
    """The labels that a tracker is scored on: cars that are neither neutral nor DontCare."""
    prepared = prepare_sequence(truth, Tracks.empty(), frame_count)
    return prepared.overlaps.truth.select(~prepared.neutral)


def box_of(tracks: Tracks, car: int, frame: int) -> Float[Array, "4"] | None:
    """The box of an id in a frame; None where it has none."""
    rows = np.flatnonzero((tracks.ids == car) & (tracks.frames == frame))
    return tracks.boxes[rows[0]] if len(rows) else None


@dataclass(frozen=True, eq=False)
class Verdicts:
    """Which labels and tracks of a drive TrackEval's rules count as what.

    All in the order of frames; ids and boxes are those of the given tables.
    """

    found: Tracks
    """Labels that must be found, and are."""
    missed: Tracks
    """Labels that must be found, and are not."""
    neutral: Tracks
    """Labels that need not be found: vans, strongly hidden or truncated cars."""
    false: Tracks
    """Rows of the output that are false positives."""
    switches: Breaks
    """The id switches."""

    @classmethod
    def of(cls, truth: Tracks, output: Tracks, frame_count: int, kind: str = "Car") -> "Verdicts":
        """kind: the class that is judged. Raises BadTracks for rows that cannot be scored."""
        prepared = prepare_sequence(truth, output, frame_count, kind)
        matches = Matches.of(truth, output, frame_count, kind)
        labels, rows = prepared.overlaps.truth, prepared.overlaps.output
        hit = _among(labels, matches.frames, matches.cars)
        right = _among(rows, matches.frames, matches.track_ids)
        return cls(
            labels.select(hit & ~prepared.neutral),
            labels.select(~hit & ~prepared.neutral),
            labels.select(prepared.neutral),
            rows.select(counted_output(prepared) & ~right),
            Breaks.of(matches).switches,
        )


def _among(tracks: Tracks, frames: Int[Array, " k"], ids: Int[Array, " k"]) -> Bool[Array, " n"]:
    """Which rows stand in a list of (frame, id)."""
    listed = set(zip(frames.tolist(), ids.tolist(), strict=True))
    rows = zip(tracks.frames.tolist(), tracks.ids.tolist(), strict=True)
    return np.array([row in listed for row in rows], bool)
