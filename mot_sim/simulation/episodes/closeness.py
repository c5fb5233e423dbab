"""Whether a new run that is not bit-equal prints the same numbers.

Another CPU, or another build of NumPy's linear algebra, rounds the last bits in another way.
"""

from math import isclose

import numpy as np
from numpy import ndarray as Array

from mot_sim.simulation.episodes.extra import PART_TABLES, read_arrays
from mot_sim.simulation.episodes.places import TEXTS, EpisodeFiles

# Text files print six decimals: one unit of the last digit, and its rounding.
ABSOLUTE = 2e-6
RELATIVE = 1e-9


def prints_the_same(part: str, recorded: EpisodeFiles, rerun: EpisodeFiles) -> bool:
    """Whether all numbers of a part of two runs agree to the printed digits.

    part: of TEXTS, or of PART_TABLES; pictures are never close: a pixel is a whole number.
    Whole numbers and words must be equal. Raises BadFile for files that cannot be read.
    """
    if part in TEXTS:
        ours, theirs = (_rows_of(places, part) for places in (recorded, rerun))
        return len(ours) == len(theirs) and all(map(_agree, ours, theirs))
    if part not in PART_TABLES:
        return False
    arrays = [read_arrays(places.extra, PART_TABLES[part]) for places in (recorded, rerun)]
    return arrays[0].keys() == arrays[1].keys() and all(
        _close(arrays[0][name], arrays[1][name]) for name in arrays[0]
    )


def _rows_of(places: EpisodeFiles, part: str) -> list[list[str]]:
    text = places.text(part).read_text(encoding="utf-8")
    return [line.replace(",", " ").split() for line in text.splitlines()]


def _agree(ours: list[str], theirs: list[str]) -> bool:
    return len(ours) == len(theirs) and all(map(_agrees, ours, theirs))


def _agrees(ours: str, theirs: str) -> bool:
    if ours == theirs:
        return True
    if "." not in ours or "." not in theirs:
        return False
    return isclose(float(ours), float(theirs), rel_tol=RELATIVE, abs_tol=ABSOLUTE)


def _close(ours: Array, theirs: Array) -> bool:
    if ours.shape != theirs.shape or ours.dtype.kind != theirs.dtype.kind:
        return False
    if ours.dtype.kind != "f":
        return bool((ours == theirs).all())
    return np.allclose(ours, theirs, RELATIVE, ABSOLUTE, equal_nan=True)
