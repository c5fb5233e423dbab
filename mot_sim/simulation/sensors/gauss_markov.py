"""Stationary Gauss-Markov processes in blocks of frames, each block a function of its key alone.

Every BLOCK_FRAMES frames stands an anchor; the anchors of an object are a chain of their own from
frame 0 on. Between two anchors runs the recursion, and a bridge (the conditional mean of a
Gaussian process, given its end) moves it onto the second anchor, so that the whole has exactly
the law of the recursion. Many processes run at once, in arrays: a live step has few objects and
little time.

Rough: an AR(1) process, x' = phi x + noise with phi = e^-a; a is the step over the correlation
time. Smooth: a critically damped process driven by white noise (Matern, 3/2), autocorrelation
(1 + t) e^-t. Its state is (x, s), s its value plus its slope, of variance 2 and covariance 1 with
x: s' = phi s + noise, and x' = phi (x + a s) + noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers

BLOCK_FRAMES = 32  # frames between two anchors; what is drawn for one live step
MAX_BLOCKS = 1 << 22  # more blocks than any drive has (155 days at 10 Hz)


@dataclass(frozen=True)
class GaussMarkov:
    """Some processes for one step: first the rough ones, then the smooth ones."""

    rough: tuple[float, ...]
    """a of each rough process: the step over its correlation time."""
    smooth: tuple[float, ...]
    """a of each smooth process: the step over its correlation time."""

    @property
    def noise_width(self) -> int:
        """Columns of white noise that one step takes: one per rough, two per smooth process."""
        return len(self.rough) + 2 * len(self.smooth)

    @cached_property
    def decay(self) -> Float[Array, " n"]:
        """phi: what is left of each after one step."""
        return np.exp(-np.array(self.rough + self.smooth))

    @cached_property
    def slope_gain(self) -> Float[Array, " m"]:
        """phi a of the smooth ones: what s adds to x in one step."""
        return np.exp(-np.array(self.smooth)) * np.array(self.smooth)

    @cached_property
    def noise_cholesky(self) -> Float[Array, "3 n"]:
        """Cholesky factors of a step's noise: into x; of smooth ones both into s."""
        factors = np.zeros((3, len(self.decay)))
        count = len(self.rough)
        factors[0, :count] = np.sqrt(-np.expm1(-2.0 * np.array(self.rough)))
        for column, a in enumerate(self.smooth, count):
            factors[:, column] = np.linalg.cholesky(smooth_noise(a))[[0, 1, 1], [0, 0, 1]]
        return factors

    @cached_property
    def bridge_gains(self) -> Float[Array, "b 2 n"]:
        """How far the value of a frame moves per unit that x, and s, miss the next anchor by."""
        gains = np.zeros((BLOCK_FRAMES, 2, len(self.decay)))
        k = np.arange(BLOCK_FRAMES)[:, None]
        a, count = np.array(self.rough), len(self.rough)
        gains[:, 0, :count] = np.exp(-a * (BLOCK_FRAMES - k)) * np.expm1(-2.0 * a * k)
        gains[:, 0, :count] /= np.expm1(-2.0 * a * BLOCK_FRAMES)
        for column, each in enumerate(self.smooth, count):
            precision = np.linalg.inv(smooth_noise(each * BLOCK_FRAMES))
            for frame in range(1, BLOCK_FRAMES):
                to_end = smooth_transition(each * (BLOCK_FRAMES - frame)).T
                gains[frame, :, column] = (smooth_noise(each * frame) @ to_end @ precision)[0]
        return gains

    def run(
        self, x: Float[Array, "p n"], s: Float[Array, "p m"], noise: Float[Array, "p t nm"]
    ) -> tuple[Float[Array, "p t1 n"], Float[Array, "p t1 m"]]:
        """The states x and s from a start on, one more than there is noise."""
        count, first = len(self.decay), len(self.rough)
        steps = noise.shape[1]
        by_time = noise.swapaxes(0, 1)  # neighbours in memory are used together
        xs = np.empty((steps + 1, len(x), count))
        ss = np.empty((steps + 1, len(x), count - first))
        xs[0], ss[0] = x, s
        into_x, first_into_s, second_into_s = self.noise_cholesky
        np.multiply(by_time[..., :count], into_x, out=xs[1:])
        if count > first:
            np.multiply(by_time[..., first:count], first_into_s[first:], out=ss[1:])
            ss[1:] += by_time[..., count:] * second_into_s[first:]
        decay, smooth_decay, slope_gain = self.decay, self.decay[first:], self.slope_gain
        for t in range(steps):
            xs[t + 1] += decay * xs[t]
            if count > first:
                xs[t + 1, :, first:] += slope_gain * ss[t]
                ss[t + 1] += smooth_decay * ss[t]
        return xs.swapaxes(0, 1), ss.swapaxes(0, 1)

    @cached_property
    def between_anchors(self) -> "GaussMarkov":
        """The same processes, for a step from anchor to anchor."""
        return GaussMarkov(
            tuple(a * BLOCK_FRAMES for a in self.rough),
            tuple(a * BLOCK_FRAMES for a in self.smooth),
        )


def smooth_transition(a: float) -> Float[Array, "2 2"]:
    """The transition matrix of (x, s) of a smooth process over a time a."""
    return np.exp(-a) * np.array([[1.0, a], [0.0, 1.0]])


def smooth_noise(a: float) -> Float[Array, "2 2"]:
    """The covariance of what noise adds to (x, s) of a smooth process in a time a."""
    stationary = np.array([[1.0, 1.0], [1.0, 2.0]])
    transition = smooth_transition(a)
    return stationary - transition @ stationary @ transition.T


def processes_of(parts: Sequence[tuple[float, bool]]) -> tuple[GaussMarkov, list[int]]:
    """The processes of some (a, whether smooth), and which part each one is."""
    rough = [number for number, (_, smooth) in enumerate(parts) if not smooth]
    smooth = [number for number, (_, smooth) in enumerate(parts) if smooth]
    processes = GaussMarkov(tuple(parts[k][0] for k in rough), tuple(parts[k][0] for k in smooth))
    return processes, rough + smooth


@dataclass(frozen=True)
class NoiseStream:
    """What is drawn under one name."""

    name: str
    """Name of the effect; other names draw other numbers."""
    processes: GaussMarkov
    """Processes that run from frame to frame."""
    constants: int
    """How many constants each object has."""
    white: int
    """How many white numbers each frame of an object has."""


class DrawnBlocks(NamedTuple):
    """What is drawn for some blocks of frames."""

    path: Float[Array, "p b n"]
    """Value of each process in every frame of each block."""
    constants: Float[Array, "p f"]
    """Constants of each block's object."""
    white: Float[Array, "p b w"]
    """White numbers of every frame of each block."""


class JoinedStreams(NamedTuple):
    """The processes of several streams side by side."""

    processes: GaussMarkov
    """All processes."""
    noise_order: Int[Array, " nm"]
    """Where each column of their noise stands in the streams' noise, one after the other."""
    columns: list[Int[Array, " _"]]
    """For each stream, which of the processes are its own."""


def draw_blocks(
    seed: int, pieces: Int[Array, " p"], streams: tuple[NoiseStream, ...]
) -> list[DrawnBlocks]:
    """The blocks of some streams, whose processes run at once; piece: id * MAX_BLOCKS + block."""
    owner_ids, block = pieces // MAX_BLOCKS, pieces % MAX_BLOCKS
    objects, owner = np.unique(owner_ids, return_inverse=True)
    anchor_count = int(block.max()) + 2
    anchor_ids = np.repeat(objects, anchor_count)
    anchor_numbers = np.tile(np.arange(anchor_count), len(objects))
    step_ids = np.repeat(owner_ids, BLOCK_FRAMES)
    step_frames = (block[:, None] * BLOCK_FRAMES + np.arange(1, BLOCK_FRAMES + 1)).ravel()
    anchors, steps = [], []
    for stream in streams:
        name, width = stream.name, stream.processes.noise_width + stream.constants
        drawn = random_numbers.normal(seed, f"{name}/anchor", anchor_ids, anchor_numbers, width)
        anchors.append(drawn.reshape(len(objects), anchor_count, width))
        width = stream.processes.noise_width + stream.white
        drawn = random_numbers.normal(seed, f"{name}/step", step_ids, step_frames, width)
        steps.append(drawn.reshape(len(pieces), BLOCK_FRAMES, width))
    joined = join_streams(streams)
    path = steps[0][..., :0]
    if len(joined.noise_order):
        anchor_noise = _joined_noise(anchors, streams, joined.noise_order)
        step_noise = _joined_noise(steps, streams, joined.noise_order)
        path = _bridged_paths(joined.processes, anchor_noise, step_noise, owner, block)
    found = []
    for stream, columns, at_anchors, at_steps in zip(
        streams, joined.columns, anchors, steps, strict=True
    ):
        width = stream.processes.noise_width
        constants, white = at_anchors[owner, 0, width:], at_steps[..., width:]
        found.append(DrawnBlocks(path[..., columns], constants, white))
    return found


def _joined_noise(
    drawn: list[Array], streams: tuple[NoiseStream, ...], order: Array
) -> Float[Array, "p t nm"]:
    """The noise of all streams' processes, in the order in which they stand side by side."""
    noise = [
        each[..., : stream.processes.noise_width]
        for each, stream in zip(drawn, streams, strict=True)
    ]
    return noise[0] if len(noise) == 1 else np.concatenate(noise, axis=-1)[..., order]


def _bridged_paths(
    processes: GaussMarkov,
    anchor_noise: Float[Array, "o last nm"],
    step_noise: Float[Array, "p b nm"],
    owner: Int[Array, " p"],
    block: Int[Array, " p"],
) -> Float[Array, "p b n"]:
    """From anchor to anchor, then from each block's anchor to the next, pinned to it."""
    count, rough = len(processes.decay), len(processes.rough)
    first_x = anchor_noise[:, 0, :count]
    first_s = first_x[:, rough:] + anchor_noise[:, 0, count:]
    x, s = processes.between_anchors.run(first_x, first_s, anchor_noise[:, 1:])
    xs, ss = processes.run(x[owner, block], s[owner, block], step_noise)
    x_missing = x[owner, block + 1] - xs[:, -1]
    s_missing = s[owner, block + 1] - ss[:, -1]
    gains = processes.bridge_gains
    path = xs[:, :-1] + gains[:, 0] * x_missing[:, None]
    path[..., rough:] += gains[:, 1, rough:] * s_missing[:, None]
    return path


@lru_cache(maxsize=256)
def join_streams(streams: tuple[NoiseStream, ...]) -> JoinedStreams:
    """One set of processes for all streams."""
    all_processes = [each.processes for each in streams]
    rough_total = sum(len(each.rough) for each in all_processes)
    x_of_rough: list[int] = []
    x_of_smooth: list[int] = []
    s_of_smooth: list[int] = []
    columns = []
    noise_at, rough_at, smooth_at = 0, 0, rough_total
    for each in all_processes:
        rough, smooth = len(each.rough), len(each.smooth)
        x_of_rough += range(noise_at, noise_at + rough)
        x_of_smooth += range(noise_at + rough, noise_at + rough + smooth)
        s_of_smooth += range(noise_at + rough + smooth, noise_at + each.noise_width)
        mine = [*range(rough_at, rough_at + rough), *range(smooth_at, smooth_at + smooth)]
        columns.append(np.array(mine, np.int64))
        noise_at, rough_at = noise_at + each.noise_width, rough_at + rough
        smooth_at += smooth
    processes = GaussMarkov(
        sum((each.rough for each in all_processes), ()),
        sum((each.smooth for each in all_processes), ()),
    )
    order = np.array(x_of_rough + x_of_smooth + s_of_smooth, np.int64)
    return JoinedStreams(processes, order, columns)
