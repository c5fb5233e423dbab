"""How boxes are off: errors of centre and size, the visible part alone, the image's border."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.matching import same_frame_pairs
from mot_sim.simulation.sensors.checks import require_finite, require_rates, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normal_columns
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.errors import BadConfig
from tracker.geometry import box_iou
from tracker.types import Camera

MAX_ERROR_SPREADS = 8.0  # typical errors, so that no box turns inside out
MIN_TAIL = 1e-6  # below, sinh is a straight line
MIN_SIDE_SHARE = 0.05  # of the true side; a smaller box is no box


@dataclass(frozen=True)
class Component:
    """One of four errors: bias + spread * shape(x), x a correlated standard normal number."""

    spread: float = 0.0
    """Typical size of the error, in parts of the box's side, >= 0; more: boxes jump more."""
    bias: float = 0.0
    """Mean of the error, in parts of the box's side; not 0: boxes are always off to one side."""
    tail: float = 0.0
    """shape(x) = sinh(tail * x) / tail, >= 0; 0 is normal, more: more errors far from the mean."""
    skew: float = 0.0
    """Adds skew * (x^2 - 1) to shape(x); not 0: large errors lie on one side."""
    hidden: float = 0.0
    """`spread` grows by e^(hidden * (0.95 - visible)); more: larger errors of hidden cars."""
    by_height: float = 0.0
    """`spread` grows by (height / 50 px)^by_height; below 0: larger errors of small boxes."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How x is correlated over time; slower: boxes drift instead of jumping."""

    def __post_init__(self) -> None:
        require_sigmas("jitter spread, tail", self.spread, self.tail)
        require_finite("jitter bias, skew, ...", self.bias, self.skew, self.hidden, self.by_height)

    def shape(self, x: Float[Array, " n"]) -> Float[Array, " n"]:
        """From a normal number to one with the component's tails and skew."""
        stretched = np.sinh(self.tail * x) / self.tail if self.tail > MIN_TAIL else x
        return (stretched + self.skew * (x**2 - 1.0)).clip(-MAX_ERROR_SPREADS, MAX_ERROR_SPREADS)


@dataclass(frozen=True)
class Jitter:
    """Errors of a box's centre and size."""

    x: Component = field(default_factory=Component)
    """Error of the centre, in parts of the width."""
    y: Component = field(default_factory=Component)
    """Error of the centre, in parts of the height."""
    width: Component = field(default_factory=Component)
    """Error of log(width)."""
    height: Component = field(default_factory=Component)
    """Error of log(height)."""

    def __call__(
        self,
        boxes: Float[Array, "n 4"],
        sightings: Sightings,
        seed: int,
        step: float,
        level: float = 1.0,
    ) -> Float[Array, "n 4"]:
        """The boxes with their errors; level 0 gives them back unchanged."""
        if not level >= 0.0:
            raise BadConfig(f"jitter level {level:g}: 0 (none) or more")
        if level == 0.0 or not self._numbers[:2].any():
            return boxes
        x = correlated_normal_columns(
            seed, "jitter", sightings.ids, sightings.frames, self.autocorrelations, step
        )
        spread, bias, tail, skew, hidden, by_height = self._numbers
        grown = hidden * (0.95 - sightings.visible)[:, None]
        grown += by_height * np.log(np.maximum(sightings.height, 5.0) / 50.0)[:, None]
        shape = (np.sinh(tail * x) / tail + skew * (x**2 - 1.0)).clip(
            -MAX_ERROR_SPREADS, MAX_ERROR_SPREADS
        )
        errors = level * (bias + spread * np.exp(grown) * shape)
        return move_boxes(boxes, *errors.T)

    @cached_property
    def autocorrelations(self) -> tuple[Autocorrelation, ...]:
        """Of the four."""
        return (
            self.x.autocorrelation,
            self.y.autocorrelation,
            self.width.autocorrelation,
            self.height.autocorrelation,
        )

    @cached_property
    def _numbers(self) -> Float[Array, "6 4"]:
        """spread, bias, tail, skew, hidden, by_height of the four; no tail is a tiny one."""
        parts = self.x, self.y, self.width, self.height
        return np.array(
            [
                [part.spread for part in parts],
                [part.bias for part in parts],
                [max(part.tail, MIN_TAIL) for part in parts],
                [part.skew for part in parts],
                [part.hidden for part in parts],
                [part.by_height for part in parts],
            ]
        )


def move_boxes(
    boxes: Float[Array, "n 4"],
    dx: Float[Array, " n"],
    dy: Float[Array, " n"],
    dw: Float[Array, " n"],
    dh: Float[Array, " n"],
) -> Float[Array, "n 4"]:
    """Boxes with moved centres (parts of the sides) and sides times e^dw, e^dh."""
    sides = boxes[:, 2:] - boxes[:, :2]
    centres = 0.5 * (boxes[:, :2] + boxes[:, 2:]) + sides * np.stack((dx, dy), axis=1)
    scales = np.exp(
        np.stack((dw, dh), axis=1).clip(np.log(MIN_SIDE_SHARE), -np.log(MIN_SIDE_SHARE))
    )
    half = 0.5 * sides * scales
    return np.concatenate((centres - half, centres + half), axis=1)


def box_errors(boxes: Float[Array, "n 4"], true: Float[Array, "n 4"]) -> Float[Array, "n 4"]:
    """dx, dy, dw, dh that `move_boxes` needs to make the boxes from the true ones."""
    sides = true[:, 2:] - true[:, :2]
    moved = 0.5 * (boxes[:, :2] + boxes[:, 2:] - true[:, :2] - true[:, 2:]) / sides
    return np.concatenate((moved, np.log((boxes[:, 2:] - boxes[:, :2]) / sides)), axis=1)


@dataclass(frozen=True)
class VisiblePart:
    """How much boxes keep to the visible part of a car."""

    weight: float = 0.0
    """0 (box of the whole car, as KITTI's labels) to 1 (box of its visible part alone)."""

    def __post_init__(self) -> None:
        require_rates("visible_part weight", self.weight)

    def __call__(self, sightings: Sightings) -> Float[Array, "n 4"]:
        """The boxes; whole where it is unknown what was visible."""
        part = np.where(np.isnan(sightings.visible_boxes), sightings.boxes, sightings.visible_boxes)
        if self.weight == 0.0:
            return sightings.boxes
        return (1.0 - self.weight) * sightings.boxes + self.weight * part


@dataclass(frozen=True)
class Border:
    """What happens to boxes at the image's border."""

    snap: float = 0.0
    """Pixels, >= 0: an edge nearer to the border lies on it; more: more edges do."""

    def __post_init__(self) -> None:
        require_sigmas("border snap", self.snap)

    def __call__(self, boxes: Float[Array, "n 4"], camera: Camera) -> Float[Array, "n 4"]:
        """The boxes inside the image; exact boxes stay as they are when nothing snaps."""
        clipped = camera.clip_boxes(boxes)
        if self.snap == 0.0:
            return clipped
        far = camera.far_corner
        low = np.where(clipped[:, :2] < self.snap, 0.0, clipped[:, :2])
        high = np.where(clipped[:, 2:] > far[2:] - self.snap, far[2:], clipped[:, 2:])
        return np.concatenate((low, high), axis=1)


def has_area(boxes: Float[Array, "n 4"]) -> Bool[Array, " n"]:
    """Boxes with an inside; others (wholly outside the image) no detector reports."""
    return np.asarray((boxes[:, 2:] > boxes[:, :2]).all(axis=1))


def overlapping_pairs(
    frames: Int[Array, " n"], boxes: Float[Array, "n 4"], min_iou: float
) -> tuple[Int[Array, " p"], Int[Array, " p"], Float[Array, " p"]]:
    """Each pair of rows of a frame with at least this IoU, once, and the IoU; frames ascend."""
    first, second = same_frame_pairs(frames, frames)
    once = first < second
    first, second = first[once], second[once]
    iou = box_iou(boxes[first], boxes[second])
    near = iou >= min_iou
    return first[near], second[near], iou[near]


def pair_ids(one: Int[Array, " p"], other: Int[Array, " p"]) -> Int[Array, " p"]:
    """One number for two objects, whichever comes first."""
    return np.minimum(one, other) * 1_000_003 + np.maximum(one, other)
