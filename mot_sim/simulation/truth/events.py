"""What happens to cars over time: they enter and leave, hide and reappear, cross, collide."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped
from numpy import ndarray as Array

from mot_sim.simulation.traffic.traffic_state import TrafficState, collisions
from mot_sim.simulation.truth.table import Truth
from tracker.types import Rows

EVENTS = ("enter", "leave", "occlusion begins", "occlusion ends", "crossing", "collision")
# A car is hidden from less than the first visible fraction on, until it is above the second.
HIDDEN_BELOW = 0.4
CLEAR_ABOVE = 0.5
Row = tuple[int, str, int, int]


@dataclass(frozen=True, eq=False)
class Events(Rows):
    """One row per event, in the order of frames."""

    frames: Int[Array, " n"]
    """Frame in which it happens; 'enter' is the first one with a visible pixel of a stay in the
    image, 'leave' the first one after the stay."""
    kinds: Shaped[Array, " n"]
    """Of EVENTS; a car that is hidden for a while has not left."""
    ids: Int[Array, " n"]
    """The car."""
    others: Int[Array, " n"]
    """The other car of a crossing (visible boxes overlap and change sides) or of a collision (-1:
    the ego car); -2 where there is none."""

    @classmethod
    def of(cls, rows: Iterable[Row]) -> "Events":
        """The table of rows in any order."""
        ordered = sorted(rows)
        frames, kinds, ids, others = zip(*ordered, strict=True) if ordered else ((), (), (), ())
        return cls(
            np.array(frames, np.int64),
            np.array(kinds, "<U16"),
            np.array(ids, np.int64),
            np.array(others, np.int64),
        )


def find_events(truth: Truth, states: Iterable[TrafficState]) -> Events:
    """All events of a run; state i is frame i of the truth."""
    states = list(states)
    rows: list[Row] = []
    order = np.argsort(truth.tracks.ids, kind="stable")
    numbers, starts = np.unique(truth.tracks.ids[order], return_index=True)
    for number, own in zip(numbers.tolist(), np.split(order, starts)[1:], strict=True):
        shown = truth.tracks.frames[own], truth.pixels[own], truth.visible[own]
        rows += stays(*shown, number, len(states))
    return Events.of([*rows, *crossings(truth, len(states)), *crashes(states)])


def stays(
    frames: Int[Array, " n"],
    pixels: Int[Array, " n"],
    visible: Float[Array, " n"],
    number: int,
    frame_count: int,
) -> list[Row]:
    """The stays of one car in the image, and the times it is hidden in each.

    frames, pixels, visible: its rows of the truth.
    """
    rows: list[Row] = []
    breaks = np.flatnonzero(np.diff(frames) > 1) + 1
    for stay in np.split(np.arange(len(frames)), breaks):
        shown = np.flatnonzero(pixels[stay] > 0)
        if not len(shown):
            continue
        seen = stay[shown[0] :]
        rows.append((int(frames[seen[0]]), "enter", number, -2))
        rows += hidings(visible[seen].tolist(), frames[seen].tolist(), number)
        left = int(frames[stay[-1]]) + 1
        if left < frame_count:
            rows.append((left, "leave", number, -2))
    return rows


def hidings(visible: list[float], frames: list[int], number: int) -> list[Row]:
    """Where occlusions begin and end, with a margin between."""
    rows: list[Row] = []
    hidden = False
    for fraction, frame in zip(visible, frames, strict=True):
        if not hidden and fraction < HIDDEN_BELOW:
            hidden = True
            rows.append((frame, "occlusion begins", number, -2))
        elif hidden and fraction > CLEAR_ABOVE:
            hidden = False
            rows.append((frame, "occlusion ends", number, -2))
    return rows


def crossings(truth: Truth, frame_count: int) -> list[Row]:
    """Pairs of cars whose boxes overlap and whose centres change sides since the frame before."""
    rows: list[Row] = []
    bounds = np.searchsorted(truth.tracks.frames, np.arange(frame_count + 1)).tolist()
    before: tuple[Int[Array, " a"], Array] | None = None
    for frame in range(frame_count):
        part = slice(bounds[frame], bounds[frame + 1])
        ids, boxes = truth.tracks.ids[part], truth.amodal_boxes[part]
        if before is not None:
            at = np.searchsorted(before[0], ids).clip(max=len(before[0]) - 1)
            now = np.flatnonzero(before[0][at] == ids) if len(before[0]) else at[:0]
            old, new, shared = before[1][at[now]], boxes[now], ids[now]
            turned = np.sign(_offsets(old)) * np.sign(_offsets(new)) < 0
            a, b = np.nonzero(np.triu(turned, k=1))
            overlaps = _overlap(new[a], new[b])
            pairs = np.stack((shared[a], shared[b]), axis=1)[overlaps].tolist()
            rows += [(frame, "crossing", one, other) for one, other in pairs]
        before = ids, boxes
    return rows


def crashes(states: list[TrafficState]) -> list[Row]:
    """Pairs of cars that begin to touch."""
    rows: list[Row] = []
    before: set[tuple[int, int]] = set()
    for frame, state in enumerate(states):
        now = {(int(a), int(b)) for a, b in collisions(state)}
        # The ego car, -1, is named second.
        rows += [(frame, "collision", max(p), min(p)) for p in sorted(now - before)]
        before = now
    return rows


def _offsets(boxes: Array) -> Array:
    """How far right of one another the centres of boxes are; (n, n)."""
    middle = boxes[:, 0] + boxes[:, 2]
    return middle[None] - middle[:, None]


def _overlap(one: Float[Array, "n 4"], other: Float[Array, "n 4"]) -> Bool[Array, " n"]:
    """Which pairs of boxes share some area."""
    low = np.maximum(one[:, :2], other[:, :2])
    return (np.minimum(one[:, 2:], other[:, 2:]) > low).all(axis=1)
