"""The file of a learned descriptor's weights: an .npz of plain arrays, checked when it is read."""

import hashlib
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32
from numpy import ndarray as Array

from tracker.errors import BadWeights

SHIPPED_WEIGHTS = Path(__file__).parent.parent / "weights" / "appearance.npz"
WEIGHTS_FORMAT = 1
MAX_BYTES = 200_000_000  # unpacked; ours has less than one
WEIGHTS_KEYS = {"format", "weights", "mean", "grid", "hourglass", "unit", "training", "sha256"}
WEIGHTS_HINT = "reinstall mot-sim, or make the file again with mot-sim train-appearance"


class Weights(NamedTuple):
    """What a weights file holds; the fields are those of `Learned`."""

    weights: Float32[Array, "f d"]
    """See `Learned.weights`."""
    mean: Float32[Array, " f"]
    """See `Learned.mean`."""
    grid: int
    """See `Learned.grid`."""
    hourglass: str
    """See `Learned.hourglass`."""
    unit: float
    """See `Learned.unit`."""


def write_weights(path: Path, content: Weights, training: Mapping[str, object]) -> None:
    """Write a weights file; training: the configuration that it came from."""
    told = json.dumps(dict(training), sort_keys=True)
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        format=np.array(WEIGHTS_FORMAT),
        weights=content.weights,
        mean=content.mean,
        grid=np.array(content.grid),
        hourglass=np.array(content.hourglass),
        unit=np.array(content.unit),
        training=np.array(told),
        sha256=np.array(weights_digest(content)),
    )
    path.write_bytes(buffer.getvalue())


def read_weights(path: Path) -> Weights:
    """What a weights file holds. Raises BadWeights: missing, damaged, or of another kind."""
    return _read(path)[0]


def read_training(path: Path) -> dict[str, object]:
    """The configuration that a weights file came from. Raises BadWeights."""
    return _read(path)[1]


def weights_digest(content: Weights) -> str:
    """The sha256 of the numbers and of the network that they are for."""
    found = hashlib.sha256(f"{content.grid} {content.hourglass} {content.unit!r}".encode())
    for array in (content.weights, content.mean):
        found.update(np.ascontiguousarray(array, np.float32).tobytes())
    return found.hexdigest()


def _read(path: Path) -> tuple[Weights, dict[str, object]]:
    if not path.is_file():
        raise BadWeights(f"{path}: no weights of the appearance descriptor; {WEIGHTS_HINT}")
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as file:
            if sum(entry.file_size for entry in file.zip.infolist()) > MAX_BYTES:
                raise BadWeights(f"{path}: unpacks to more than {MAX_BYTES:,} bytes")
            missing = WEIGHTS_KEYS - set(file.files)
            if missing:
                raise BadWeights(
                    f"{path}: no weights of ours, {min(missing)} is missing; {WEIGHTS_HINT}"
                )
            arrays, grid = (file["weights"], file["mean"]), int(file["grid"])
            content = Weights(*arrays, grid, str(file["hourglass"]), float(file["unit"]))
            training, stated, version = str(file["training"]), str(file["sha256"]), file["format"]
        told, version = dict(json.loads(training)), int(version)
    except BadWeights:
        raise
    except Exception as error:  # NumPy lets through whatever a broken file causes
        raise BadWeights(f"{path}: damaged weights: {error}; {WEIGHTS_HINT}") from error
    if version > WEIGHTS_FORMAT:
        raise BadWeights(
            f"{path}: format {version}, this mot-sim reads up to {WEIGHTS_FORMAT}; update it"
        )
    _require_shapes(path, content)
    if weights_digest(content) != stated:
        raise BadWeights(
            f"{path}: damaged weights, their sha256 is not the stated one; {WEIGHTS_HINT}"
        )
    return content, told


def _require_shapes(path: Path, content: Weights) -> None:
    weights, mean = content.weights, content.mean
    fits = weights.ndim == 2 and mean.shape == weights.shape[:1] and content.grid >= 1
    fits &= 0.0 < content.unit < np.inf
    if not fits or weights.dtype != np.float32 or mean.dtype != np.float32:
        raise BadWeights(
            f"{path}: weights of shape {weights.shape} ({weights.dtype}) with a mean of shape "
            f"{mean.shape} ({mean.dtype}) are no descriptor's; {WEIGHTS_HINT}"
        )
    if not (np.isfinite(weights).all() and np.isfinite(mean).all()):
        raise BadWeights(f"{path}: weights that are not finite; {WEIGHTS_HINT}")
