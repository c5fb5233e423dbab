"""Costs of all pairs of neighbouring frames, computed once: a two-frame tracker by any weights.

With `ConstantPosition`, births from any score and no memory (`Tracker.paper`), what is expected in
a frame are the detections of the frame before, whatever was matched with what. So every cost of
every pair is known before any weight is chosen, and a weight vector costs an assignment a frame.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker import Sequence, Tracker, Tracks
from tracker.association import Match
from tracker.costs import Cost, GatedPairs
from tracker.errors import BadConfig


@dataclass(frozen=True)
class Checked:
    """A cost under its name. Raises BadConfig for a value that is infinite or below 0."""

    name: str
    """The cost's name, for the message of the error."""
    cost: Cost
    """The cost that is checked."""

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        """The cost of every pair; NaN where its cue is missing."""
        values = self.cost(pairing)
        bad = np.isinf(values) | (values < 0.0)
        if np.count_nonzero(bad):
            raise BadConfig(
                f"the cost '{self.name}' gave {values[bad][0]:g}: a cost is a finite number, 0 or "
                "more (NaN where its cue is missing); mend it, or leave it out"
            )
        return values


@dataclass
class _Recorder:
    """A cost that keeps what the named costs say, and costs nothing."""

    costs: tuple[Cost, ...]
    kept: list[tuple[Array, Array, Array, Array]] = field(default_factory=list)

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        rows, columns = pairing.pairs
        values = np.array([cost(pairing) for cost in self.costs])
        self.kept.append((rows, columns, values, pairing.image_distance))
        return np.zeros(len(rows))


def _nobody(costs: Float[Array, "n m"]) -> Match:
    """No pair at all: every detection begins a track."""
    return Match.of(np.zeros((0, 2), np.int64), *costs.shape)


@dataclass(frozen=True, eq=False)
class Step:
    """One frame of a drive, and which pairs with the frame before belong to it."""

    index: int
    """Index of the frame."""
    count: int
    """Number of detections in the frame."""
    first: int
    """Place of its first pair among all pairs of the drive."""
    end: int
    """Place after its last pair."""


@dataclass(frozen=True, eq=False)
class PairCosts:
    """The costs of all pairs of neighbouring frames of a drive."""

    tracker: Tracker
    """The two-frame tracker, which gives the association and the tie-break."""
    steps: tuple[Step, ...]
    """The frames in the order of time."""
    rows: Int[Array, " k"]
    """Per pair, the row of its detection in the frame before."""
    columns: Int[Array, " k"]
    """Per pair, the row of its detection in the frame itself."""
    values: Float[Array, "c k"]
    """A row per cost, a column per pair; no NaN."""
    distance: Float[Array, " k"]
    """Per pair, how far apart the centres of the boxes are: d / (d + diagonal), in [0, 1)."""
    boxes: Float[Array, "n 4"]
    """Boxes of all detections that survive suppression, frame by frame: x_min, y_min, x_max, y_max
    in px."""

    @classmethod
    def of(cls, tracker: Tracker, sequence: Sequence) -> "PairCosts | None":
        """The pairs of a drive under the tracker's own costs; None where matches decide beliefs.

        That is so for a tracker with memory or a filter, and where a cue is missing in some
        rows: a track then carries what was measured before.
        """
        if not _is_two_frame(tracker):
            return None
        recorder = _Recorder(tuple(cost for _, cost in tracker.costs))
        alone = replace(tracker, costs=((1.0, recorder),), associate=_nobody)
        steps, boxes, end = [], [np.zeros((0, 4))], 0
        for frame in sequence:
            before = len(recorder.kept)
            born = alone.step(frame)
            first, end = end, end + sum(len(each[0]) for each in recorder.kept[before:])
            steps.append(Step(frame.index, len(born), first, end))
            boxes.append(born.boxes)
        values = np.concatenate(
            [np.zeros((len(tracker.costs), 0)), *(each[2] for each in recorder.kept)], axis=1
        )
        # A cost that is not measured may be one that a track would have carried along.
        if np.isnan(values).any():
            return None
        none = np.zeros(0, np.int64)
        rows = np.concatenate([none, *(each[0] for each in recorder.kept)])
        columns = np.concatenate([none, *(each[1] for each in recorder.kept)])
        distance = np.concatenate([np.zeros(0), *(each[3] for each in recorder.kept)])
        return cls(tracker, tuple(steps), rows, columns, values, distance, np.concatenate(boxes))

    def track(self, weights: tuple[float, ...]) -> Tracks:
        """The tracks by these weights: those of the tracker itself, rows as detected."""
        shares = np.array(weights)[:, None] / sum(weights)
        total = (shares * self.values).sum(axis=0) + self.tracker.tie_break * self.distance
        ids, order, next_id = np.zeros(0, np.int64), np.zeros(0, np.int64), 0
        frames, names = [], []
        for step in self.steps:
            pairs = slice(step.first, step.end)
            place = np.empty_like(order)
            place[order] = np.arange(len(order))
            matrix = np.full((len(order), step.count), np.inf)
            matrix[place[self.rows[pairs]], self.columns[pairs]] = total[pairs]
            match = self.tracker.associate(matrix)
            taken, seen = match.pairs.T
            now = np.empty(step.count, np.int64)
            now[seen] = ids[order[taken]]
            now[match.unmatched_detections] = next_id + np.arange(len(match.unmatched_detections))
            next_id += len(match.unmatched_detections)
            ids, order = now, np.concatenate((seen, match.unmatched_detections))
            frames.append(np.full(step.count, step.index))
            names.append(now)
        none = np.zeros(0, np.int64)
        return Tracks(np.concatenate([none, *frames]), np.concatenate([none, *names]), self.boxes)


def _is_two_frame(tracker: Tracker) -> bool:
    """Whether everybody dies at the first miss, is born at first sight, and is taken as seen."""
    return (
        type(tracker.dynamics) is type(Tracker.paper(tracker.camera).dynamics)
        and tracker.lifecycle.max_gap == 0.0
        and tracker.lifecycle.birth_score <= 0.0
        and tracker.strong_score <= 0.0
        and tracker.existence is None
        and tracker.box_filter is None
    )
