"""False alarms: boxes where no car is, on the road by their size; some stay for a while."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array
from scipy.special import expit

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.checks import require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.gauss_markov import BLOCK_FRAMES
from mot_sim.simulation.sensors.quantiles import Quantiles
from tracker.errors import BadConfig
from tracker.geometry import transform
from tracker.types import Camera, Rows

FALSE_ALARM_HEIGHT_METRES = 1.5  # as high as a car
MAX_BIRTHS = 16  # a step and share of the autocorrelation
LIFETIMES_BEFORE = 8.0  # of births before the first frame that count (e^-8 of them live)
MAX_LIVE_FRAMES = 4  # frames up to which a call is a live step
FRAME_OFFSET = 1 << 20  # births before frame 0 have a positive number too


@dataclass(frozen=True, eq=False)
class FalseAlarms(Rows):
    """The false alarms that are there: one row per frame and false alarm, by frame."""

    frames: Int[Array, " n"]
    """The frame."""
    ids: Int[Array, " n"]
    """Id of the false alarm, the same as long as it stays."""
    boxes: Float[Array, "n 4"]
    """Inside the image, pixels."""
    scores: Float[Array, " n"]
    """Confidence, 0 to 1."""


@dataclass(frozen=True)
class Clutter:
    """How often and where boxes are reported without a car."""

    rate: float = 0.0
    """False alarms per frame on average, 0 to 8; more: more false tracks."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """Shares of the false alarms by mean lifetime; slower: they stay for more frames."""
    height: Quantiles = Quantiles((25.0, 60.0))
    """Distribution of a box's height, pixels; values below 2 count as 2."""
    aspect: Quantiles = Quantiles((1.0, 2.5))
    """Distribution of width over height; values below 0.1 count as 0.1."""
    x: Quantiles = Quantiles((0.0, 1.0))
    """Distribution of the centre, in parts of the image's width."""
    wobble: float = 0.02
    """Std of a box's moves from frame to frame, in parts of its sides, >= 0; more: boxes jump
    more."""
    log_odds: Quantiles = Quantiles((-2.0, 2.0))
    """Distribution of the score's log-odds; higher: false alarms look surer."""

    def __post_init__(self) -> None:
        require_sigmas("clutter rate, wobble", self.rate, self.wobble)
        if self.rate > MAX_BIRTHS / 2:
            raise BadConfig(f"clutter rate {self.rate:g} a frame: at most {MAX_BIRTHS // 2}")

    def __call__(
        self, frames: Int[Array, " f"], seed: int, camera: Camera, step: float, level: float = 1.0
    ) -> FalseAlarms:
        """The false alarms of the given frames (ascending); as many a frame at any frame rate."""
        rate = level * self.rate
        ids = when = np.zeros(0, np.int64)
        if rate > 0.0 and len(frames) > MAX_LIVE_FRAMES:
            ids, when = _present(frames, seed, rate, self.autocorrelation, step)
        elif rate > 0.0 and len(frames):  # a live step: the answer for its block is kept
            found = [
                _present_in(frame, seed, rate, self.autocorrelation, step)
                for frame in frames.tolist()
            ]
            ids, when = (np.concatenate(column) for column in zip(*found, strict=True))
        if not len(ids):
            return FalseAlarms(ids, when, np.zeros((0, 4)), np.zeros(0))
        boxes = self._boxes(ids, when, seed, camera)
        x = random_numbers.normal(seed, "clutter/score/step", ids, np.ones_like(ids))[:, 0]
        wavering = random_numbers.normal(seed, "clutter/waver", ids, when)[:, 0]
        scores = expit(self.log_odds.of_normal(0.8 * x + 0.6 * wavering))
        return FalseAlarms(when, ids, boxes, scores)

    def _boxes(
        self, ids: Int[Array, " n"], frames: Int[Array, " n"], seed: int, camera: Camera
    ) -> Float[Array, "n 4"]:
        """Boxes whose lower edge lies where the road is at the depth that their size tells."""
        fixed = random_numbers.normal(seed, "clutter/place", ids, np.zeros_like(ids), 4)
        wobble = self.wobble * random_numbers.normal(seed, "clutter/wobble", ids, frames, 2)
        height = np.maximum(self.height.of_normal(fixed[:, 0]), 2.0)
        width = height * np.maximum(self.aspect.of_normal(fixed[:, 1]), 0.1)
        u = self.x.of_normal(fixed[:, 2]) * camera.image_size[0] + wobble[:, 0] * width
        depth = camera.K[1, 1] * FALSE_ALARM_HEIGHT_METRES / height
        ground = np.stack((np.zeros_like(depth), np.zeros_like(depth), depth), axis=1)
        v = camera.project(transform(camera.T_cam_road, ground))[:, 1]
        v = v + (0.1 * fixed[:, 3] + wobble[:, 1]) * height
        boxes = np.stack((u - width / 2, v - height, u + width / 2, v), axis=1)
        return camera.clip_boxes(boxes)


def _present(
    frames: Int[Array, " f"], seed: int, rate: float, autocorrelation: Autocorrelation, step: float
) -> tuple[Int[Array, " n"], Int[Array, " n"]]:
    """Ids and frames of the false alarms of all shares, by frame."""
    alive = [
        _alive(frames, seed, number, rate * share, tau / step)
        for number, (share, tau, _) in enumerate(autocorrelation.parts)
        if share > 0.0
    ]
    ids, when = (np.concatenate(column) for column in zip(*alive, strict=True))
    order = np.lexsort((ids, when))
    return ids[order], when[order]


def _present_in(
    frame: int, seed: int, rate: float, autocorrelation: Autocorrelation, step: float
) -> tuple[Int[Array, " n"], Int[Array, " n"]]:
    """The same for a frame, from the block of it that is kept."""
    ids, when = _present_from(frame // BLOCK_FRAMES, seed, rate, autocorrelation, step)
    rows = slice(*np.searchsorted(when, (frame, frame + 1)).tolist())
    return ids[rows], when[rows]


@lru_cache(maxsize=64)
def _present_from(
    block: int, seed: int, rate: float, autocorrelation: Autocorrelation, step: float
) -> tuple[Int[Array, " n"], Int[Array, " n"]]:
    """The same for a block of frames."""
    return _present(
        np.arange(BLOCK_FRAMES) + block * BLOCK_FRAMES, seed, rate, autocorrelation, step
    )


def _alive(
    frames: Int[Array, " f"], seed: int, number: int, rate: float, life: float
) -> tuple[Int[Array, " n"], Int[Array, " n"]]:
    """Ids and frames of one share of false alarms: `rate` a frame, living `life` frames on average.

    Births are a Poisson process in continuous time and lives are exponential (M/M/infinity), so
    the number in a frame is Poisson(rate) at any frame rate. life 0: one frame each.
    """
    before = int(np.ceil(LIFETIMES_BEFORE * life))
    births = np.arange(int(frames[0]) - before, int(frames[-1]) + 1)
    expected = rate / life if life > 0.0 else rate
    cumulative = np.cumsum(poisson(expected))
    chance = random_numbers.uniform(
        seed, f"clutter/births/{number}", np.zeros_like(births), births
    )[:, 0]
    count = np.searchsorted(cumulative, chance).clip(0, MAX_BIRTHS)
    born = np.repeat(births, count)
    slot = np.arange(len(born)) - np.repeat(np.cumsum(count) - count, count)
    ids = (born + FRAME_OFFSET) * MAX_BIRTHS * 8 + slot * 8 + number
    if life > 0.0:
        u = random_numbers.uniform(seed, "clutter/life", ids, np.zeros_like(ids), 2)
        # Born up to one frame before; a short life may end before any frame sees it.
        last = np.floor(born - u[:, 0] - life * np.log(u[:, 1])).astype(np.int64)
    else:
        last = born
    stay = np.maximum(last - born + 1, 0)
    when = np.repeat(born, stay) + np.arange(stay.sum()) - np.repeat(np.cumsum(stay) - stay, stay)
    ids = np.repeat(ids, stay)
    wanted = np.isin(when, frames)
    return ids[wanted], when[wanted]


def poisson(mean: float) -> Float[Array, " k"]:
    """Probabilities of 0, 1, ..., MOST_BIRTHS events."""
    count = np.arange(MAX_BIRTHS + 1)
    factorials = np.cumprod(np.maximum(count, 1).astype(float))
    return np.exp(-mean) * mean**count / factorials
