"""KITTI's classes of objects, and how other people spell them."""

import numpy as np
from jaxtyping import Bool, Shaped
from numpy import ndarray as Array

# All that KITTI's tracking labels hold, and 'Person_sitting' of its object benchmark.
KITTI_KINDS = (
    "Car", "Van", "Truck", "Pedestrian", "Person", "Person_sitting", "Cyclist", "Tram", "Misc",
    "DontCare",
)  # fmt: skip
_BY_LOWER_CASE = {kind.lower(): kind for kind in KITTI_KINDS}


def spelled_as_kitti(kinds: Shaped[Array, " n"]) -> Shaped[Array, " n"]:
    """The same classes in KITTI's spelling, whatever their case; other words stay as they are."""
    found, place = np.unique(kinds, return_inverse=True)
    words = [str(kind) for kind in found.tolist()]
    spelled = [_BY_LOWER_CASE.get(word.strip().lower(), word) for word in words]
    if spelled == words:
        return kinds
    return np.array(spelled)[place.reshape(-1)]


def is_kitti_kind(kinds: Shaped[Array, " n"]) -> Bool[Array, " n"]:
    """Which of these words are classes of KITTI, in KITTI's spelling."""
    return np.isin(kinds, KITTI_KINDS)


def kinds_said(kinds: Shaped[Array, " n"]) -> str:
    """How many rows are of which kind, the most frequent first: `120 of Van, 3 of Truck`."""
    found, counts = np.unique(kinds, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return ", ".join(f"{counts[index]} of {found[index]}" for index in order.tolist())
