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
    draw_blocks,
    processes_of,
)
from tracker.errors import BadConfig

MAX_LIVE_ROWS = 64  # rows up to which whole blocks are kept: a live step
MAX_KEPT_BLOCKS = 512  # of one effect
MAX_SMOOTH_SECONDS = 60.0  # beyond, the noise of a step is lost in rounding
CONSTANT_SECONDS = 1e5  # a part that lasts so long is a constant of the object
FRAME_ID = -1  # the id of what belongs to a frame and to no object


@dataclass(frozen=True)
class Autocorrelation:
    """How noise is correlated over time: shares of its variance, and how long each share lasts.

    The autocorrelation after t seconds is the sum of share * exp(-t / seconds). Nothing in it
    depends on the frame rate.
    """

    shares: tuple[float, ...] = (1.0,)
    """Share of the variance of each part, 0 to 1; their sum is 1."""
    seconds: tuple[float, ...] = (0.0,)
    """How long each part lasts, >= 0: 0 is white noise, inf a constant of the object; more:
    slower."""
    smooth: tuple[float, ...] = ()
    """1: the part follows (1 + t / seconds) * exp(-t / seconds) instead, which hardly changes
    between frames, at most 60 s long; 0: it does not; empty: none does."""

    def __post_init__(self) -> None:
        require_rates("autocorrelation shares, smooth", *self.shares, *self.smooth)
        require_sigmas(
            "autocorrelation seconds", *(min(tau, CONSTANT_SECONDS) for tau in self.seconds)
        )
        if len(self.shares) != len(self.seconds) or abs(sum(self.shares) - 1.0) > 1e-3:
            raise BadConfig(
                f"autocorrelation {self.shares} over {self.seconds} s: as many shares as times, "
                "sum 1"
            )
        if len(self.smooth) not in (0, len(self.shares)) or not set(self.smooth) <= {0.0, 1.0}:
            raise BadConfig(f"autocorrelation smooth {self.smooth}: 0 or 1 for each share, or none")
        if any(smooth and tau > MAX_SMOOTH_SECONDS for _, tau, smooth in self.parts):
            raise BadConfig(
                f"autocorrelation {self.seconds} s: smooth ones last at most "
                f"{MAX_SMOOTH_SECONDS:g} s"
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
        """The same mixture with all times multiplied by a factor."""
        ends = [MAX_SMOOTH_SECONDS if smooth else np.inf for _, _, smooth in self.parts]
        seconds = [
            round(min(tau * factor, end), 4) for tau, end in zip(self.seconds, ends, strict=True)
        ]
        return replace(self, seconds=tuple(seconds))

    def correlation(self, seconds: float) -> float:
        """The autocorrelation after some seconds."""
        return sum(
            share * correlation_after(seconds, tau, smooth) for share, tau, smooth in self.parts
        )


def correlation_after(seconds: float, tau: float, smooth: bool) -> float:
    """The correlation of one part after some seconds; tau: how long it lasts."""
    if tau >= CONSTANT_SECONDS:
        return 1.0
    a = seconds / max(tau, 1e-9)
    return float(np.exp(-a) * (1.0 + a if smooth else 1.0))


# Names of effects, and the autocorrelation of each of their columns.
NoiseRequest = tuple[tuple[str, tuple[Autocorrelation, ...]], ...]


def correlated_normals(
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    autocorrelation: Autocorrelation,
    step: float,
    columns: int = 1,
) -> Float[Array, "n {columns}"]:
    """Standard normal numbers that keep their object's past; step: seconds between frames.

    A row depends on (seed, effect, id, frame) alone: not on which other rows are asked for, nor
    on gaps. Frames count from 0. Columns are independent of each other.
    """
    return correlated_normal_columns(seed, effect, ids, frames, (autocorrelation,) * columns, step)


def correlated_normal_columns(
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    autocorrelations: tuple[Autocorrelation, ...],
    step: float,
) -> Float[Array, "n k"]:
    """The same, a column per autocorrelation: all columns of an effect cost what one does."""
    if not len(ids):
        return np.zeros((0, len(autocorrelations)))
    pieces, at = _pieces(ids, frames), frames % BLOCK_FRAMES
    request = ((effect, autocorrelations),)
    if len(ids) > MAX_LIVE_ROWS:
        every, row = np.unique(pieces, return_inverse=True)
        return _recent_blocks(seed, every.tobytes(), request, step)[row, at]
    # A live step asks for the same blocks again and again: they are kept, which changes no number.
    kept = _kept_blocks(seed, effect, autocorrelations, step)
    wanted = list(zip(pieces.tolist(), at.tolist(), strict=True))
    try:
        rows = [kept[piece][k] for piece, k in wanted]
    except KeyError:
        _keep(seed, pieces.tolist(), request, step)
        rows = [kept[piece][k] for piece, k in wanted]
    return np.array(rows)


def prefetch_draws(
    seed: int, ids: Int[Array, " n"], frames: Int[Array, " n"], request: NoiseRequest, step: float
) -> None:
    """For a live step: draw what several effects will ask for at once, which only saves time."""
    if 0 < len(ids) <= MAX_LIVE_ROWS and request:
        _keep(seed, _pieces(ids, frames).tolist(), request, step)


def _pieces(ids: Int[Array, " n"], frames: Int[Array, " n"]) -> Int[Array, " n"]:
    """One number for an object and a block of frames."""
    return ids * MAX_BLOCKS + frames // BLOCK_FRAMES


def _keep(seed: int, pieces: list[int], request: NoiseRequest, step: float) -> None:
    """Draw the blocks that are not kept yet, and keep them."""
    stores = [_kept_blocks(seed, effect, columns, step) for effect, columns in request]
    unknown = {piece for piece in pieces for kept in stores if piece not in kept}
    if not unknown:
        return
    for kept in stores:
        if len(kept) > MAX_KEPT_BLOCKS:
            kept.clear()
            unknown = set(pieces)
    new = sorted(unknown)
    for kept, blocks in zip(stores, _blocks(seed, np.array(new), request, step), strict=True):
        kept.update(zip(new, blocks, strict=True))


@lru_cache(maxsize=256)
def _kept_blocks(
    seed: int, effect: str, autocorrelations: tuple[Autocorrelation, ...], step: float
) -> dict[int, Float[Array, "b k"]]:
    """The blocks of an effect that are kept, by piece; empty at first."""
    return {}


@dataclass(frozen=True)
class MixingPlan:
    """How the columns of an effect are summed up from what a stream draws."""

    stream: NoiseStream
    """What is drawn."""
    columns: int
    """Number of columns of the effect."""
    processes: list[tuple[int, float]]
    """For each process the column that it is added to, and its weight."""
    constants: list[tuple[int, float]]
    """The same for each constant of the object."""
    white: list[tuple[int, float]]
    """The same for each column of white noise."""


@lru_cache(maxsize=256)
def _plan(effect: str, autocorrelations: tuple[Autocorrelation, ...], step: float) -> MixingPlan:
    targets, kinds, constants, white = [], [], [], []
    for column, autocorrelation in enumerate(autocorrelations):
        for share, tau, smooth in autocorrelation.parts:
            target = column, float(np.sqrt(share))
            if share == 0.0:
                continue
            if tau >= CONSTANT_SECONDS:
                constants.append(target)
            elif tau == 0.0:
                white.append(target)
            else:
                targets.append(target)
                kinds.append((step / tau, smooth))
    processes, order = processes_of(kinds)
    stream = NoiseStream(effect, processes, len(constants), len(white))
    return MixingPlan(stream, len(autocorrelations), [targets[k] for k in order], constants, white)


def _blocks(
    seed: int, pieces: Int[Array, " p"], request: NoiseRequest, step: float
) -> list[Float[Array, "p b _"]]:
    """All frames of some blocks, for each effect."""
    plans = [_plan(effect, columns, step) for effect, columns in request]
    drawn_blocks = draw_blocks(seed, pieces, tuple(plan.stream for plan in plans))
    found = []
    for plan, drawn in zip(plans, drawn_blocks, strict=True):
        total = np.zeros((len(pieces), BLOCK_FRAMES, plan.columns))
        for number, (column, weight) in enumerate(plan.processes):
            total[:, :, column] += weight * drawn.path[:, :, number]
        for number, (column, weight) in enumerate(plan.constants):
            total[:, :, column] += weight * drawn.constants[:, None, number]
        for number, (column, weight) in enumerate(plan.white):
            total[:, :, column] += weight * drawn.white[:, :, number]
        found.append(total)
    return found


@lru_cache(maxsize=32)  # a sweep asks for a run's noise again at each level of it
def _recent_blocks(
    seed: int, pieces: bytes, request: NoiseRequest, step: float
) -> Float[Array, "p b _"]:
    """All frames of some blocks of one effect."""
    return _blocks(seed, np.frombuffer(pieces, np.int64), request, step)[0]


def with_frame_noise(
    own: Float[Array, " n"],
    seed: int,
    effect: str,
    frames: Int[Array, " n"],
    shared: float,
    seconds: float,
    step: float,
) -> Float[Array, " n"]:
    """Normal numbers, a share of whose variance all rows of a frame have in common for seconds."""
    if shared == 0.0:
        return own
    every, row = np.unique(frames, return_inverse=True)
    common = correlated_normals(
        seed,
        f"{effect}/frame",
        np.full_like(every, FRAME_ID),
        every,
        Autocorrelation((1.0,), (seconds,)),
        step,
    )
    return np.sqrt(1.0 - shared) * own + np.sqrt(shared) * common[row, 0]


def bursts(
    rates: Float[Array, " n"],
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    autocorrelation: Autocorrelation,
    step: float,
) -> Bool[Array, " n"]:
    """Where the event happens; no rate, no event. A higher rate has the same events and more.

    The marginal rate is exact whatever the autocorrelation, also while the rate varies.
    """
    happens = np.zeros(len(ids), bool)
    possible = np.flatnonzero(rates > 0.0)
    if len(possible):
        x = correlated_normals(
            seed, effect, ids[possible], frames[possible], autocorrelation, step
        )[:, 0]
        happens[possible] = ndtr(x) < rates[possible]
    return happens
