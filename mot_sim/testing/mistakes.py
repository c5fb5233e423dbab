"""What a tracker did wrong, frame by frame, by the same rules as its scores: what CLEAR counts."""

from collections import Counter
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.metrics.clear import match_in_time
from mot_sim.metrics.matching import Overlaps
from mot_sim.metrics.preprocessing import counted_output, prepare_sequence, scored_rows
from tracker import Tracks

Kind = Literal["switch", "miss", "false positive"]
MISTAKE_KINDS: tuple[Kind, ...] = ("switch", "miss", "false positive")  # the worst first
ORDER = {kind: number for number, kind in enumerate(MISTAKE_KINDS)}


@dataclass(frozen=True, eq=False)
class Mistake:
    """One mistake of a tracker."""

    frame: int
    """Frame in which it happens."""
    kind: Kind
    """switch, miss or false positive."""
    car: int | None = None
    """Id of the label; None for a false positive."""
    name: int | None = None
    """Id of the output; None for a miss."""
    car_box: Float[Array, " 4"] | None = None
    """Box of the label: x_min, y_min, x_max, y_max in px; None for a false positive."""
    name_box: Float[Array, " 4"] | None = None
    """Box of the output: x_min, y_min, x_max, y_max in px; None for a miss."""
    before: tuple[int, int] | None = None
    """For a switch, the car's output id before it, and the last frame with that id; else None."""
    near: tuple[int, float] | None = None
    """For a miss or false positive, the id on the other side that overlaps it most, and their IoU;
    None: no overlap."""

    def __str__(self) -> str:
        if self.kind == "switch" and self.before is not None:
            name, frame = self.before
            return (
                f"switch: car {self.car} was id {name} in frame {frame} and is id {self.name} now\n"
                f"    car {self.car} {_box(self.car_box)}   id {self.name} {_box(self.name_box)}"
            )
        if self.kind == "miss":
            near = _near(self.near, "id")
            return f"miss: no id for car {self.car} {_box(self.car_box)}{near}"
        near = _near(self.near, "car")
        return f"false positive: id {self.name} {_box(self.name_box)} is no car{near}"


def _box(box: Float[Array, " 4"] | None) -> str:
    """A box to a tenth of a pixel."""
    return "" if box is None else f"[{' '.join(f'{edge:.1f}' for edge in box)}]"


def _near(near: tuple[int, float] | None, what: str) -> str:
    """Who else was there."""
    return "" if near is None else f"; {what} {near[0]} overlaps it by {near[1]:.2f}"


@dataclass(frozen=True, eq=False)
class Mistakes:
    """All mistakes of a tracker on a drive."""

    found: tuple[Mistake, ...]
    """The mistakes, by frame; within a frame switches first, then misses."""

    @classmethod
    def of(cls, truth: Tracks, output: Tracks, frame_count: int) -> "Mistakes":
        """Of an output; what TrackEval's rules ignore is no mistake."""
        contest = prepare_sequence(truth, output, frame_count)
        overlaps = scored_rows(contest)
        cars = contest.overlaps.truth.ids[~contest.neutral]
        names = contest.overlaps.output.ids[counted_output(contest)]
        busy = np.intersect1d(overlaps.truth.frames, overlaps.output.frames)
        matched = match_in_time(overlaps, busy)
        found = [
            *_switches(overlaps, matched.tolist(), cars.tolist(), names.tolist()),
            *_unmatched(overlaps, set(matched.tolist()), cars.tolist(), names.tolist()),
        ]
        return cls(tuple(sorted(found, key=lambda each: (each.frame, ORDER[each.kind]))))

    def __len__(self) -> int:
        return len(self.found)

    def counts(self) -> Counter[str]:
        """How many there are of each kind."""
        return Counter(each.kind for each in self.found)

    def first(self, kinds: tuple[Kind, ...] = MISTAKE_KINDS) -> Mistake | None:
        """The first of these kinds."""
        return next((each for each in self.found if each.kind in kinds), None)

    def in_frame(self, frame: int) -> tuple[Mistake, ...]:
        """Those of a frame."""
        return tuple(each for each in self.found if each.frame == frame)


def _switches(
    overlaps: Overlaps, matched: list[int], cars: list[int], names: list[int]
) -> list[Mistake]:
    """Where a car has another name than when it was last matched."""
    last: dict[int, tuple[int, int]] = {}
    found = []
    for pair in matched:
        row, column, frame = overlaps.rows[pair], overlaps.columns[pair], int(overlaps.frames[pair])
        car, name = cars[row], names[column]
        before = last.get(car)
        if before is not None and before[0] != name:
            boxes = overlaps.truth.boxes[row], overlaps.output.boxes[column]
            found.append(Mistake(frame, "switch", car, name, *boxes, before=before))
        last[car] = name, frame
    return found


def _unmatched(
    overlaps: Overlaps, matched: set[int], cars: list[int], names: list[int]
) -> list[Mistake]:
    """Cars without a name, and names without a car."""
    pairs = list(matched)
    seen, used = set(overlaps.rows[pairs].tolist()), set(overlaps.columns[pairs].tolist())
    nearest_name, nearest_car = _nearest(overlaps, cars, names)
    missed = [
        Mistake(
            int(overlaps.truth.frames[row]), "miss", car, None, overlaps.truth.boxes[row],
            near=nearest_name.get(row),
        )
        for row, car in enumerate(cars)
        if row not in seen
    ]  # fmt: skip
    invented = [
        Mistake(
            int(overlaps.output.frames[column]), "false positive", None, name,
            name_box=overlaps.output.boxes[column], near=nearest_car.get(column),
        )
        for column, name in enumerate(names)
        if column not in used
    ]  # fmt: skip
    return missed + invented


def _nearest(
    overlaps: Overlaps, cars: list[int], names: list[int]
) -> tuple[dict[int, tuple[int, float]], dict[int, tuple[int, float]]]:
    """Of every row and column that overlaps anything: who overlaps it most, and by how much."""
    of_row: dict[int, tuple[int, float]] = {}
    of_column: dict[int, tuple[int, float]] = {}
    for pair in np.argsort(overlaps.iou, kind="stable").tolist():
        row, column = int(overlaps.rows[pair]), int(overlaps.columns[pair])
        share = float(overlaps.iou[pair])
        of_row[row], of_column[column] = (names[column], share), (cars[row], share)
    return of_row, of_column


__all__ = ["MISTAKE_KINDS", "Kind", "Mistake", "Mistakes"]
