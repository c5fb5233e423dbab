"""Traffic recorded once into arrays, kept in one file, and replayed many times."""

import json
import os
import zipfile
import zlib
from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.traffic.world import STEP, Traffic, World
from tracker.errors import BadConfig, BadFile, BadOutput

VERSION = 1


@dataclass(frozen=True, eq=False)
class RecordedTraffic:
    """Who was where, every 0.1 s from `start` on: rows are worlds, columns are cars.

    ids: of the columns, increasing. present: whether a car was there; where not, its other
    values are NaN. size: length, height, width. z, crashed: as in `World`.
    """

    start: Float[Array, ""]
    ids: Int[Array, " n"]
    present: Bool[Array, "t n"]
    x: Float[Array, "t n"]
    y: Float[Array, "t n"]
    heading: Float[Array, "t n"]
    speed: Float[Array, "t n"]
    size: Float[Array, "t n 3"]
    ego: Float[Array, "t 3"]
    ego_size: Float[Array, "t 3"]
    z: Float[Array, "t n"] | None = None
    crashed: Bool[Array, "t n"] | None = None

    def __len__(self) -> int:
        return len(self.present)

    def world(self, index: int) -> World:
        """The world of a row; the same bits that were recorded."""
        there = self.present[index]
        return World(
            time=float(self.start) + index * STEP,
            ids=self.ids[there],
            x=self.x[index, there],
            y=self.y[index, there],
            heading=self.heading[index, there],
            speed=self.speed[index, there],
            size=self.size[index, there],
            ego=self.ego[index].copy(),
            ego_size=self.ego_size[index].copy(),
            z=None if self.z is None else self.z[index, there],
            crashed=None if self.crashed is None else self.crashed[index, there],
        )

    @property
    def checksum(self) -> str:
        """SHA-256 of all arrays: names, types, shapes and bytes, in the order of fields."""
        digest = sha256()
        for name, array in self.arrays().items():
            digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def arrays(self) -> dict[str, Any]:
        """The fields that are not None."""
        named = {column.name: getattr(self, column.name) for column in fields(self)}
        return {name: array for name, array in named.items() if array is not None}

    @classmethod
    def of(cls, worlds: Iterable[World]) -> "RecordedTraffic":
        """The recording of worlds, 0.1 s apart. Raises BadConfig for rows not in order of ids."""
        worlds = list(worlds)
        if not worlds:
            raise BadConfig("a recording of no worlds: give one or more")
        ids = np.unique(np.concatenate([world.ids for world in worlds]))
        shape = len(worlds), len(ids)
        columns = {name: np.full(shape, np.nan) for name in ("x", "y", "heading", "speed", "z")}
        size = np.full((*shape, 3), np.nan)
        present, crashed = np.zeros(shape, bool), np.zeros(shape, bool)
        for row, world in enumerate(worlds):
            if (np.diff(world.ids) <= 0).any():
                raise BadConfig(f"world {row}: ids {world.ids.tolist()} do not increase")
            at = np.searchsorted(ids, world.ids)
            present[row, at] = True
            size[row, at] = world.size
            for name, column in columns.items():
                column[row, at] = 0.0 if getattr(world, name) is None else getattr(world, name)
            crashed[row, at] = False if world.crashed is None else world.crashed
        if all(world.z is None for world in worlds):
            del columns["z"]
        return cls(
            start=np.array(worlds[0].time),
            ids=ids,
            present=present,
            size=size,
            ego=np.array([world.ego for world in worlds]),
            ego_size=np.array([world.ego_size for world in worlds]),
            crashed=None if all(world.crashed is None for world in worlds) else crashed,
            **columns,
        )

    def save(self, path: Path) -> None:
        """Write the arrays, their checksum and the version, as a whole or not at all.

        The same recording gives the same bytes. Raises BadOutput.
        """
        half = path.with_name(f".{path.name}.{os.getpid()}.half")
        head = json.dumps({"version": VERSION, "sha256": self.checksum})
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with half.open("wb") as file:
                np.savez_compressed(file, head=np.array(head), **self.arrays())
            os.replace(half, path)
        except OSError as error:
            raise BadOutput(f"{path}: cannot be written: {error.strerror}") from None
        finally:
            if half.parent.is_dir():
                half.unlink(missing_ok=True)

    @classmethod
    def load(cls, path: Path) -> "RecordedTraffic":
        """Read what `save` wrote. Raises BadFile for any other file, naming it."""
        arrays = _read_arrays(path)
        version, told = _read_head(arrays.pop("head", None), path)
        if version != VERSION:
            raise BadFile(f"{path}: traffic of version {version}, this is {VERSION}: record again")
        needed = {column.name for column in fields(cls)}
        lacks, strange = needed - {"z", "crashed"} - set(arrays), set(arrays) - needed
        if lacks or strange:
            wrong = f"lacks {sorted(lacks)}" if lacks else f"has {sorted(strange)}"
            raise BadFile(f"{path}: no recorded traffic: it {wrong}; record again")
        recording = cls(**arrays)
        if recording.checksum != told:
            raise BadFile(f"{path}: its arrays do not have the SHA-256 {told}; record again")
        return recording


def _read_arrays(path: Path) -> dict[str, Array]:
    """All arrays of an npz file; BadFile if it is none."""
    try:
        with np.load(BytesIO(path.read_bytes()), allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except FileNotFoundError:
        raise BadFile(f"{path}: no such file; record the traffic first") from None
    except (OSError, ValueError, EOFError, TypeError, KeyError) as error:
        raise BadFile(f"{path}: no recorded traffic: {error}; record again") from None
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError) as error:
        raise BadFile(f"{path}: damaged: {error}; record again") from None


def _read_head(head: Array | None, path: Path) -> tuple[object, object]:
    """Version and checksum as the file tells them; BadFile if it does not."""
    try:
        told = json.loads(str(head))
        return told["version"], told["sha256"]
    except (ValueError, KeyError, TypeError):
        raise BadFile(f"{path}: no recorded traffic: its head is {head}; record again") from None


def record_traffic(traffic: Traffic, rng: np.random.Generator, seconds: float) -> RecordedTraffic:
    """The worlds of so many seconds, the first and the last included."""
    if not 0.0 <= seconds < np.inf:
        raise BadConfig(f"record {seconds:g} s of traffic: give 0 or more")
    worlds = [traffic.reset(rng)]
    worlds += [traffic.step() for _ in range(round(seconds / STEP))]
    return RecordedTraffic.of(worlds)


@dataclass(eq=False)
class Replay:
    """Traffic that does what was recorded, whatever the seed."""

    recording: RecordedTraffic
    index: int = field(default=0, init=False)

    def reset(self, rng: np.random.Generator) -> World:
        """The first world; nothing is drawn from the generator."""
        self.index = 0
        return self.recording.world(0)

    def step(self) -> World:
        """The next world. Raises BadConfig after the last one."""
        if self.index + 1 >= len(self.recording):
            raise BadConfig(
                f"the recorded traffic ends after {len(self.recording)} worlds: record a longer one"
            )
        self.index += 1
        return self.recording.world(self.index)
