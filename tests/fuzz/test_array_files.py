"""Every reader of npz files: damaged ones, forged ones with a right checksum, and pickles."""

import json
from contextlib import nullcontext
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from random import Random
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
from numpy import ndarray as Array

from mot_sim.files.array_files import HEAD_ENTRY, checksum
from mot_sim.simulation.episodes import EpisodeFiles, read_episode, record_episode
from mot_sim.simulation.traffic import RecordedTraffic
from tests.fuzz.door import fuzz
from tests.fuzz.mutations import spoiled_bytes, spoiled_json
from tests.mot_sim.simulation.episodes.small import small
from tracker.descriptors import Learned, Weights, write_weights
from tracker.errors import TrackingError
from tracker.shape import load_prior, save_prior

OUR_HEAD, METADATA = HEAD_ENTRY, "metadata"
STRANGE = (
    np.zeros(0), np.zeros((0, 4)), np.array(3.0), np.full((3, 3), np.nan), np.zeros(10**5),
    np.array(["x", "y"]), np.array([True]), np.array(1 + 2j), np.arange(5),
    np.array("2020-01-01", "M8"),
    np.array([-1, 2**62]), np.full(4, np.inf), np.array([1e308]), np.zeros((1, 1, 1, 1)),
    np.array(b"x"),
)  # fmt: skip


@lru_cache(maxsize=8)
def held(good: bytes) -> dict[str, Array]:
    """The arrays of an npz file."""
    with np.load(BytesIO(good), allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def packed(arrays: dict[str, Array]) -> bytes:
    """An npz file with these arrays; a head of ours gets their checksum."""
    if OUR_HEAD in arrays:
        rest = {name: array for name, array in arrays.items() if name != OUR_HEAD}
        head = {**json.loads(str(arrays[OUR_HEAD])), "sha256": checksum(rest)}
        arrays = {OUR_HEAD: np.array(json.dumps(head)), **rest}
    file = BytesIO()
    named: dict[str, Any] = arrays
    np.savez(file, **named)
    return file.getvalue()


def forged(good: bytes, rng: Random) -> bytes:
    """The file with some of its arrays changed and all checksums right, or with spoiled bytes."""
    if rng.random() < 0.3:
        return spoiled_bytes(good, rng)
    arrays = dict(held(good))
    metadata = str(arrays.get(METADATA, "")).encode()
    for _ in range(rng.randint(1, 3)):
        name = rng.choice([name for name in arrays if name != OUR_HEAD])
        if name == METADATA and rng.random() < 0.9:
            told = spoiled_json(metadata, rng).decode(errors="replace")
            arrays[name] = np.array(told.replace("\x00", ""))
        else:
            arrays = changed(arrays, name, rng)
    return packed(arrays)


def changed(arrays: dict[str, Array], name: str, rng: Random) -> dict[str, Array]:
    """The arrays with one of them of another content, shape, type or name, or left out."""
    array, kind = arrays[name], rng.randrange(9)
    new = rng.choice((*STRANGE, *arrays.values()))
    if kind == 0 and len(arrays) > 1:
        return {key: value for key, value in arrays.items() if key != name}
    if kind == 1:
        return {**arrays, "../../" + name: array}
    if kind == 2 and array.ndim:
        new = array[: rng.randint(0, len(array))]
    elif kind == 3 and array.ndim:
        new = np.concatenate((array, array[:1]))
    elif kind == 4 and array.dtype.kind in "fiub":
        new = array.astype(rng.choice(("f4", "i4", "u8", "c16", "?", "U3", "f2")))
    elif kind == 5:
        new = array.T if array.ndim > 1 else array[None]
    elif kind > 5 and array.size and array.dtype.kind in "fi":
        new = array.copy()
        odd = [0, -1, 7, 2**40] if array.dtype.kind == "i" else [np.nan, np.inf, -1e308, 1e6, 0.0]
        new.flat[rng.randrange(array.size)] = np.array(rng.choice(odd)).astype(new.dtype)
    return arrays | {name: new}


@pytest.fixture(scope="module")
def episode(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The extra file of a small episode."""
    places = EpisodeFiles(tmp_path_factory.mktemp("episode"), "0000")
    record_episode(small(frames=2), 3, places)
    return packed(held(places.extra.read_bytes()))


@pytest.fixture(scope="module")
def traffic(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A small recording."""
    root = tmp_path_factory.mktemp("traffic")
    record_episode(small(frames=3), 3, EpisodeFiles(root, "0000"))
    read_episode(root).traffic.save(root / "traffic.npz")
    return packed(held((root / "traffic.npz").read_bytes()))


@pytest.mark.filterwarnings("ignore:overflow encountered in cast")  # of what is forged here
@pytest.mark.filterwarnings("ignore:invalid value encountered in cast")
def test_a_forged_episode_is_read_or_refused(episode: bytes, folder: Path) -> None:
    root = folder / "tree"
    (root / "training/extra").mkdir(parents=True)

    def read(_: Path) -> None:
        stored = read_episode(root)
        assert len(stored.truth) <= len(stored.exact.tracks)
        for frame in stored:
            assert np.isfinite(frame.detections.boxes).all()

    fuzz(root / "training/extra/0000.npz", episode, forged, read)


@pytest.mark.filterwarnings("ignore:overflow encountered in cast")
@pytest.mark.filterwarnings("ignore:invalid value encountered in cast")
def test_forged_traffic_is_replayed_or_refused(traffic: bytes, folder: Path) -> None:
    fuzz(folder / "traffic.npz", traffic, forged, lambda path: RecordedTraffic.load(path).states)


def weights_file(folder: Path) -> bytes:
    """A small file of a descriptor's weights."""
    rng = np.random.default_rng(0)
    numbers = rng.normal(size=(6, 2)).astype(np.float32)
    made = Weights(numbers, numbers[:, 0].copy(), 2, "0" * 64, 1.5)
    write_weights(folder / "weights.npz", made, {"seed": 1})
    return (folder / "weights.npz").read_bytes()


@pytest.mark.filterwarnings("ignore:overflow encountered in cast")
@pytest.mark.filterwarnings("ignore:invalid value encountered in cast")
@pytest.mark.parametrize("what", ["prior", "weights"])
def test_a_forged_prior_or_weights_are_read_or_refused(what: str, folder: Path) -> None:
    path = folder / f"{what}.npz"
    if what == "prior":
        save_prior(load_prior(), path)
        fuzz(path, path.read_bytes(), forged, load_prior)
    else:
        fuzz(path, weights_file(folder), forged, Learned.load)


class Bomb:
    """Leaves a mark where it is unpickled."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return (Path.touch, (self.mark,))


@pytest.mark.parametrize("column", ["traffic.ego", METADATA, OUR_HEAD, "one more"])
def test_a_pickle_in_an_episode_is_never_loaded(episode: bytes, column: str, folder: Path) -> None:
    root, mark = folder, folder / "mark"
    (root / "training/extra").mkdir(parents=True)
    array = np.empty(1, object)
    array[0] = Bomb(mark)
    np.save(folder / "object.npy", array, allow_pickle=True)
    twice = column in held(episode)
    warned = pytest.warns(UserWarning, match="Duplicate") if twice else nullcontext()
    with warned, ZipFile(root / "training/extra/0000.npz", "w") as archive:
        for name, good in held(episode).items():
            plain = BytesIO()
            np.save(plain, good)
            archive.writestr(f"{name}.npy", plain.getvalue())
        archive.writestr(f"{column}.npy", (folder / "object.npy").read_bytes())
    with pytest.raises(TrackingError):
        read_episode(root)
    assert not mark.exists()
    np.load(folder / "object.npy", allow_pickle=True)  # the bomb is a real one
    assert mark.exists()


def test_a_bare_pickle_is_no_array_file(folder: Path) -> None:
    import pickle

    path, mark = folder / "0000.npz", folder / "mark"
    path.write_bytes(pickle.dumps(Bomb(mark)))
    for read in (RecordedTraffic.load, load_prior, Learned.load):
        with pytest.raises(TrackingError):
            read(path)
    assert not mark.exists()
