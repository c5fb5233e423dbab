"""Which row of an action's table a track has, and what an action says of the detections."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.association import Match

EMPTY_SLOT = -1


@dataclass(frozen=True, eq=False)
class Slots:
    """The id of the track in every slot, EMPTY where there is none. A track keeps its slot."""

    ids: Int[Array, " s"]

    @classmethod
    def empty(cls, count: int) -> "Slots":
        """Nobody in any slot."""
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


def decide(
    action: Int[Array, " m"], costs: Float[Array, "n m"], slots: Int[Array, " n"], slot_count: int
) -> tuple[Match, int]:
    """The match that an action means, and how many detections it could not place.

    action: for each detection a slot, slot_count for a new track, slot_count + 1 for none.
    costs: of the tracks, whose slots are given, with the detections; inf = impossible.
    """
    rows_of = np.full(slot_count + 2, EMPTY_SLOT)
    rows_of[slots] = np.arange(len(slots))
    best: dict[int, int] = {}
    refused = 0
    for column in np.flatnonzero(action < slot_count).tolist():
        row = int(rows_of[action[column]])
        if row == EMPTY_SLOT or not np.isfinite(costs[row, column]):
            refused += 1
        elif row not in best:
            best[row] = column
        else:
            refused += 1
            if costs[row, column] < costs[row, best[row]]:
                best[row] = column
    new = np.flatnonzero(action == slot_count)
    free = slot_count - len(slots)
    pairs = np.array(sorted(best.items()), np.int64).reshape(-1, 2)
    lost = np.setdiff1d(np.arange(len(slots)), pairs[:, 0])
    return Match(pairs, lost, new[:free]), refused + max(0, len(new) - free)
