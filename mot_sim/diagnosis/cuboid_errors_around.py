"""How far cuboids are off while something happens to their car: occlusion, a turn, a gap."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool
from numpy import ndarray as Array

from mot_sim.diagnosis.context_events import PAIR_KINDS, ContextEvents
from mot_sim.metrics.cuboid_errors import BACKWARDS, NEAR, WRONG, CuboidErrors

ALL_ROWS, OTHER_ROWS = "all", "none of these"


@dataclass(frozen=True)
class CuboidCounts:
    """Rows that meet a label in the image, and what is wrong with their cuboids; they add up."""

    rows: int = 0
    """Rows whose cuboid is known."""
    near: int = 0
    """Rows whose centre is within 2 m, seen from above."""
    metres: float = 0.0
    """Distances of all centres, added up, m."""
    wrong: int = 0
    """Rows whose heading is off by more than 30 degrees."""
    backwards: int = 0
    """Rows whose heading is off by more than 90 degrees."""

    def __add__(self, other: "CuboidCounts") -> "CuboidCounts":
        mine, theirs = vars(self), vars(other)
        return CuboidCounts(**{name: mine[name] + theirs[name] for name in mine})

    @classmethod
    def of(cls, errors: CuboidErrors) -> "CuboidCounts":
        """The counts of some rows; those that lack a cuboid are left out."""
        known = errors.select(np.isfinite(errors.centre) & np.isfinite(errors.heading))
        turn = np.abs(known.heading)
        return cls(
            rows=len(known),
            near=int((known.centre <= NEAR).sum()),
            metres=float(known.centre.sum()),
            wrong=int((turn > WRONG).sum()),
            backwards=int((turn > BACKWARDS).sum()),
        )


def counts_around(
    errors: CuboidErrors, events: ContextEvents, margin: int
) -> dict[str, CuboidCounts]:
    """The counts by what happened to the car, by kind of event and its bins.

    A row is around an event from `margin` frames before it to as many after it; around several it
    counts for each. Also of all rows, and of those around no event.
    """
    around: dict[str, Bool[Array, " n"]] = {}
    anything = np.zeros(len(errors), dtype=bool)
    columns = events.firsts, events.lasts, events.ids, events.others
    for row, (first, last, car, other) in enumerate(
        zip(*(column.tolist() for column in columns), strict=True)
    ):
        mine = errors.truth_ids == car
        if events.kinds[row] in PAIR_KINDS:
            mine = mine | (errors.truth_ids == other)
        mine &= (errors.frames >= first - margin) & (errors.frames <= last + margin)
        anything |= mine
        for name in events.bins_of(row):
            around[name] = around[name] | mine if name in around else mine
    around = {ALL_ROWS: np.ones(len(errors), dtype=bool), **around, OTHER_ROWS: ~anything}
    return {name: CuboidCounts.of(errors.select(rows)) for name, rows in around.items()}
