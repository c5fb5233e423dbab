"""Crops on disk: a file a place, made once, checked when they are read."""

import io
import zipfile
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import numpy as np

from mot_sim.files.writing import write_bytes
from mot_sim.training.crops import Crops, make_crops
from tracker.errors import BadFile, DatasetNotFound

FIRST_HELD_OUT_SEED = 1_000_000  # seeds of places from here on are for judging only


def shard_path(folder: Path, seed: int) -> Path:
    """The file of a place."""
    return folder / f"crops_{seed:07d}.npz"


def save_crops(crops: Crops, path: Path) -> None:
    """Write crops, as a whole or not at all."""
    held = io.BytesIO()
    np.savez(held, **{column.name: getattr(crops, column.name) for column in fields(crops)})
    write_bytes(path, held.getvalue())


def load_crops(path: Path) -> Crops:
    """Read crops. Raises DatasetNotFound, and BadFile for what `save_crops` did not write."""
    if not path.is_file():
        raise DatasetNotFound(f"no crops at {path}: make them with `mot-sim train-keypoints`")
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as file:
            columns = [file[column.name] for column in fields(Crops)]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise BadFile(f"{path} holds no crops ({error}): delete it, it is made again") from error
    if len({len(column) for column in columns}) != 1:
        raise BadFile(f"{path}: columns of different lengths: delete it, it is made again")
    return Crops(*columns)


def gather_crops(
    folder: Path, first: int, count: int, tell: Callable[[str, int, int], None] | None = None
) -> Crops:
    """At least `count` crops of the places from seed `first` on; what is not there is made.

    tell: is given what is done, how much of it is there and how much there is to be.
    """
    parts: list[Crops] = []
    have, seed = 0, first
    while have < count:
        path = shard_path(folder, seed)
        if not path.is_file():
            save_crops(make_crops(seed), path)
        parts.append(load_crops(path))
        have, seed = have + len(parts[-1]), seed + 1
        if tell is not None:
            tell("crops", min(have, count), count)
    return Crops.concatenate(parts).select(slice(0, count))
