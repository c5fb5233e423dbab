"""TrackEval's CLEAR of many drives at once, counted one frame at a time."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int
from numpy import ndarray as Array

from mot_sim.metrics.clear import CONTINUING_BONUS
from mot_sim.metrics.matching import EPSILON, Overlaps, solve_frame
from mot_sim.metrics.preprocessing import (
    MIN_OVERLAP,
    PreparedSequence,
    checked_columns,
    counted_output,
    kind_is,
    neutral_labels,
    of_class,
)
from tracker import Tracks


@dataclass(frozen=True, eq=False)
class LabelledFrames:
    """The labels of frames of drives, one after another, ready to be counted.

    The first frame stands for none and has no label.
    """

    starts: Int[Array, " _"]
    """Where the labels of each frame begin, and where the last ones end."""
    labels: Tracks
    """Frames, ids and boxes of all that takes part."""
    takes_part: Bool[Array, " n"]
    """Which rows are of the class that is scored, or like it."""
    neutral: Bool[Array, " n"]
    """Which of them need not be found."""
    is_region: Bool[Array, " n"]
    """Which are regions that are not labelled."""

    @classmethod
    def nothing(cls) -> "LabelledFrames":
        """The frame that stands for none."""
        none = np.zeros(0, bool)
        return cls(np.zeros(2, np.int64), Tracks.empty(), none, none, none)

    @classmethod
    def of(cls, truth: Tracks, frame_count: int) -> "LabelledFrames":
        """The labels of one drive, in the order of its frames."""
        truth = checked_columns(truth, "truth")
        starts = np.searchsorted(truth.frames, np.arange(frame_count + 1))
        masks = of_class(truth, "Car"), neutral_labels(truth), kind_is(truth, "DontCare", False)
        bare = Tracks(truth.frames, truth.ids, truth.boxes)
        return cls(np.concatenate(([0], starts)), bare, *masks)

    def after(self, before: "LabelledFrames") -> "LabelledFrames":
        """The frames of both as one table, these ones last."""
        masks = ("takes_part", "neutral", "is_region")
        return LabelledFrames(
            np.concatenate((before.starts, before.starts[-1] + self.starts[2:])),
            Tracks.concatenate((before.labels, self.labels)),
            *(np.concatenate((getattr(before, name), getattr(self, name))) for name in masks),
        )

    def prepared(self, at: Int[Array, " e"], output: Tracks) -> PreparedSequence:
        """One frame of every drive against its output, as a sequence of which each is a frame.

        at: rows of these frames, 0 for none. output: the drives for frames, ascending.
        """
        counts = self.starts[at + 1] - self.starts[at]
        drives, before = np.repeat(np.arange(len(at)), counts), np.cumsum(counts) - counts
        rows = np.arange(len(drives)) + np.repeat(self.starts[at] - before, counts)

        def picked(mask: Bool[Array, " n"]) -> Tracks:
            some = rows[mask[rows]]
            return Tracks(drives[mask[rows]], self.labels.ids[some], self.labels.boxes[some])

        bare = Tracks(output.frames, output.ids, output.boxes)
        overlaps = Overlaps.between(picked(self.takes_part), bare)
        mine = rows[self.takes_part[rows]]
        return PreparedSequence(overlaps, self.neutral[mine], picked(self.is_region))


class RunningClears:
    """`RunningClear` of every drive."""

    def __init__(self, count: int) -> None:
        """Nothing counted yet; count: how many drives."""
        self.CLR_TP, self.CLR_FP, self.CLR_FN, self.IDSW = np.zeros((4, count), np.int64)
        self._names: list[dict[int, int]] = [{} for _ in range(count)]
        self._before: list[frozenset[tuple[int, int]]] = [frozenset()] * count

    def reset(self, drives: Int[Array, " r"]) -> None:
        """Count these drives from nothing."""
        for counts in (self.CLR_TP, self.CLR_FP, self.CLR_FN, self.IDSW):
            counts[drives] = 0
        for drive in drives.tolist():
            self._names[drive], self._before[drive] = {}, frozenset()

    @property
    def gain(self) -> Int[Array, " e"]:
        """TP - FP - IDSW of every drive."""
        return self.CLR_TP - self.CLR_FP - self.IDSW

    def add(self, frames: LabelledFrames, at: Int[Array, " e"], output: Tracks) -> None:
        """Count a frame of every drive, see `LabelledFrames.prepared`."""
        count, contest = len(self.CLR_TP), frames.prepared(at, output)
        kept_labels, kept_output = ~contest.neutral, counted_output(contest)
        overlaps = contest.overlaps.keep(kept_labels, kept_output)
        ids = contest.overlaps.truth.ids[kept_labels]
        names = contest.overlaps.output.ids[kept_output]
        labels = np.bincount(overlaps.truth.frames, minlength=count)
        written = np.bincount(overlaps.output.frames, minlength=count)
        near = np.flatnonzero(overlaps.iou >= MIN_OVERLAP - EPSILON)
        rows, columns = overlaps.rows[near], overlaps.columns[near]
        drives = overlaps.truth.frames[rows]
        edges = np.searchsorted(drives, np.arange(count + 1)).tolist()
        is_disputed = (np.bincount(rows)[rows] > 1) | (np.bincount(columns)[columns] > 1)
        disputed = set(drives[is_disputed].tolist())
        label_of, name_of = ids[rows].tolist(), names[columns].tolist()
        found, switches = np.zeros(count, np.int64), np.zeros(count, np.int64)
        for drive in ((labels > 0) & (written > 0)).nonzero()[0].tolist():
            here = slice(edges[drive], edges[drive + 1])
            pairs = list(zip(label_of[here], name_of[here], strict=True))
            if drive in disputed:
                kept = np.array([pair in self._before[drive] for pair in pairs])
                weights = CONTINUING_BONUS * kept + overlaps.iou[near[here]]
                chosen = solve_frame(overlaps, drive, near[here], weights).tolist()
                pairs = [pair for pair, is_chosen in zip(pairs, chosen, strict=True) if is_chosen]
            self._before[drive], known = frozenset(pairs), self._names[drive]
            switches[drive] = sum(known.get(label, name) != name for label, name in pairs)
            known.update(pairs)
            found[drive] = len(pairs)
        self.CLR_TP += found
        self.CLR_FP += written - found
        self.CLR_FN += labels - found
        self.IDSW += switches
