"""Measured cues: yaw and size, shape coefficients, keypoints, appearance descriptors."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.checks import require_rates, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, bursts, correlated_normals
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.errors import BadConfig
from tracker.geometry import wrap_angle

REFERENCE_DEPTH_METRES = 10.0  # metres: where `spread` is given
STATE_COUNT = 4  # visible, hidden by the car itself, hidden by another, outside the image


@dataclass(frozen=True)
class Pose:
    """Errors of the measured yaw and size."""

    yaw: float = 0.0
    """Std of the yaw's error, radians, >= 0; more: less exact yaw."""
    hidden: float = 0.0
    """The std of yaw grows by e^(hidden * (1 - visible)), >= 0; more: less exact for hidden
    cars."""
    flips: float = 0.0
    """Rate of yaw + pi, 0 to 1; more: cars are taken for turned round more often."""
    size: float = 0.0
    """Std of the relative error of length, height and width, >= 0; more: less exact sizes."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How the errors are correlated over time; slower: a car's errors last longer."""
    flip_autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How flips are correlated over time; slower: a car stays turned round longer."""

    def __post_init__(self) -> None:
        require_sigmas("pose yaw, hidden, size", self.yaw, self.hidden, self.size)
        require_rates("pose flips", self.flips)

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> tuple[Float[Array, " n"], Float[Array, "n 3"]]:
        """Yaw about road +y and size; NaN rows without cuboids. Level 0 gives the exact ones."""
        if sightings.cuboids is None:
            return np.full(len(sightings), np.nan), np.full((len(sightings), 3), np.nan)
        yaw, size = sightings.cuboids.yaw, sightings.cuboids.size
        if level == 0.0:
            return yaw, size
        ids, frames = sightings.ids, sightings.frames
        x = correlated_normals(seed, "pose", ids, frames, self.autocorrelation, step, 4)
        spread = self.std(sightings, level)
        rates = np.full(len(ids), min(level * self.flips, 1.0))
        turned = bursts(rates, seed, "flip", ids, frames, self.flip_autocorrelation, step)
        measured = yaw + spread * x[:, 0] + np.pi * turned
        if self.yaw or turned.any():
            yaw = np.asarray(wrap_angle(measured))
        return yaw, size * np.exp(level * self.size * x[:, 1:])

    def std(self, sightings: Sightings, level: float = 1.0) -> Float[Array, " n"]:
        """Of the measured yaw, radians, cars turned round apart."""
        return level * self.yaw * np.exp(self.hidden * (1.0 - sightings.visible))


@dataclass(frozen=True)
class Shape:
    """Errors of the measured shape coefficients."""

    spread: float = 0.0
    """Std of each coefficient's error at a depth of 10 m, >= 0; more: less exact shapes."""
    growth: float = 1.0
    """The std grows by (depth / 10 m)^growth, >= 0; more: less exact for far cars."""
    shrink: float = 0.0
    """Part of the way to the mean shape that a wholly hidden car goes besides `pull`, 0 to 1; more:
    hidden cars look alike."""
    pull: float = 0.0
    """Part of the way to the mean shape that every car goes, since a fit trusts its prior, 0 to 1;
    more: cars look alike."""
    stated: float = 0.0
    """Std that the detector claims of each coefficient, >= 0; 0: the true one of the noise."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How the errors are correlated over time; slower: a car's errors last longer."""

    def __post_init__(self) -> None:
        require_sigmas("shape spread, growth, stated", self.spread, self.growth, self.stated)
        require_rates("shape shrink, pull", self.shrink, self.pull)

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> Float[Array, "n b"] | None:
        """The coefficients; None where truth has none."""
        if sightings.shape is None or level == 0.0:
            return sightings.shape
        columns = sightings.shape.shape[1]
        x = correlated_normals(
            seed, "shape", sightings.ids, sightings.frames, self.autocorrelation, step, columns
        )
        kept = 1.0 - np.minimum(level * self.shrink * (1.0 - sightings.visible), 1.0)
        kept *= 1.0 - min(level * self.pull, 1.0)
        return kept[:, None] * sightings.shape + self.std(sightings, level)[:, None] * x

    def std(self, sightings: Sightings, level: float = 1.0) -> Float[Array, " n"]:
        """Of every measured coefficient."""
        depth = np.nan_to_num(sightings.depth, nan=REFERENCE_DEPTH_METRES)
        return level * self.spread * np.maximum(depth / REFERENCE_DEPTH_METRES, 0.1) ** self.growth

    def stated_std(self, sightings: Sightings, level: float = 1.0) -> Float[Array, " n"]:
        """The std that the detector states of every coefficient."""
        if not self.stated:
            return self.std(sightings, level)
        return np.full(len(sightings), level * self.stated)


@dataclass(frozen=True)
class Keypoints:
    """Errors of keypoints; states are visible, self-occluded, occluded by another, truncated."""

    spread: tuple[float, ...] = (0.0,) * STATE_COUNT
    """Std of u and v for each state, in parts of the box's larger side, >= 0; more: points jump
    more and state a lower confidence."""
    misses: tuple[float, ...] = (0.0,) * STATE_COUNT
    """Rate of missed points for each state, 0 to 1; more: fewer points."""
    flips: float = 0.0
    """Rate of left taken for right, 0 to 1, which swaps the first half of the points with the
    second."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How errors and flips are correlated over time; slower: they last longer."""

    def __post_init__(self) -> None:
        if len(self.spread) != STATE_COUNT or len(self.misses) != STATE_COUNT:
            raise BadConfig("keypoints: give four numbers, one a state")
        require_sigmas("keypoints spread", *self.spread)
        require_rates("keypoints", *self.misses, self.flips)

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> Float[Array, "n k 3"] | None:
        """u, v, confidence; NaN for a missed point, None where truth has no keypoints."""
        if sightings.keypoints is None or sightings.keypoint_states is None:
            return None
        true, ids, frames = sightings.keypoints, sightings.ids, sightings.frames
        count, points = true.shape[:2]
        state = sightings.keypoint_states.astype(np.int64)
        sides = sightings.boxes[:, 2:] - sightings.boxes[:, :2]
        x = correlated_normals(
            seed, "keypoints", ids, frames, self.autocorrelation, step, 2 * points
        )
        spread = level * np.array(self.spread)[state] * sides.max(axis=1, initial=0.0)[:, None]
        uv = true + spread[..., None] * x.reshape(count, points, 2) if level else true
        rates = np.full(count, min(level * self.flips, 1.0))
        turned = bursts(rates, seed, "keypoints/flip", ids, frames, self.autocorrelation, step)
        half = points // 2
        mirrored = np.concatenate((uv[:, half : 2 * half], uv[:, :half], uv[:, 2 * half :]), axis=1)
        uv = np.where(turned[:, None, None], mirrored, uv)
        chance = random_numbers.uniform(seed, "keypoints/miss", ids, frames, points)
        lost = (chance < level * np.array(self.misses)[state]) | np.isnan(uv).any(axis=2)
        confidence = np.exp(-10.0 * level * np.array(self.spread)[state])
        measured = np.concatenate((uv, confidence[..., None]), axis=2)
        return np.where(lost[..., None], np.nan, measured)


@dataclass(frozen=True)
class AppearanceNoise:
    """Descriptors of cars' looks and their noise."""

    size: int = 32
    """Numbers in a descriptor, >= 1; more: cars without the same look differ more surely."""
    noise: float = 0.0
    """Typical length of the noise, >= 0, a look's own being 1; more: looks tell cars apart less
    well."""
    view: float = 0.0
    """Length of the part that turns with the viewpoint, >= 0, a look's own being 1; more: looks
    change more in turns."""
    alike: int = 1
    """Cars with consecutive ids that share one look, >= 1; more: more cars look the same."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How the noise is correlated over time; slower: a car's errors last longer."""
    unit: float = 1.0
    """Distance of vectors of length 1, > 0, at which two cars are as likely one as two; what is
    reported is in that unit, as the tracker's own descriptors are."""

    def __post_init__(self) -> None:
        require_sigmas("appearance noise, view", self.noise, self.view)
        if self.size < 1 or self.alike < 1:
            raise BadConfig(f"appearance size {self.size}, alike {self.alike}: 1 or more")
        if not 0.0 < self.unit < np.inf:
            raise BadConfig(f"appearance unit {self.unit:g}: give a finite number above 0")

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> Float[Array, "n d"]:
        """Vectors of length 1 / unit; at level 0 those of the cars themselves."""
        ids, frames = sightings.ids, sightings.frames
        look, never = ids // self.alike, np.zeros_like(frames)
        vectors = _unit(random_numbers.normal(seed, "appearance", look, never, self.size))
        turns = level > 0.0 and self.view > 0.0 and sightings.cuboids is not None
        if turns and sightings.cuboids is not None:
            sides = random_numbers.normal(seed, "appearance/view", look, never, 2 * self.size)
            base = sightings.cuboids.base
            angle = np.nan_to_num(sightings.cuboids.yaw - np.arctan2(base[:, 0], base[:, 2]))
            turning = (
                np.cos(angle)[:, None] * sides[:, : self.size]
                + np.sin(angle)[:, None] * sides[:, self.size :]
            )
            vectors = vectors + level * self.view * turning / np.sqrt(self.size)
        if level and self.noise:
            x = correlated_normals(
                seed, "appearance/noise", ids, frames, self.autocorrelation, step, self.size
            )
            vectors = vectors + level * self.noise * x / np.sqrt(self.size)
        return (_unit(vectors) if turns or (level and self.noise) else vectors) / self.unit


def _unit(vectors: Float[Array, "n d"]) -> Float[Array, "n d"]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
