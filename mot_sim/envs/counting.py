"""CLEAR counted frame by frame: the same counts that the whole sequence would give so far."""

from dataclasses import dataclass, field

import numpy as np

from mot_sim.metrics.clear import CONTINUING_BONUS
from mot_sim.metrics.matching import EPSILON, Overlaps, solve_frame
from mot_sim.metrics.preprocessing import MIN_OVERLAP, counted_output, prepare_sequence
from tracker.types import Tracks


@dataclass(frozen=True)
class RunningCounts:
    """Matches, false positives, misses and id switches, under TrackEval's names."""

    CLR_TP: int = 0
    CLR_FP: int = 0
    CLR_FN: int = 0
    IDSW: int = 0

    def __add__(self, other: "RunningCounts") -> "RunningCounts":
        return RunningCounts(
            self.CLR_TP + other.CLR_TP, self.CLR_FP + other.CLR_FP,
            self.CLR_FN + other.CLR_FN, self.IDSW + other.IDSW,
        )  # fmt: skip

    @property
    def gain(self) -> int:
        """What MOTA is the share of: TP - FP - IDSW."""
        return self.CLR_TP - self.CLR_FP - self.IDSW

    @property
    def MOTA(self) -> float:
        """1 less the misses, false positives and id switches per label; of no labels as of one."""
        return self.gain / max(1, self.CLR_TP + self.CLR_FN)


@dataclass(eq=False)
class RunningClear:
    """TrackEval's CLEAR of KITTI's cars, a frame at a time; `total` is what counts so far.

    It remembers the last name of every label, and the matches of the last frame that held
    labels and output, which are kept where they can be; see `mot_sim.metrics`.
    """

    total: RunningCounts = field(default_factory=RunningCounts)
    names: dict[int, int] = field(default_factory=dict)
    before: frozenset[tuple[int, int]] = frozenset()

    def add(self, labels: Tracks, output: Tracks, frame: int) -> RunningCounts:
        """Count the rows of one frame. Raises BadTracks for rows that cannot be scored."""
        contest = prepare_sequence(labels, output, frame + 1)
        kept_labels, kept_output = ~contest.neutral, counted_output(contest)
        overlaps = contest.overlaps.keep(kept_labels, kept_output)
        ids = contest.overlaps.truth.ids[kept_labels].tolist()
        names = contest.overlaps.output.ids[kept_output].tolist()
        pairs = self._match(overlaps, ids, names, frame)
        if ids and names:
            self.before = frozenset(pairs)
        switches = sum(self.names.get(label, name) != name for label, name in pairs)
        self.names.update(pairs)
        found = len(pairs)
        counts = RunningCounts(found, len(names) - found, len(ids) - found, switches)
        self.total = self.total + counts
        return counts

    def _match(
        self, overlaps: Overlaps, ids: list[int], names: list[int], frame: int
    ) -> list[tuple[int, int]]:
        """The matched labels and names: first those that keep a name, then the most overlap."""
        near = np.flatnonzero(overlaps.iou >= MIN_OVERLAP - EPSILON)
        rows, columns = overlaps.rows[near].tolist(), overlaps.columns[near].tolist()
        pairs = [(ids[row], names[column]) for row, column in zip(rows, columns, strict=True)]
        if len(set(rows)) == len(rows) and len(set(columns)) == len(columns):
            return pairs
        kept = np.array([pair in self.before for pair in pairs])
        weights = CONTINUING_BONUS * kept + overlaps.iou[near]
        chosen = solve_frame(overlaps, frame, near, weights)
        return [pair for pair, is_chosen in zip(pairs, chosen.tolist(), strict=True) if is_chosen]


def counted_labels(labels: Tracks, frame_count: int) -> int:
    """How many boxes of the labels must be found."""
    return int((~prepare_sequence(labels, Tracks.empty(), frame_count).neutral).sum())
