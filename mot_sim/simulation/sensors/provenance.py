"""Where every detection came from; kept apart from the frames, so that no tracker can see it."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Int, Shaped
from numpy import ndarray as Array

from mot_sim.datasets.recorded import DetectionLog
from tracker.types import Rows

Source = Literal["object", "duplicate", "merged", "split", "clutter"]
NO_OBJECT = -1


@dataclass(frozen=True, eq=False)
class Provenance(Rows):
    """A row a detection, in the order of its log.

    sources: object, duplicate, merged, split, clutter. ids: the object of truth that it shows,
    or is a copy or a part of; -1 for clutter. others: the second object in a merged box, else -1.
    """

    sources: Shaped[Array, " n"]
    ids: Int[Array, " n"]
    others: Int[Array, " n"]

    @classmethod
    def of(cls, source: Source, ids: Int[Array, " n"]) -> "Provenance":
        """Rows of one source."""
        nobody = np.full(len(ids), NO_OBJECT)
        return cls(np.full(len(ids), source, "<U9"), ids, nobody)


@dataclass(frozen=True, eq=False)
class Sensed:
    """What a detector gave, and where each row of it came from."""

    log: DetectionLog
    provenance: Provenance
