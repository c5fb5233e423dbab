"""KITTI's classes of objects, and how other people spell them."""

import numpy as np
from jaxtyping import Bool, Shaped
from numpy import ndarray as Array

from tracker.errors import BadConfig, UnknownName

# All that KITTI's tracking labels hold, and 'Person_sitting' of its object benchmark.
KITTI_KINDS = (
    "Car", "Van", "Truck", "Pedestrian", "Person", "Person_sitting", "Cyclist", "Tram", "Misc",
    "DontCare",
)  # fmt: skip
# The classes that are tracked and scored, each with the classes that look like it: a label of
# those need not be found, but may be. KITTI's benchmark scores Car and Pedestrian; Cyclist goes by
# the same rules.
TRACKED_KINDS = {"Car": ("Van",), "Pedestrian": ("Person", "Person_sitting"), "Cyclist": ()}
# MOT16's numbers of KITTI's classes (Milan et al., arXiv 1603.00831); what is none of them is a
# distractor, which is neither rewarded nor punished.
MOT_CLASSES = {"Pedestrian": 1, "Cyclist": 2, "Car": 3, "Person": 7, "Person_sitting": 7}
MOT_DISTRACTOR = 8
# Length, height and width of the mean car among KITTI's labels (ten sequences), m, and the stds of
# sizes, shares of them.
CAR_SIZE, CAR_SIZE_STD = (3.89, 1.506, 1.606), (0.1, 0.078, 0.068)
_BY_LOWER_CASE = {kind.lower(): kind for kind in KITTI_KINDS}


def parse_kinds(text: str) -> tuple[str, ...]:
    """The classes of `car,pedestrian`, in KITTI's spelling and in that order.

    Raises UnknownName for what is none of TRACKED_KINDS, BadConfig for one that stands twice.
    """
    kinds = tuple(_BY_LOWER_CASE.get(word.strip().lower(), word) for word in text.split(","))
    for kind in kinds:
        if kind not in TRACKED_KINDS:
            raise UnknownName.of("class", kind, TRACKED_KINDS)
    if len(set(kinds)) < len(kinds):
        raise BadConfig(f"classes {text!r}: name each class once")
    return kinds


def spelled_as_kitti(kinds: Shaped[Array, " n"]) -> Shaped[Array, " n"]:
    """The same classes in KITTI's spelling, whatever their case; other words stay as they are."""
    # (Almost always they are spelled so already: to sort all rows takes six times as long.)
    if all(_in_kittis_spelling(str(kind)) == str(kind) for kind in set(kinds.tolist())):
        return kinds
    found, place = np.unique(kinds, return_inverse=True)
    return np.array([_in_kittis_spelling(str(kind)) for kind in found.tolist()])[place.reshape(-1)]


def _in_kittis_spelling(word: str) -> str:
    return _BY_LOWER_CASE.get(word.strip().lower(), word)


def is_kitti_kind(kinds: Shaped[Array, " n"]) -> Bool[Array, " n"]:
    """Which of these words are classes of KITTI, in KITTI's spelling."""
    return np.isin(kinds, KITTI_KINDS)


def kinds_said(kinds: Shaped[Array, " n"]) -> str:
    """How many rows are of which kind, the most frequent first: `120 of Van, 3 of Truck`.

    Characters that no file or terminal can take (halves of pairs, as JSON may have) are escaped.
    """
    found, counts = np.unique(kinds, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    said = ", ".join(f"{counts[index]} of {found[index]}" for index in order.tolist())
    return said.encode("utf-8", "backslashreplace").decode("utf-8")
