"""Named arrays in one file."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from mot_sim.files.array_files import ArrayFormat, checksum
from tracker.descriptors.weights import read_weights
from tracker.errors import BadFile, BadOutput, BadWeights
from tracker.shape import load_prior

APPLES = ArrayFormat("apples", 2, "pick again")
ARRAYS = {"red": np.arange(3), "green": np.array(["a", "bc"])}


def test_arrays_come_back_with_their_types(tmp_path: Path) -> None:
    APPLES.write(tmp_path / "deep" / "a.npz", ARRAYS)
    read = APPLES.read(tmp_path / "deep" / "a.npz", ["red"], ["green", "blue"])
    assert list(read) == ["red", "green"]
    for name, array in ARRAYS.items():
        assert read[name].dtype == array.dtype
        assert read[name].tolist() == array.tolist()


def test_the_same_arrays_give_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.npz", "b.npz"):
        APPLES.write(tmp_path / name, ARRAYS)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_the_checksum_sees_names_types_and_shapes() -> None:
    zeros = np.zeros(4)
    others = [{"b": zeros}, {"a": zeros.reshape(2, 2)}, {"a": zeros.astype(np.int64)}, {}]
    assert checksum({"a": zeros}) not in [checksum(arrays) for arrays in others]
    assert checksum({"a": zeros}) == checksum({"a": np.zeros(8)[::2]})


def test_nothing_pickled_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez(path, red=np.array([{"a": 1}], dtype=object))
    with pytest.raises(BadFile, match=r"a\.npz: not apples: .*; pick again"):
        APPLES.read(path, ["red"])


@pytest.mark.parametrize(
    ("head", "told"),
    [
        ({"holds": "pears"}, "holds pears, not apples; pick again"),
        ({"version": 1}, "apples of version 1, this is 2: pick again"),
        ({"version": 3}, "apples of version 3, this is 2: install a newer mot-sim, or pick again"),
        ({"sha256": "0"}, "do not have the SHA-256 0; pick again"),
    ],
)
def test_other_kinds_versions_and_contents_are_told(
    tmp_path: Path, head: dict[str, object], told: str
) -> None:
    path = tmp_path / "a.npz"
    whole = {"holds": "apples", "version": 2, "sha256": checksum(ARRAYS), **head}
    np.savez(path, head=np.array(json.dumps(whole)), **ARRAYS)
    with pytest.raises(BadFile, match=told):
        APPLES.read(path, ARRAYS)


def test_a_head_that_is_no_object_is_told(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", head=np.array("[1]"), **ARRAYS)
    with pytest.raises(BadFile, match="its head is"):
        APPLES.read(tmp_path / "a.npz", ARRAYS)


def test_strange_arrays_are_named(tmp_path: Path) -> None:
    APPLES.write(tmp_path / "a.npz", ARRAYS)
    with pytest.raises(BadFile, match=r"it has \['green'\]"):
        APPLES.read(tmp_path / "a.npz", ["red"])
    with pytest.raises(BadOutput, match="cannot be written"):
        APPLES.write(tmp_path / "a.npz" / "b.npz", ARRAYS)


def test_a_file_that_unpacks_to_too_much_is_refused_before_it_is_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "bomb.npz"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("a.npy", "w") as file,
    ):
        block = bytes(1 << 20)
        for _ in range(600):
            file.write(block)
    assert path.stat().st_size < 2_000_000
    with pytest.raises(BadFile, match=r"bomb.npz: unpacks to 629,145,600 bytes"):
        ArrayFormat("a thing", 1).read(path, ["a"])
    with pytest.raises(BadFile, match="unpacks to more than"):
        load_prior(path)
    with pytest.raises(BadWeights, match="unpacks to more than"):
        read_weights(path)


def test_half_floats_and_entries_that_are_no_arrays_are_refused(tmp_path: Path) -> None:
    path, kind = tmp_path / "a.npz", ArrayFormat("a thing", 1)
    kind.write(path, {"a": np.zeros(3, np.float16)})
    with pytest.raises(BadFile, match=r"a.npz: not a thing: a is of type float16; record again"):
        kind.read(path, ["a"])
    kind.write(path, {"a": np.zeros(3)})
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("b", b"bytes")
    with pytest.raises(BadFile, match=r"a.npz: not a thing: b is no array; record again"):
        kind.read(path, ["a"])
