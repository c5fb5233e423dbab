"""What an action of the association environment means: slots of tracks, matches, masks."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.association import Match

EMPTY_SLOT = -1  # the id in a slot without a track


@dataclass(frozen=True, eq=False)
class Slots:
    """Which track is in which slot; a track keeps its slot."""

    ids: Int[Array, " s"]
    """Id of the track in every slot; EMPTY_SLOT where there is none."""

    @classmethod
    def empty(cls, count: int) -> "Slots":
        """No track in any slot."""
        return cls(np.full(count, EMPTY_SLOT))

    @property
    def taken(self) -> Bool[Array, " s"]:
        """Which slots hold a track."""
        return self.ids != EMPTY_SLOT

    def of(self, ids: Int[Array, " n"]) -> Int[Array, " n"]:
        """The slots of tracks that have one."""
        order = np.argsort(self.ids, kind="stable")
        return order[np.searchsorted(self.ids[order], ids)]

    def after(self, living: Int[Array, " n"]) -> "Slots":
        """The slots once only these tracks live; those without one take the lowest free ones."""
        ids = np.where(np.isin(self.ids, living), self.ids, EMPTY_SLOT)
        new = living[~np.isin(living, ids)]
        ids[np.flatnonzero(ids == EMPTY_SLOT)[: len(new)]] = new
        return Slots(ids)


@dataclass(frozen=True, eq=False)
class Decision:
    """What became of the detections of a frame."""

    match: Match
    """Pairs of rows and detections, and the detections that began tracks."""
    refused: Bool[Array, " m"]
    """Which detections could not be placed as the action said."""
    born_ids: Int[Array, " b"]
    """Ids of the new tracks, in the order of the match's unmatched detections."""


def decide(
    action: Int[Array, " m"], costs: Float[Array, "n m"], slots: Int[Array, " n"], slot_count: int
) -> tuple[Match, Bool[Array, " m"]]:
    """The match that an action stands for, and which detections it could not place.

    action: for each detection a slot, slot_count for a new track, slot_count + 1 for none.
    costs: of the tracks, whose slots are given, with the detections; inf = impossible.
    """
    rows_of = np.full(slot_count + 2, EMPTY_SLOT)
    rows_of[slots] = np.arange(len(slots))
    best: dict[int, int] = {}
    refused = np.zeros(len(action), bool)
    for column in np.flatnonzero(action < slot_count).tolist():
        row = int(rows_of[action[column]])
        if row == EMPTY_SLOT or not np.isfinite(costs[row, column]):
            refused[column] = True
        elif row not in best:
            best[row] = column
        else:
            kept = min(best[row], column, key=costs[row].__getitem__)
            refused[[best[row], column]] = True
            refused[kept], best[row] = False, kept
    new = np.flatnonzero(action == slot_count)
    free = slot_count - len(slots)
    refused[new[free:]] = True
    pairs = np.array(sorted(best.items()), np.int64).reshape(-1, 2)
    lost = np.setdiff1d(np.arange(len(slots)), pairs[:, 0])
    return Match(pairs, lost, new[:free]), refused


def mask_of(
    possible: Bool[Array, "t d"], tracks: Bool[Array, " t"], detections: Bool[Array, " d"]
) -> Bool[Array, "d c"]:
    """The choices of every detection that are not refused for its own sake; c is t + 2.

    A track may be chosen where the pair is possible, a new track where a slot is free, rejection
    always; rows without a detection can only be rejected. Two detections may still choose the
    same track, or more new ones than slots are free.
    """
    slot_count, count = possible.shape
    mask = np.zeros((count, slot_count + 2), bool)
    mask[:, :slot_count] = possible.T & detections[:, None]
    mask[:, slot_count] = detections & (not tracks.all())
    mask[:, slot_count + 1] = True
    return mask
