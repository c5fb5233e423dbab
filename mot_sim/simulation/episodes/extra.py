"""The one file with what KITTI's cannot hold: traffic, vehicles, all of the truth, exact camera.

The checksum of the file finds accidents; `require_sound` finds what was written on purpose.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from jaxtyping import jaxtyped
from numpy import ndarray as Array

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.files.array_files import ArrayFormat, checksum, require_columns
from mot_sim.files.documents import parse_json
from mot_sim.files.text import MAX_NUMBER
from mot_sim.simulation.cars.vehicles import Vehicles
from mot_sim.simulation.episode import SimulatedDrive
from mot_sim.simulation.episodes.places import PICTURES
from mot_sim.simulation.scene import Knob
from mot_sim.simulation.traffic.recording import RecordedTraffic
from mot_sim.simulation.truth import Annotations, Events, Occlusions, Truth
from tracker.errors import BadCalibration, BadFile
from tracker.types import Camera, Cuboids, Detections, Tracks

# Tables whose numbers may be NaN, where a car is not there or a point is behind the camera.
MAY_BE_NAN = ("traffic.", "truth.", "log.")
NEVER_NAN = ("traffic.ego", "traffic.start", "log.detections.boxes", "log.detections.scores")
# Columns of the truth that are there, though other tracks may lack them.
TRUTH_COLUMNS = tuple(
    f"truth.tracks.{column}"
    for column in (
        "kinds", "truncation", "occlusion", "cuboids.base", "cuboids.yaw", "cuboids.size"
    )
)  # fmt: skip
FRAME_COLUMNS = ("truth.tracks.frames", "occlusions.frames", "events.frames", "log.frames")
EPISODE_FORMAT = ArrayFormat("an episode", 1)
Kind = TypeVar("Kind")
# The tables of the file, and the tables that stand in their columns.
TABLES: dict[str, type] = {
    "traffic": RecordedTraffic, "vehicles": Vehicles, "truth": Truth, "occlusions": Occlusions,
    "events": Events, "log": DetectionLog, "camera": Camera,
}  # fmt: skip
INNER_TABLES: dict[str, type] = {"tracks": Tracks, "cuboids": Cuboids, "detections": Detections}
TRUTH_TABLES = (
    "vehicles",
    "truth",
    "occlusions",
    "events",
    "camera",
)  # the tables of the truth's checksum
# The parts of an episode that stand in this file, and their tables.
PART_TABLES = {"trajectories": ("traffic",), "truth": TRUTH_TABLES}
METADATA = "metadata"
# What the columns were called in earlier versions, and what they are called now.
FORMER_NAMES = {
    "truth.cut": "truth.truncation",
    "truth.whole_pixels": "truth.amodal_pixels",
    "truth.full_boxes": "truth.amodal_boxes",
    "truth.seen_boxes": "truth.visible_boxes",
    "occlusions.by": "occlusions.occluder_ids",
    **{f"cast.{column.name}": f"vehicles.{column.name}" for column in fields(Vehicles)},
}


def require_metadata(told: Any) -> None:
    """Raise ValueError for metadata with words where numbers belong, and the other way round."""
    kinds = {
        "scene": str,
        "knobs": dict,
        "seed": int,
        "frames": int,
        "renderer": str | None,
        "pictures": list,
        "versions": dict,
        "sha256": dict,
    }
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
    of order, more frames than states.
    """
    states = len(arrays["traffic.present"])
    if not 0 <= frame_count <= states:
        raise BadFile(f"{path}: {frame_count} frames of {states} states; record again")
    for name, array in arrays.items():
        if array.dtype.kind != "f":
            continue
        numbers = array if name in NEVER_NAN or not name.startswith(MAY_BE_NAN) else _known(array)
        if not (np.abs(numbers) <= MAX_NUMBER).all():
            raise BadFile(f"{path}: {name} holds a number that is not finite; record again")
    for name in FRAME_COLUMNS:
        frames = arrays[name]
        if len(frames) and not (frames[0] >= 0 and frames[-1] < max(states, 1)):
            raise BadFile(f"{path}: {name} reaches beyond the {states} states; record again")
        if (frames[1:] < frames[:-1]).any():
            raise BadFile(f"{path}: {name} is not in order; record again")


def _known(array: Array) -> Array:
    return array[~np.isnan(array)]


@dataclass(frozen=True)
class Metadata:
    """How an episode was made."""

    scene: str
    """Name of the scene."""
    knobs: Mapping[str, Knob]
    """What the scene was made with, by name: numbers or words."""
    seed: int
    """Random seed, 0 to 2^63 - 1."""
    frames: int
    """Frames that were recorded, >= 0; fewer than the scene's after an interruption."""
    renderer: str | None
    """Name of what drew the pictures; None: nothing was drawn."""
    pictures: tuple[str, ...]
    """Kinds of pictures that were drawn, of PICTURES."""
    versions: Mapping[str, str]
    """Versions of the software that made the episode, by name."""
    sha256: Mapping[str, str]
    """Hash of each part of the tree; `trajectories` of the traffic's arrays, `truth` of the
    truth's."""

    @classmethod
    def parse(cls, text: str, path: Path) -> "Metadata":
        """From JSON. Raises BadFile."""
        try:
            told = parse_json(text, f"{path}")
            require_metadata(told)
            return cls(**{**told, "pictures": tuple(told["pictures"])})
        except (BadFile, ValueError, TypeError, KeyError) as error:
            raise BadFile(
                f"{path}: its metadata are none of ours: {error!r}; record again"
            ) from None


@dataclass(frozen=True, eq=False)
class Extra:
    """All that the file holds."""

    metadata: Metadata
    """How the episode was made."""
    traffic: RecordedTraffic
    """Who was where."""
    vehicles: Vehicles
    """Who the cars are."""
    annotations: Annotations
    """The ground truth of all frames, and who hides whom."""
    events: Events
    """What happens in the run."""
    log: DetectionLog
    """What the detector gave."""
    camera: Camera
    """The exact camera."""


def arrays_of(drive: SimulatedDrive) -> dict[str, Array]:
    """The arrays of an episode, by `table.column`."""
    tables = {
        "traffic": drive.traffic,
        "vehicles": drive.vehicles,
        "truth": drive.exact,
        "occlusions": drive.occlusions,
        "events": drive.events,
        "log": drive.log,
        "camera": drive.camera,
    }
    found: dict[str, Array] = {}
    for name, table in tables.items():
        found |= _columns(name, table)
    return found


def array_digests(arrays: Mapping[str, Array]) -> dict[str, str]:
    """SHA-256 of the trajectories and of the truth."""

    def digest(*names: str) -> str:
        return checksum({key: arrays[key] for key in arrays if key.split(".")[0] in names})

    return {part: digest(*names) for part, names in PART_TABLES.items()}


def read_arrays(path: Path, tables: Sequence[str]) -> dict[str, Array]:
    """The arrays of some tables of the file, by `table.column`. Raises BadFile."""
    extra = read_extra(path)
    found: dict[str, Array] = {}
    for name in tables:
        inside = {"truth": extra.annotations.truth, "occlusions": extra.annotations.occlusions}
        found |= _columns(name, inside.get(name) or getattr(extra, name))
    return found


def write_extra(path: Path, metadata: Metadata, arrays: Mapping[str, Array]) -> None:
    """Write the file, as a whole or not at all. Raises BadOutput."""
    told = np.array(json.dumps(asdict(metadata)))
    EPISODE_FORMAT.write(path, {METADATA: told, **arrays})


def read_extra(path: Path) -> Extra:
    """All that the file holds, also under the names of earlier versions.

    Raises BadFile for any other file, naming it and the cure.
    """
    needed, optional = {METADATA, *TRUTH_COLUMNS}, set()
    for name, kind in TABLES.items():
        must, may = _names(name, kind)
        needed |= must
        optional |= may
    written = EPISODE_FORMAT.read(path, needed, optional, FORMER_NAMES)
    metadata = Metadata.parse(str(written.pop(METADATA)), path)
    arrays = {FORMER_NAMES.get(name, name): array for name, array in written.items()}
    if FORMER_NAMES.keys() & written.keys():  # names enter the hashes
        metadata = replace(metadata, sha256={**metadata.sha256, **array_digests(arrays)})
    for name, kind in TABLES.items():
        with jaxtyped("context"):
            _require_table(name, kind, arrays, path)
    require_sound(arrays, metadata.frames, path)
    truth = Annotations(_table("truth", Truth, arrays), _table("occlusions", Occlusions, arrays))
    return Extra(
        metadata,
        _table("traffic", RecordedTraffic, arrays),
        _table("vehicles", Vehicles, arrays),
        truth,
        _table("events", Events, arrays),
        _table("log", DetectionLog, arrays),
        _camera(arrays, path),
    )


def _columns(name: str, table: object) -> dict[str, Array]:
    """The arrays of a table and of the tables in its columns; absent columns are left out."""
    found: dict[str, Array] = {}
    for column in fields(table):  # type: ignore[arg-type]
        value = getattr(table, column.name)
        if column.name in INNER_TABLES and value is not None:
            found |= _columns(f"{name}.{column.name}", value)
        elif value is not None:
            found[f"{name}.{column.name}"] = np.asarray(value)
    return found


def _names(name: str, kind: Any) -> tuple[set[str], set[str]]:
    """The arrays that a table must have, and those that it may have."""
    must: set[str] = set()
    may: set[str] = set()
    for column in fields(kind):
        key, always = f"{name}.{column.name}", column.default is MISSING
        if column.name in INNER_TABLES:
            inner, more = _names(key, INNER_TABLES[column.name])
            must, may = (must | inner, may | more) if always else (must, may | inner | more)
        else:
            (must if always else may).add(key)
    return must, may


def _require_table(name: str, kind: Any, arrays: Mapping[str, Array], path: Path) -> None:
    """Raise BadFile unless the columns of a table, and of those inside it, fit together."""
    if kind is Camera:  # whose image size is no array
        kinds = {"K": (3, 3), "T_cam_road": (4, 4), "image_size": (2,)}
        for part, shape in kinds.items():
            array = arrays[f"camera.{part}"]
            if array.shape != shape or array.dtype.kind != ("i" if len(shape) == 1 else "f"):
                raise BadFile(f"{path}: camera.{part} is {array!r:.80}; record again")
        return
    there = {
        column.name: arrays.get(f"{name}.{column.name}")
        for column in fields(kind)
        if column.name not in INNER_TABLES
    }
    require_columns(kind, there, f"{path}: {name}.")
    for column in fields(kind):
        key = f"{name}.{column.name}"
        if column.name in INNER_TABLES and any(found.startswith(f"{key}.") for found in arrays):
            must, _ = _names(key, INNER_TABLES[column.name])
            if not must <= set(arrays):
                raise BadFile(f"{path}: lacks {sorted(must - set(arrays))}; record again")
            _require_table(key, INNER_TABLES[column.name], arrays, path)


def _table(name: str, kind: Callable[..., Kind], arrays: Mapping[str, Array]) -> Kind:
    """The table of that kind, which may stand in a column of another."""
    values: dict[str, Any] = {}
    for column in fields(kind):  # type: ignore[arg-type]
        key = f"{name}.{column.name}"
        if column.name not in INNER_TABLES:
            values[column.name] = arrays.get(key)
        elif any(found.startswith(f"{key}.") for found in arrays):
            values[column.name] = _table(key, INNER_TABLES[column.name], arrays)
        else:
            values[column.name] = None
    return kind(**values)


def _camera(arrays: Mapping[str, Array], path: Path) -> Camera:
    """The exact camera. Raises BadFile for one that cannot be."""
    width, height = arrays["camera.image_size"].tolist()
    try:
        return Camera(arrays["camera.K"], (width, height), arrays["camera.T_cam_road"])
    except BadCalibration as error:
        raise BadFile(f"{path}: {error}; record again") from None
