"""Noise that remembers: stationary AR(1) latents over arrays, each a function of its key alone."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array
from scipy.signal import lfilter

from mot_sim import draws
from mot_sim.sensors.checks import require_rates, require_sigmas
from tracker.errors import BadConfig

BLOCK = 32  # frames between the anchors of a latent; what is drawn for one live step
FAR = 1 << 22  # more blocks than any drive has (155 days at 10 Hz)
FEW = 64  # pieces up to which answers are kept
LONGEST = 1e5  # seconds; a memory from here on is a constant of the object


@dataclass(frozen=True)
class Memory:
    """Of what a latent is made: shares of its variance, and how long each share remembers.

    The autocorrelation after t seconds is sum of share * exp(-t / seconds); 0 seconds is white
    noise, inf a constant of the object. Nothing in it depends on the frame rate.
    """

    shares: tuple[float, ...] = (1.0,)
    seconds: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        require_rates("memory shares", *self.shares)
        require_sigmas("memory seconds", *(min(tau, LONGEST) for tau in self.seconds))
        if len(self.shares) != len(self.seconds) or abs(sum(self.shares) - 1.0) > 1e-3:
            raise BadConfig(
                f"memory {self.shares} over {self.seconds} s: as many shares as times, sum 1"
            )

    def correlation(self, seconds: float) -> float:
        """The autocorrelation after so many seconds."""
        kept = [
            1.0 if t >= LONGEST else float(np.exp(-seconds / max(t, 1e-9))) for t in self.seconds
        ]
        return sum(share * part for share, part in zip(self.shares, kept, strict=True))


WHITE = Memory()


def latent(
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    memory: Memory,
    step: float,
    columns: int = 1,
) -> Float[Array, "n {columns}"]:
    """Standard normal numbers that keep their object's past; step: seconds between frames.

    A row depends on (seed, effect, id, frame) alone: not on which other rows are asked for, nor
    on gaps. Frames count from 0. Columns are independent of each other.
    """
    total = np.zeros((len(ids), columns))
    for number, (share, tau) in enumerate(zip(memory.shares, memory.seconds, strict=True)):
        name = f"{effect}/{number}"
        if share == 0.0 or not len(ids):
            continue
        if tau >= LONGEST:
            part = draws.normal(seed, name, ids, np.zeros_like(frames), columns)
        elif tau == 0.0:
            part = draws.normal(seed, name, ids, frames, columns)
        else:
            part = _remembering(seed, name, ids, frames, float(np.exp(-step / tau)), columns)
        total += np.sqrt(share) * part
    return total


def _remembering(
    seed: int,
    name: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    phi: float,
    columns: int,
) -> Float[Array, "n {columns}"]:
    """x_t = phi x_(t-1) + sqrt(1 - phi^2) e_t, exactly stationary, as a function of the key.

    Every BLOCK frames stands an anchor; the anchors of an object are an AR(1) with phi^BLOCK
    from frame 0 on. Between two anchors runs the recursion, pinned to the second one by the
    conditional mean of a Gaussian (an Ornstein-Uhlenbeck bridge), so that the whole is AR(1).
    """
    code = ids * FAR + frames // BLOCK
    pieces, piece = np.unique(code, return_inverse=True)
    if len(pieces) <= FEW:  # a live step asks for the same pieces again and again
        paths = _kept_paths(seed, name, tuple(pieces.tolist()), phi, columns)
    else:
        paths = _paths(seed, name, pieces, phi, columns)
    return paths[piece, frames % BLOCK]


def _paths(
    seed: int, name: str, pieces: Int[Array, " p"], phi: float, columns: int
) -> Float[Array, "p b {columns}"]:
    """All frames of some blocks; a piece is id * FAR + block."""
    owner_ids, block = pieces // FAR, pieces % FAR
    objects, owner = np.unique(owner_ids, return_inverse=True)
    last = int(block.max()) + 2
    jump = phi**BLOCK
    anchors = draws.normal(
        seed, f"{name}/anchor", np.repeat(objects, last), np.tile(np.arange(last), len(objects)),
        columns,
    ).reshape(len(objects), last, columns)  # fmt: skip
    anchors[:, 1:] *= np.sqrt(1.0 - jump**2)
    anchors = lfilter([1.0], [1.0, -jump], anchors, axis=1)
    steps = draws.normal(
        seed, f"{name}/step", np.repeat(owner_ids, BLOCK),
        (block[:, None] * BLOCK + np.arange(1, BLOCK + 1)).ravel(), columns,
    ).reshape(len(pieces), BLOCK, columns)  # fmt: skip
    path = lfilter([np.sqrt(1.0 - phi**2)], [1.0, -phi], steps, axis=1)  # from 0 at the anchor
    start, end = anchors[owner, block], anchors[owner, block + 1]
    k = np.arange(BLOCK)
    free = np.concatenate((np.zeros_like(start)[:, None], path[:, :-1]), axis=1)
    free += (phi**k)[None, :, None] * start[:, None]
    missing = end - (path[:, -1] + jump * start)
    pull = phi ** (BLOCK - k) * (1.0 - phi ** (2 * k)) / (1.0 - phi ** (2 * BLOCK))
    return free + pull[None, :, None] * missing[:, None]


@lru_cache(maxsize=1024)
def _kept_paths(
    seed: int, name: str, pieces: tuple[int, ...], phi: float, columns: int
) -> Float[Array, "p b {columns}"]:
    """The same for few pieces; the newest answers are kept, which changes no number."""
    return _paths(seed, name, np.array(pieces), phi, columns)
