"""Stationary processes cut into blocks of frames, each block a function of its key alone.

Every BLOCK frames stands an anchor; the anchors of an object are a chain of their own from frame
0 on. Between two anchors runs the recursion, pinned to the second one by the conditional mean of a
Gaussian (a bridge), so that the whole has exactly the law of the recursion. Many processes run at
once, in arrays: a live step has few objects and little time.

Rough: an AR(1), x' = phi x + noise with phi = e^-a, a the step in units of the memory. Smooth: a
critically damped process driven by white noise (Matern, 3/2), autocorrelation (1 + t) e^-t. With s
its value plus its slope, of variance 2 and covariance 1 with x: s' = phi s + noise, and
x' = phi (x + a s) + noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers

BLOCK_FRAMES = 32  # frames between the anchors of a latent; what is drawn for one live step
MAX_BLOCKS = 1 << 22  # more blocks than any drive has (155 days at 10 Hz)


@dataclass(frozen=True)
class Chain:
    """The numbers of some processes for steps of a: first the rough ones, then the smooth ones.

    rough, smooth: a of each.
    """

    rough: tuple[float, ...]
    smooth: tuple[float, ...]

    @cached_property
    def phi(self) -> Float[Array, " n"]:
        """What is left of each after one step."""
        return np.exp(-np.array(self.rough + self.smooth))

    @cached_property
    def drag(self) -> Float[Array, " m"]:
        """How the s of a smooth one moves its x in one step."""
        return np.exp(-np.array(self.smooth)) * np.array(self.smooth)

    @cached_property
    def roots(self) -> Float[Array, "4 n"]:
        """How white numbers enter: into x; and, for smooth ones, the first into s, the second."""
        roots = np.zeros((4, len(self.phi)))
        count = len(self.rough)
        roots[0, :count] = np.sqrt(-np.expm1(-2.0 * np.array(self.rough)))
        for number, a in enumerate(self.smooth, count):
            roots[:3, number] = np.linalg.cholesky(added(a))[[0, 1, 1], [0, 0, 1]]
        return roots

    @cached_property
    def pulls(self) -> Float[Array, "b 2 n"]:
        """How far the value of a frame moves with what is missing of x, and of s, at its end."""
        pulls = np.zeros((BLOCK_FRAMES, 2, len(self.phi)))
        k = np.arange(BLOCK_FRAMES)[:, None]
        a, count = np.array(self.rough), len(self.rough)
        pulls[:, 0, :count] = np.exp(-a * (BLOCK_FRAMES - k)) * np.expm1(-2.0 * a * k)
        pulls[:, 0, :count] /= np.expm1(-2.0 * a * BLOCK_FRAMES)
        for number, each in enumerate(self.smooth, count):
            ends = np.linalg.inv(added(each * BLOCK_FRAMES))
            for frame in range(1, BLOCK_FRAMES):
                left = transition(each * (BLOCK_FRAMES - frame)).T
                pulls[frame, :, number] = (added(each * frame) @ left @ ends)[0]
        return pulls

    def run(
        self, x: Float[Array, "p n"], s: Float[Array, "p m"], noise: Float[Array, "p t nm"]
    ) -> tuple[Float[Array, "p t1 n"], Float[Array, "p t1 m"]]:
        """The states from a start on, one more than there is noise."""
        count, first = len(self.phi), len(self.rough)
        steps = noise.shape[1]
        by_time = noise.swapaxes(0, 1)  # neighbours in memory are used together
        xs = np.empty((steps + 1, len(x), count))
        ss = np.empty((steps + 1, len(x), count - first))
        xs[0], ss[0] = x, s
        np.multiply(by_time[..., :count], self.roots[0], out=xs[1:])
        if count > first:
            np.multiply(by_time[..., first:count], self.roots[1, first:], out=ss[1:])
            ss[1:] += by_time[..., count:] * self.roots[2, first:]
        phi, slow, drag = self.phi, self.phi[first:], self.drag
        for t in range(steps):
            xs[t + 1] += phi * xs[t]
            if count > first:
                xs[t + 1, :, first:] += drag * ss[t]
                ss[t + 1] += slow * ss[t]
        return xs.swapaxes(0, 1), ss.swapaxes(0, 1)

    def times(self, steps: int) -> "Chain":
        """The same processes over so many steps at once."""
        return Chain(tuple(a * steps for a in self.rough), tuple(a * steps for a in self.smooth))

    @cached_property
    def far(self) -> "Chain":
        """From anchor to anchor."""
        return self.times(BLOCK_FRAMES)


def transition(a: float) -> Float[Array, "2 2"]:
    """What is expected of x and s of a smooth process after the time a."""
    return np.exp(-a) * np.array([[1.0, a], [0.0, 1.0]])


def added(a: float) -> Float[Array, "2 2"]:
    """The covariance of what noise adds to x and s of a smooth process in the time a."""
    always = np.array([[1.0, 1.0], [1.0, 2.0]])
    at = transition(a)
    return always - at @ always @ at.T


@dataclass(frozen=True)
class NoiseStream:
    """What is drawn under one name: the processes of a chain, constants and white numbers."""

    name: str
    chain: Chain
    fixed: int
    white: int

    @property
    def width(self) -> int:
        """Columns of white numbers that the chain eats in a step."""
        return len(self.chain.rough) + 2 * len(self.chain.smooth)


class DrawnBlocks(NamedTuple):
    """All frames of some blocks, constants of their objects, and white numbers."""

    path: Float[Array, "p b n"]
    constants: Float[Array, "p f"]
    white: Float[Array, "p b w"]


def draw_blocks(
    seed: int, pieces: Int[Array, " p"], streams: tuple[NoiseStream, ...]
) -> list[DrawnBlocks]:
    """The blocks of some streams, whose processes run side by side; a piece: id * FAR + block."""
    owner_ids, block = pieces // MAX_BLOCKS, pieces % MAX_BLOCKS
    objects, owner = np.unique(owner_ids, return_inverse=True)
    last = int(block.max()) + 2
    at_anchors = np.repeat(objects, last), np.tile(np.arange(last), len(objects))
    at_steps = (
        np.repeat(owner_ids, BLOCK_FRAMES),
        block[:, None] * BLOCK_FRAMES + np.arange(1, BLOCK_FRAMES + 1),
    )
    anchors, steps = [], []
    for each in streams:
        width = each.width + each.fixed
        drawn = random_numbers.normal(seed, f"{each.name}/anchor", *at_anchors, width)
        anchors.append(drawn.reshape(len(objects), last, width))
        width = each.width + each.white
        drawn = random_numbers.normal(
            seed, f"{each.name}/step", at_steps[0], at_steps[1].ravel(), width
        )
        steps.append(drawn.reshape(len(pieces), BLOCK_FRAMES, width))
    chain, order, where = side_by_side(streams)
    path = steps[0][..., :0]
    if len(order):
        path = _paths(
            chain, _noise(anchors, streams, order), _noise(steps, streams, order), owner, block
        )
    return [
        DrawnBlocks(path[..., mine], a[owner, 0, each.width :], s[..., each.width :])
        for each, mine, a, s in zip(streams, where, anchors, steps, strict=True)
    ]


def _noise(
    drawn: list[Array], streams: tuple[NoiseStream, ...], order: Array
) -> Float[Array, "p t nm"]:
    """What the chains eat, as all of them side by side want it."""
    if len(drawn) == 1:
        return drawn[0][..., : streams[0].width]
    return np.concatenate(
        [each[..., : stream.width] for each, stream in zip(drawn, streams, strict=True)], axis=-1
    )[..., order]


def _paths(
    chain: Chain,
    anchors: Float[Array, "o last nm"],
    steps: Float[Array, "p b nm"],
    owner: Int[Array, " p"],
    block: Int[Array, " p"],
) -> Float[Array, "p b n"]:
    """From anchor to anchor, then from each block's anchor to the next, pinned to it."""
    many, rough = len(chain.phi), len(chain.rough)
    first = anchors[:, 0, :many]
    slopes = first[:, rough:] + anchors[:, 0, many:]
    x, s = chain.far.run(first, slopes, anchors[:, 1:])
    xs, ss = chain.run(x[owner, block], s[owner, block], steps)
    x_off = x[owner, block + 1] - xs[:, -1]
    s_off = s[owner, block + 1] - ss[:, -1]
    path = xs[:, :-1] + chain.pulls[:, 0] * x_off[:, None]
    path[..., rough:] += chain.pulls[:, 1, rough:] * s_off[:, None]
    return path


@lru_cache(maxsize=256)
def side_by_side(
    streams: tuple[NoiseStream, ...],
) -> tuple[Chain, Int[Array, " nm"], list[Int[Array, " _"]]]:
    """One chain for all streams; the order of its white numbers; which processes are whose."""
    rough = [len(each.chain.rough) for each in streams]
    smooth = [len(each.chain.smooth) for each in streams]
    begins = np.cumsum([0] + [each.width for each in streams])[:-1]
    kinds: tuple[list[int], list[int], list[int]] = [], [], []
    for begin, r, m in zip(begins.tolist(), rough, smooth, strict=True):
        kinds[0].extend(range(begin, begin + r))
        kinds[1].extend(range(begin + r, begin + r + m))
        kinds[2].extend(range(begin + r + m, begin + r + 2 * m))
    where, r_at, m_at = [], 0, sum(rough)
    for r, m in zip(rough, smooth, strict=True):
        where.append(np.array([*range(r_at, r_at + r), *range(m_at, m_at + m)], np.int64))
        r_at, m_at = r_at + r, m_at + m
    chain = Chain(
        sum((each.chain.rough for each in streams), ()),
        sum((each.chain.smooth for each in streams), ()),
    )
    return chain, np.array(kinds[0] + kinds[1] + kinds[2], np.int64), where


def chain_of(parts: Sequence[tuple[float, bool]]) -> tuple[Chain, list[int]]:
    """The processes of some (a, whether smooth), and which part each one is."""
    rough = [number for number, (_, smooth) in enumerate(parts) if not smooth]
    smooth = [number for number, (_, smooth) in enumerate(parts) if smooth]
    chain = Chain(tuple(parts[k][0] for k in rough), tuple(parts[k][0] for k in smooth))
    return chain, rough + smooth
