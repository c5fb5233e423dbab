"""Whether an episode's file can be what it says: the words of its metadata, its numbers, its rows.

The checksum of the file finds accidents; this finds what was written on purpose.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy import ndarray as Array

from mot_sim.files.text import MAX_NUMBER
from mot_sim.simulation.episodes.places import PICTURES
from tracker.errors import BadFile

# Tables whose numbers may be NaN, where a car is not there or a point is behind the camera.
WITH_GAPS = ("traffic.", "truth.", "log.")
NEVER_NAN = ("traffic.ego", "traffic.start", "log.detections.boxes", "log.detections.scores")
# Columns of the truth that are there, though other tracks may lack them.
ALWAYS = tuple(
    f"truth.tracks.{column}"
    for column in (
        "kinds", "truncation", "occlusion", "cuboids.base", "cuboids.yaw", "cuboids.size"
    )
)  # fmt: skip
FRAMES = ("truth.tracks.frames", "occlusions.frames", "events.frames", "log.frames")


def require_metadata(told: Any) -> None:
    """Raise ValueError for metadata with words where numbers belong, and the other way round."""
    kinds = {
        "scene": str, "knobs": dict, "seed": int, "frames": int, "renderer": str | None,
        "pictures": list, "versions": dict, "sha256": dict,
    }  # fmt: skip
    for name, kind in kinds.items():
        value = told[name]
        if not isinstance(value, kind) or isinstance(value, bool):
            raise ValueError(f"{name} is {value!r:.80}")
    if not (0 <= told["seed"] < 2**63 and told["frames"] >= 0):
        raise ValueError(f"seed {told['seed']!r:.30} and {told['frames']!r:.30} frames")
    if not all(isinstance(part, str) and part in PICTURES for part in told["pictures"]):
        raise ValueError(f"pictures {told['pictures']!r:.80}; known: {', '.join(PICTURES)}")
    words = [*told["versions"].values(), *told["sha256"].values()]
    if not all(isinstance(word, str) for word in words):
        raise ValueError("a version or a hash that is no word")
    if not all(isinstance(knob, int | float | str) for knob in told["knobs"].values()):
        raise ValueError(f"knobs {told['knobs']!r:.80}")


def require_sound(arrays: Mapping[str, Array], frame_count: int, path: Path) -> None:
    """Raise BadFile for numbers that no episode has.

    Those are: infinity, giants, NaN where a number must be, frames outside the recording or out
    of order, more frames than worlds.
    """
    worlds = len(arrays["traffic.present"])
    if not 0 <= frame_count <= worlds:
        raise BadFile(f"{path}: {frame_count} frames of {worlds} worlds; record again")
    for name, array in arrays.items():
        if array.dtype.kind != "f":
            continue
        numbers = array if name in NEVER_NAN or not name.startswith(WITH_GAPS) else _known(array)
        if not (np.abs(numbers) <= MAX_NUMBER).all():
            raise BadFile(f"{path}: {name} holds a number that is not finite; record again")
    for name in FRAMES:
        frames = arrays[name]
        if len(frames) and not (frames[0] >= 0 and frames[-1] < max(worlds, 1)):
            raise BadFile(f"{path}: {name} reaches beyond the {worlds} worlds; record again")
        if (frames[1:] < frames[:-1]).any():
            raise BadFile(f"{path}: {name} is not in order; record again")


def _known(array: Array) -> Array:
    return array[~np.isnan(array)]
