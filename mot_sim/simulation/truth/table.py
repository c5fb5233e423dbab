"""The tables of ground truth: what is true of every car in every frame, who hides whom."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from jaxtyping import Float, Int, UInt8
from numpy import ndarray as Array

from tracker.types import Rows, Tracks

# Visible fractions from which KITTI's occlusion is 0 (fully visible), 1 (partly) and 2 (largely
# occluded); below the last it is 3 (unknown), which no tracker has to find. KITTI's annotators
# judged by eye: where their levels change in the re-enacted drives (`benchmarks.labels`). They
# call a car occluded as soon as anything hides it, and seldom write 3.
OCCLUSION_LEVELS = (0.99, 0.6, 0.02)
# A car is truncated (KITTI's level 1) when more than this part of its box is outside the image.
MAX_TRUNCATION = 0.05


class KeypointVisibility(IntEnum):
    """Whether a keypoint is seen, and if not, why; the first reason in this order counts."""

    VISIBLE = 0
    SELF_OCCLUDED = 1  # its own car hides it
    OCCLUDED = 2  # something else does
    TRUNCATED = 3  # outside the image, or behind the camera


@dataclass(frozen=True, eq=False)
class Truth(Rows):
    """What is true of every car in every frame, in the order of frames and ids.

    Cars without a pixel in the image, were they alone there, have no row; hidden ones have one.
    """

    tracks: Tracks
    """Boxes around the part of the mesh's projection inside the image, pixels; KITTI's class and
    levels; cuboids in the road frame."""
    visible: Float[Array, " n"]
    """Pixels seen over the pixels of the whole silhouette inside the image, 0 to 1."""
    truncation: Float[Array, " n"]
    """Part of the unclipped box's area that is outside the image, 0 to 1."""
    amodal_boxes: Float[Array, "n 4"]
    """Boxes around what is before the near plane, pixels, not clipped to the image."""
    visible_boxes: Float[Array, "n 4"]
    """Boxes around the visible pixels' centres, pixels; NaN where there are none."""
    pixels: Int[Array, " n"]
    """Pixels seen."""
    amodal_pixels: Int[Array, " n"]
    """Pixels of the whole silhouette inside the image."""
    keypoints: Float[Array, "n 36 2"]
    """The 36 of `tracker.shape.KEYPOINTS_36`, pixels; NaN behind the camera."""
    keypoint_states: UInt8[Array, "n 36"]
    """A `KeypointVisibility` of each keypoint."""
    speed: Float[Array, " n"]
    """Along the heading, m/s."""
    velocity: Float[Array, "n 2"]
    """Along x and y of the world, m/s."""
    acceleration: Float[Array, " n"]
    """Change of the speed since the frame before, m/s^2; 0 at first sight."""
    yaw_rate: Float[Array, " n"]
    """About world z (down) since the frame before, rad/s; 0 at first sight."""

    @property
    def is_moving(self) -> Array:
        """Whether a car drives faster than walking pace (1.4 m/s); bool, one a row."""
        return np.abs(self.speed) > 1.4


@dataclass(frozen=True, eq=False)
class Occlusions(Rows):
    """Who hides whom: one row per frame and pair, in the order of frames and ids."""

    frames: Int[Array, " m"]
    """The frame."""
    ids: Int[Array, " m"]
    """The hidden car."""
    occluder_ids: Int[Array, " m"]
    """The car that hides it; -1 for scenery."""
    pixels: Int[Array, " m"]
    """Pixels of the hidden car's silhouette that show the occluder."""


def occlusion_level(visible: Float[Array, " n"]) -> Int[Array, " n"]:
    """KITTI's level of a visible fraction: 0 from .99 on, 1 from .6, 2 from .02, else 3."""
    return (visible[:, None] < np.array(OCCLUSION_LEVELS)).sum(axis=1).astype(np.int64)
