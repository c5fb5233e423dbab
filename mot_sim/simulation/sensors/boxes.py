"""Boxes of the visible part alone, at the image's border, moved, and in pairs that overlap."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.matching import same_frame_pairs
from mot_sim.simulation.sensors.checks import require_rates, require_sigmas
from mot_sim.simulation.sensors.jitter import MIN_SIDE_SHARE
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.geometry import box_iou
from tracker.types import Camera


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
