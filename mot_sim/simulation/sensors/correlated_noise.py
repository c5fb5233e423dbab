"""Correlated noise: normal numbers with a chosen autocorrelation, and events in bursts."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import ndtr

from mot_sim.simulation.sensors.checks import require_rates, require_sigmas
from mot_sim.simulation.sensors.gauss_markov import (
    BLOCK_FRAMES,
    MAX_BLOCKS,
    NoiseStream,
    chain_of,
    draw_blocks,
)
from tracker.errors import BadConfig

MAX_LIVE_ROWS = 64  # rows up to which whole blocks are kept: a live step
MAX_KEPT_BLOCKS = 512  # blocks that are kept of a latent
MAX_SMOOTH_SECONDS = 60.0  # seconds; beyond, the noise of a step is lost in rounding
CONSTANT_SECONDS = 1e5  # seconds; a memory from here on is a constant of the object
FRAME_ID = -1  # the id of what belongs to a frame and to no object


@dataclass(frozen=True)
class Autocorrelation:
    """Of what a latent is made: shares of its variance, and how long each share remembers.

    The autocorrelation after t seconds is the sum of share * exp(-t / seconds); 0 seconds is
    white noise, inf a constant of the object. smooth: 1 for shares whose part is
    (1 + t / seconds) * exp(-t / seconds) instead, which hardly change between frames and then
    do; none given: no share is. Nothing in it depends on the frame rate.
    """

    shares: tuple[float, ...] = (1.0,)
    seconds: tuple[float, ...] = (0.0,)
    smooth: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        require_rates("memory shares, smooth", *self.shares, *self.smooth)
        require_sigmas("memory seconds", *(min(tau, CONSTANT_SECONDS) for tau in self.seconds))
        if len(self.shares) != len(self.seconds) or abs(sum(self.shares) - 1.0) > 1e-3:
            raise BadConfig(
                f"memory {self.shares} over {self.seconds} s: as many shares as times, sum 1"
            )
        if len(self.smooth) not in (0, len(self.shares)) or not set(self.smooth) <= {0.0, 1.0}:
            raise BadConfig(f"memory smooth {self.smooth}: 0 or 1 for each share, or none")
        if any(smooth and tau > MAX_SMOOTH_SECONDS for _, tau, smooth in self.parts):
            raise BadConfig(
                f"memory {self.seconds} s: smooth ones last at most {MAX_SMOOTH_SECONDS:g} s"
            )

    @property
    def parts(self) -> list[tuple[float, float, bool]]:
        """Share, seconds and smoothness of each part."""
        smooth = self.smooth or (0.0,) * len(self.shares)
        return [
            (share, tau, kind > 0.0)
            for share, tau, kind in zip(self.shares, self.seconds, smooth, strict=True)
        ]

    def slower(self, factor: float) -> "Autocorrelation":
        """The same mixture with all times so many times as long."""
        ends = [MAX_SMOOTH_SECONDS if smooth else np.inf for _, _, smooth in self.parts]
        seconds = [
            round(min(tau * factor, end), 4) for tau, end in zip(self.seconds, ends, strict=True)
        ]
        return replace(self, seconds=tuple(seconds))

    def correlation(self, seconds: float) -> float:
        """The autocorrelation after so many seconds."""
        return sum(
            share * correlation_after(seconds, tau, smooth) for share, tau, smooth in self.parts
        )


def correlation_after(seconds: float, tau: float, smooth: bool) -> float:
    """What a part of a memory has left after so many seconds."""
    if tau >= CONSTANT_SECONDS:
        return 1.0
    a = seconds / max(tau, 1e-9)
    return float(np.exp(-a) * (1.0 + a if smooth else 1.0))


WHITE = Autocorrelation()
NoiseRequest = tuple[
    tuple[str, tuple[Autocorrelation, ...]], ...
]  # effects, and the memory of each column


def correlated_normals(
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    memory: Autocorrelation,
    step: float,
    columns: int = 1,
) -> Float[Array, "n {columns}"]:
    """Standard normal numbers that keep their object's past; step: seconds between frames.

    A row depends on (seed, effect, id, frame) alone: not on which other rows are asked for, nor
    on gaps. Frames count from 0. Columns are independent of each other.
    """
    return correlated_normal_columns(seed, effect, ids, frames, (memory,) * columns, step)


def correlated_normal_columns(
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    memories: tuple[Autocorrelation, ...],
    step: float,
) -> Float[Array, "n k"]:
    """The same, a column a memory: one call for all of an effect costs what one column costs."""
    if not len(ids):
        return np.zeros((0, len(memories)))
    pieces = ids * MAX_BLOCKS + frames // BLOCK_FRAMES
    if len(ids) > MAX_LIVE_ROWS:
        every, piece = np.unique(pieces, return_inverse=True)
        return _blocks(seed, every, ((effect, memories),), step)[0][piece, frames % BLOCK_FRAMES]
    # A live step asks for the same blocks again and again: they are kept, which changes no number.
    store = _store(seed, effect, memories, step)
    wanted, at = pieces.tolist(), (frames % BLOCK_FRAMES).tolist()
    try:
        rows = [store[piece][k] for piece, k in zip(wanted, at, strict=True)]
    except KeyError:
        _fetch(seed, wanted, ((effect, memories),), step)
        rows = [store[piece][k] for piece, k in zip(wanted, at, strict=True)]
    return np.array(rows)


def prefetch_draws(
    seed: int, ids: Int[Array, " n"], frames: Int[Array, " n"], wanted: NoiseRequest, step: float
) -> None:
    """For a live step: draws what several effects will ask for at once, which saves time only."""
    if 0 < len(ids) <= MAX_LIVE_ROWS and wanted:
        _fetch(seed, (ids * MAX_BLOCKS + frames // BLOCK_FRAMES).tolist(), wanted, step)


def _fetch(seed: int, pieces: list[int], wanted: NoiseRequest, step: float) -> None:
    """Puts the blocks that are not kept yet with those that are."""
    stores = [_store(seed, effect, memories, step) for effect, memories in wanted]
    unknown = {piece for piece in pieces for store in stores if piece not in store}
    if not unknown:
        return
    for store in stores:
        if len(store) > MAX_KEPT_BLOCKS:
            store.clear()
            unknown = set(pieces)
    new = sorted(unknown)
    for store, blocks in zip(stores, _blocks(seed, np.array(new), wanted, step), strict=True):
        store.update(zip(new, blocks, strict=True))


def _blocks(
    seed: int, pieces: Int[Array, " p"], wanted: NoiseRequest, step: float
) -> list[Float[Array, "p b _"]]:
    """All frames of some blocks for each effect; a piece is id * FAR + block."""
    plans = [_plan(effect, memories, step) for effect, memories in wanted]
    result = []
    for plan, drawn in zip(
        plans, draw_blocks(seed, pieces, tuple(plan.stream for plan in plans)), strict=True
    ):
        total = np.zeros((len(pieces), BLOCK_FRAMES, plan.columns))
        for number, (column, weight) in enumerate(plan.moving):
            total[:, :, column] += weight * drawn.path[:, :, number]
        for number, (column, weight) in enumerate(plan.fixed):
            total[:, :, column] += weight * drawn.constants[:, None, number]
        for number, (column, weight) in enumerate(plan.white):
            total[:, :, column] += weight * drawn.white[:, :, number]
        result.append(total)
    return result


@dataclass(frozen=True)
class MixingPlan:
    """How memories are made of what a stream draws.

    Of each process, constant and white number: the column that it goes to, and its weight.
    """

    stream: NoiseStream
    columns: int
    moving: list[tuple[int, float]]
    fixed: list[tuple[int, float]]
    white: list[tuple[int, float]]


@lru_cache(maxsize=256)
def _plan(effect: str, memories: tuple[Autocorrelation, ...], step: float) -> MixingPlan:
    moving, fixed, white = [], [], []
    for column, memory in enumerate(memories):
        for share, tau, smooth in memory.parts:
            where = column, float(np.sqrt(share))
            if share == 0.0:
                continue
            if tau >= CONSTANT_SECONDS:
                fixed.append(where)
            elif tau == 0.0:
                white.append(where)
            else:
                moving.append((where, (step / tau, smooth)))
    chain, order = chain_of([part for _, part in moving])
    stream = NoiseStream(effect, chain, len(fixed), len(white))
    return MixingPlan(stream, len(memories), [moving[k][0] for k in order], fixed, white)


@lru_cache(maxsize=256)
def _store(
    seed: int, effect: str, memories: tuple[Autocorrelation, ...], step: float
) -> dict[int, Float[Array, "b k"]]:
    """Blocks of latents by piece."""
    return {}


def with_frame_noise(
    own: Float[Array, " n"],
    seed: int,
    effect: str,
    frames: Int[Array, " n"],
    shared: float,
    seconds: float,
    step: float,
) -> Float[Array, " n"]:
    """Latents of which a share of the variance is the frame's and lasts some seconds."""
    if shared == 0.0:
        return own
    every, row = np.unique(frames, return_inverse=True)
    nobody = np.full_like(every, FRAME_ID)
    common = correlated_normals(
        seed, f"{effect}/frame", nobody, every, Autocorrelation((1.0,), (seconds,)), step
    )
    return np.sqrt(1.0 - shared) * own + np.sqrt(shared) * common[row, 0]


def bursts(
    rates: Float[Array, " n"],
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    memory: Autocorrelation,
    step: float,
) -> Bool[Array, " n"]:
    """Where the event happens; no rate, no event. A higher rate has the same events and more.

    The marginal rate is exact whatever the memory, also while the rate varies.
    """
    happens = np.zeros(len(ids), bool)
    possible = np.flatnonzero(rates > 0.0)
    if len(possible):
        x = correlated_normals(seed, effect, ids[possible], frames[possible], memory, step)[:, 0]
        happens[possible] = ndtr(x) < rates[possible]
    return happens
