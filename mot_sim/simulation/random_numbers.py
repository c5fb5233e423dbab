"""Random numbers by counter: a draw depends on its key (seed, effect, object id, frame) alone.

Whatever else is drawn, and in whatever order, the same key gives the same number: one more car
changes no other car's noise. The mixing is the finaliser of splitmix64 (Steele, Lea and Flood,
Fast splittable pseudorandom number generators, OOPSLA 2014), over whole arrays.
"""

from functools import lru_cache
from hashlib import blake2b

import numpy as np
from jaxtyping import Float, Int, UInt64
from numpy import ndarray as Array
from scipy.special import ndtri

GOLDEN = np.uint64(0x9E3779B97F4A7C15)  # 2^64 over the golden ratio: spreads neighbouring keys


def uniform(
    seed: int, effect: str, ids: Int[Array, " n"], frames: Int[Array, " n"], columns: int = 1
) -> Float[Array, "n {columns}"]:
    """Numbers in the open interval (0, 1), a row an object and frame."""
    steps = bits(seed, effect, ids, frames, columns) >> np.uint64(12)
    return (steps.astype(np.float64) + 0.5) * 2.0**-52


def normal(
    seed: int, effect: str, ids: Int[Array, " n"], frames: Int[Array, " n"], columns: int = 1
) -> Float[Array, "n {columns}"]:
    """Numbers of the standard normal distribution, a row an object and frame."""
    return ndtri(uniform(seed, effect, ids, frames, columns))


def bits(
    seed: int, effect: str, ids: Int[Array, " n"], frames: Int[Array, " n"], columns: int = 1
) -> UInt64[Array, "n {columns}"]:
    """64 random bits a draw, the same on every machine."""
    mixed = _mix(_stream_key(seed, effect) + GOLDEN * ids.astype(np.uint64))
    mixed = _mix(mixed + GOLDEN * frames.astype(np.uint64))
    return _mix(mixed[:, None] + GOLDEN * np.arange(1, columns + 1, dtype=np.uint64))


def named_stream(seed: int, name: str) -> np.random.Generator:
    """A generator for what belongs to no object: one stream a name, independent of the others."""
    return np.random.default_rng(np.random.SeedSequence(int(_stream_key(seed, name))))


def _mix(values: UInt64[Array, "*n"]) -> UInt64[Array, "*n"]:
    """Each output bit depends on every input bit; arithmetic is modulo 2^64."""
    values = (values ^ (values >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    values = (values ^ (values >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return values ^ (values >> np.uint64(31))


@lru_cache(maxsize=1024)
def _stream_key(seed: int, name: str) -> np.uint64:
    """64 bits of a seed (any integer) and a name; a cryptographic hash, so no two collide."""
    digest = blake2b(f"{seed}/{name}".encode(), digest_size=8).digest()
    return np.uint64(int.from_bytes(digest, "little"))
