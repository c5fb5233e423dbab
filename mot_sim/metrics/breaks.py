"""Where a car loses its name or its box for a while: CLEAR's switches and fragments, one by one."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.clear import match_in_time
from mot_sim.metrics.preprocessing import counted_output, prepare_sequence, scored_rows
from tracker.types import Rows, Tracks


@dataclass(frozen=True, eq=False)
class Matches(Rows):
    """CLEAR's matched pairs, by car, then by frame.

    cars, track_ids: ids of the labels and of the output. steps: which of the frames that hold labels
    and output it is, counted from 0: neighbours in this count are no fragment.
    """

    frames: Int[Array, " n"]
    cars: Int[Array, " n"]
    track_ids: Int[Array, " n"]
    steps: Int[Array, " n"]

    @classmethod
    def of(cls, truth: Tracks, output: Tracks, frame_count: int) -> "Matches":
        """By TrackEval's rules, as `mot_sim.metrics` scores them. Raises as its `prepare_sequence`."""
        contest = prepare_sequence(truth, output, frame_count)
        overlaps = scored_rows(contest)
        if not len(overlaps.truth) or not len(overlaps.output):
            return cls(*(np.zeros(0, np.int64) for _ in range(4)))
        cars = contest.overlaps.truth.ids[~contest.neutral]
        names = contest.overlaps.output.ids[counted_output(contest)]
        busy = np.intersect1d(overlaps.truth.frames, overlaps.output.frames)
        pairs = match_in_time(overlaps, busy)
        frames = overlaps.frames[pairs]
        found = cls(
            frames, cars[overlaps.rows[pairs]], names[overlaps.columns[pairs]],
            np.searchsorted(busy, frames),
        )  # fmt: skip
        return found.select(np.lexsort((found.frames, found.cars)))

    def of_car(self, car: int) -> "Matches":
        """Those of one car."""
        first, last = np.searchsorted(self.cars, [car, car + 1])
        return self.select(slice(int(first), int(last)))


@dataclass(frozen=True, eq=False)
class Breaks(Rows):
    """A row each time a car is matched anew, by frame, then by car.

    before, frames: the last frame under the old name and the first under the new one. cars: the
    labels' ids. old_track_ids, track_ids: of the output. switched: it counts in IDSW; broken: in Frag; a
    row has one of both at least. weight: frames that the car was matched for since its last
    switch or until its next, whichever are fewer: how much of its identity is torn off.
    """

    before: Int[Array, " n"]
    frames: Int[Array, " n"]
    cars: Int[Array, " n"]
    old_track_ids: Int[Array, " n"]
    track_ids: Int[Array, " n"]
    switched: Bool[Array, " n"]
    broken: Bool[Array, " n"]
    weight: Int[Array, " n"]

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
            a.frames[rows], b.frames[rows], b.cars[rows], a.track_ids[rows], b.track_ids[rows],
            switched[rows], broken[rows], np.minimum(runs[rows], runs[rows + 1]),
        )  # fmt: skip
        return found.select(np.lexsort((found.cars, found.frames)))

    @property
    def switches(self) -> "Breaks":
        """Only the switches."""
        return self.select(self.switched)


def _run_lengths(
    switched: Bool[Array, " m"], same: Bool[Array, " m"], count: int
) -> Int[Array, " n"]:
    """How many matches in a row have the name of each one."""
    if not count:
        return np.zeros(0, np.int64)
    run = np.concatenate(([0], np.cumsum(switched | ~same)))
    return np.bincount(run)[run]


def counted_cars(truth: Tracks, frame_count: int) -> Tracks:
    """The labels that a tracker is scored on: cars that are neither neutral nor DontCare."""
    contest = prepare_sequence(truth, Tracks.empty(), frame_count)
    return contest.overlaps.truth.select(~contest.neutral)


def box_of(tracks: Tracks, car: int, frame: int) -> Float[Array, "4"] | None:
    """The box of an id in a frame; None where it has none."""
    rows = np.flatnonzero((tracks.ids == car) & (tracks.frames == frame))
    return tracks.boxes[rows[0]] if len(rows) else None


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
