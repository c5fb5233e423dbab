"""Named arrays in one file: written whole, with version and SHA-256, and read with suspicion."""

import json
import zipfile
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy import ndarray as Array

from mot_sim.files.documents import parse_json
from mot_sim.files.writing import whole_file
from tracker.errors import BadFile

HEAD_ENTRY = "head"
MAX_BYTES = 500_000_000  # unpacked; an hour of a full road has 50 MB
PACKING = 1  # zlib's level: fast
SAMPLED_BYTES, PACKED_SHARE = 65536, 0.7  # of an array, to find out whether it gets smaller
TEXT_COLUMNS = {"kinds", "bodies", "paints"}  # the columns that hold text


@dataclass(frozen=True)
class ArrayFormat:
    """A kind of npz file."""

    holds: str
    """What is in it, as errors name it: `recorded traffic`."""
    version: int
    """Version of its content; files of another one are refused."""
    cure: str = "record again"
    """What errors advise for a file that is bad."""

    def write(self, path: Path, arrays: Mapping[str, Array]) -> None:
        """Write the arrays, their checksum and the version, as a whole or not at all.

        The same arrays give the same bytes. Raises BadOutput.
        """
        head = {"holds": self.holds, "version": self.version, "sha256": checksum(arrays)}
        with whole_file(path) as half, half.open("wb") as file:
            write_npz(file, {HEAD_ENTRY: np.array(json.dumps(head)), **arrays})

    def read(
        self,
        path: Path,
        needed: Iterable[str],
        optional: Iterable[str] = (),
        former: Mapping[str, str] = {},
    ) -> dict[str, Array]:
        """The arrays that `write` wrote; BadFile for any other file, naming it and the cure.

        needed: names that the file must have. optional: others that it may have. former: names
        of earlier versions, which may stand for these; the arrays keep the names of the file.
        """
        arrays = self._load(path)
        told = self._head(arrays.pop(HEAD_ENTRY, None), path)
        names = {n if former.get(n) in arrays else former.get(n, n) for n in arrays}
        needed = set(needed)
        lacks, strange = needed - names, names - needed - set(optional)
        if lacks or strange:
            wrong = f"lacks {sorted(lacks)}" if lacks else f"has {sorted(strange)}"
            raise BadFile(f"{path}: not {self.holds}: it {wrong}; {self.cure}")
        if checksum(arrays) != told:
            raise BadFile(f"{path}: its arrays do not have the SHA-256 {told}; {self.cure}")
        return arrays

    def _load(self, path: Path) -> dict[str, Array]:
        """All arrays of an npz file; BadFile if it is none."""
        try:
            require_size(path)
            with np.load(BytesIO(path.read_bytes()), allow_pickle=False) as archive:
                return {name: plain_array(archive[name], name) for name in archive.files}
        except FileNotFoundError:
            raise BadFile(f"{path}: no such file; record first") from None
        except BadFile:
            raise
        except zipfile.BadZipFile as error:
            what = "damaged" if path.read_bytes().startswith(b"PK") else f"not {self.holds}"
            raise BadFile(f"{path}: {what}: {error}; {self.cure}") from None
        except (zlib.error, NotImplementedError, RuntimeError) as error:
            raise BadFile(f"{path}: damaged: {error}; {self.cure}") from None
        except Exception as error:  # NumPy lets through whatever a broken file causes
            told = str(error) or type(error).__name__
            raise BadFile(f"{path}: not {self.holds}: {told}; {self.cure}") from error

    def _head(self, head: Array | None, path: Path) -> str:
        """The checksum that the file tells; BadFile for another kind of file or version."""
        try:
            told = parse_json(str(head), f"{path}")
            holds, version = told.get("holds", self.holds), told["version"]
            promised = str(told["sha256"])
        except (BadFile, KeyError, TypeError, AttributeError):
            raise BadFile(f"{path}: not {self.holds}: its head is {head}; {self.cure}") from None
        if holds != self.holds:
            raise BadFile(f"{path}: holds {holds}, not {self.holds}; {self.cure}")
        if version != self.version:
            newer = isinstance(version, int) and version > self.version
            cure = f"install a newer mot-sim, or {self.cure}" if newer else self.cure
            raise BadFile(
                f"{path}: {self.holds} of version {version}, this is {self.version}: {cure}"
            )
        return promised


def write_npz(file: IO[bytes], arrays: Mapping[str, Array]) -> None:
    """Write arrays as `np.load` reads them; the same arrays give the same bytes.

    Packed quickly: numpy's own way takes twice as long for a twentieth less. The last digits of
    measured numbers do not pack, so arrays that stay large are written as they are.
    """
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=PACKING) as archive:
        for name, array in arrays.items():
            first = max(SAMPLED_BYTES // max(array.itemsize, 1), 1)
            start = np.ravel(array)[:first].tobytes()
            packs = len(zlib.compress(start, PACKING)) < PACKED_SHARE * len(start)
            entry = f"{name}.npy"
            with archive.open(
                entry if packs else zipfile.ZipInfo(entry), "w", force_zip64=True
            ) as opened:
                np.lib.format.write_array(opened, np.asanyarray(array), allow_pickle=False)


def plain_array(found: Any, name: str) -> Array:
    """An entry of an npz file. Raises ValueError for what is no array, and for half floats."""
    if not isinstance(found, Array):
        raise ValueError(f"{name} is no array")
    if found.dtype.kind == "f" and found.dtype.itemsize not in (4, 8):
        raise ValueError(f"{name} is of type {found.dtype}")  # which linear algebra does not take
    return found


def require_size(path: Path, most: int = MAX_BYTES) -> None:
    """Raise BadFile for an npz file that unpacks to more than so many bytes; unpacks nothing.

    An entry cannot hold more than the archive says: reading ends there.
    """
    with zipfile.ZipFile(path) as archive:
        size = sum(entry.file_size for entry in archive.infolist())
    if size > most:
        raise BadFile(f"{path}: unpacks to {size:,} bytes, where such files have at most {most:,}")


def checksum(arrays: Mapping[str, Array]) -> str:
    """SHA-256 of arrays: names, types, shapes and bytes, in their order."""
    digest = sha256()
    for name, array in arrays.items():
        digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def require_columns(kind: type, arrays: Mapping[str, Array | None], where: str) -> None:
    """Raise BadFile unless every array has the type and shape of its column in a dataclass.

    arrays: by the names of the columns; those of tables inside may be left out. Inside a context
    of `jaxtyping.jaxtyped` a dimension has one length in all tables, else in this one.
    """
    for column in fields(kind):
        array = arrays.get(column.name)
        if column.name not in arrays:
            continue
        fits = isinstance(array, column.type)  # type: ignore[arg-type]
        if array is not None and column.name in TEXT_COLUMNS:
            fits = fits and array.dtype.kind == "U"
        if not fits:
            found = "nothing" if array is None else f"{array.dtype} of shape {array.shape}"
            wanted = getattr(column.type, "__name__", column.type)
            raise BadFile(f"{where}{column.name} is {found}, not {wanted}; record again")
