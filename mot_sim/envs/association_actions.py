"""What an action of the association environment means: slots of tracks, matches, masks."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.association import Match
from tracker.batch import BatchCosts, BatchMatch

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


def decide_batch(
    action: Int[Array, "e d"], compared: BatchCosts, slots: Int[Array, " n"], slot_count: int
) -> tuple[BatchMatch, Bool[Array, " m"]]:
    """`decide` for every drive: the match, and which of all detections could not be placed.

    slots: of all tracks.
    """
    of_track, of_found = compared.track_drives, compared.detection_drives
    m = len(of_found)
    chosen = action[of_found, np.arange(m) - compared.columns[of_found]]
    rows_of = np.full((len(action), slot_count), EMPTY_SLOT)
    rows_of[of_track, slots] = np.arange(len(slots))
    asked = np.flatnonzero(chosen < slot_count)
    rows = rows_of[of_found[asked], chosen[asked]]
    costs = costs_of(compared, rows, asked)
    is_possible = np.isfinite(costs)
    refused = np.zeros(m, bool)
    refused[asked[~is_possible]] = True
    rows, asked, costs = rows[is_possible], asked[is_possible], costs[is_possible]
    order = np.lexsort((asked, costs, rows))
    rows, asked = rows[order], asked[order]
    is_best = np.ones(len(rows), bool)
    is_best[1:] = rows[1:] != rows[:-1]
    refused[asked[~is_best]] = True
    pairs = np.stack((rows[is_best], asked[is_best]), axis=1)
    new = np.flatnonzero(chosen == slot_count)
    rank = np.arange(len(new)) - np.searchsorted(of_found[new], of_found[new])
    has_slot = rank < (slot_count - np.diff(compared.starts))[of_found[new]]
    refused[new[~has_slot]] = True
    is_lost = np.ones(len(slots), bool)
    is_lost[pairs[:, 0]] = False
    return BatchMatch(pairs, np.flatnonzero(is_lost), new[has_slot]), refused


def costs_of(
    compared: BatchCosts, rows: Int[Array, " k"], columns: Int[Array, " k"]
) -> Float[Array, " k"]:
    """What these pairs cost; inf where they were not compared."""
    width = max(int(compared.columns[-1]), 1)
    known, wanted = compared.pairs[0] * width + compared.pairs[1], rows * width + columns
    costs = np.full(len(rows), np.inf)
    if len(known):
        at = np.searchsorted(known, wanted).clip(max=len(known) - 1)
        is_known = (known[at] == wanted) & (rows != EMPTY_SLOT)
        costs[is_known] = compared.costs[at[is_known]]
    return costs


def slots_after(
    slots: Int[Array, " n"],
    sources: Int[Array, " k"],
    drives: Int[Array, " k"],
    shape: tuple[int, int],
) -> Int[Array, " k"]:
    """`Slots.after` for every drive: the slots of the tracks now.

    slots: of those before. sources: the row before of each track now, -1 for a new one. drives: of
    the tracks now, ascending. shape: how many drives, and slots.
    """
    is_new = sources < 0
    after = np.where(is_new, EMPTY_SLOT, slots[sources] if len(slots) else EMPTY_SLOT)
    is_free = np.ones(shape, bool)
    is_free[drives[~is_new], after[~is_new]] = False
    free_drives, free_slots = is_free.nonzero()
    new = drives[is_new]
    rank = np.arange(len(new)) - np.searchsorted(new, new)
    after[is_new] = free_slots[np.searchsorted(free_drives, new) + rank]
    return after
