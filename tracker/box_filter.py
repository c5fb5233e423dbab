"""Mixes new boxes with the predicted ones: a filter that learns its own gain."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.kernels import Kernel
from tracker.lifecycle import MAX_CONSECUTIVE_STEPS, ActiveTracks
from tracker.types import Camera

# An innovation beyond this share of the box's height tells nothing of the detector's noise.
MAX_INNOVATION = 0.5
# The gain never falls below this: what is seen must not be overruled for good.
MIN_GAIN = 0.2
# Keeps a division from 0 / 0.
MIN_POWER = 1e-12
LIMITS = np.array([MAX_INNOVATION, MAX_CONSECUTIVE_STEPS, MIN_GAIN, MIN_POWER])
FILTER_BOXES = Kernel("tracker.kernels.box_gains", "filter_boxes")


class Gains(NamedTuple):
    """What was learned. Rows: small, middle, large boxes; columns: centre x, y, width, height."""

    gains: Float[Array, "3 4"]
    """Share of an innovation that is taken, 0.2 to 1; 1 = the new box as it is."""
    pairs: Float[Array, "3 1"]
    """Pairs of successive innovations that were used, for each size of box."""
    power: Float[Array, "3 4"]
    """Summed squares of those innovations, in box heights squared."""

    @classmethod
    def cut(cls, numbers: Float[Array, "27"]) -> "Gains":
        """Those that lie one after the other: gains, power, pairs."""
        return cls(
            numbers[:12].reshape(3, 4), numbers[24:].reshape(3, 1), numbers[12:24].reshape(3, 4)
        )


class Filtered(NamedTuple):
    """What the filter makes of new boxes; one row per track that was detected."""

    boxes: Float[Array, "k 4"]
    """New and predicted boxes mixed: x_min, y_min, x_max, y_max, px."""
    innovations: Float[Array, "k 4"]
    """New boxes less predicted ones, see `ActiveTracks.innovations`."""
    learned: Gains
    """What is known of the detector's noise after this frame."""


@dataclass(frozen=True)
class BoxFilter:
    """Predicted box + gain x innovation, for centre and size; the gain follows the noise.

    The innovations of a filter with the right gain are white: where successive ones of a track
    have the same sign the gain is too small, where they alternate too large (Mehra, IEEE Trans.
    Automatic Control 1970). The products of all tracks are pooled by box size, so the gain
    follows the detector: near `gain` with KITTI's detectors, .3 to .6 where boxes jitter.
    """

    gain: float = 0.8
    """Gain to start from; 1: the new box as it is; less: smoother boxes, which follow more
    slowly."""
    prior: float = 200.0
    """How many pairs of innovations that start is worth; more: the gain is learned more slowly."""
    sizes: tuple[float, float] = (35.0, 60.0)
    """Lengths of the shorter side, px, between small and middle and between middle and large
    boxes."""
    border: float = 2.0
    """A box this near to the image's border, px, is cut by it and taken as it is; more: fewer boxes
    are filtered."""

    @property
    def settings(self) -> tuple[Float[Array, "2"], float, float]:
        """`sizes` as an array, `border` and `prior`."""
        return self.size_limits, self.border, self.prior

    @cached_property
    def size_limits(self) -> Float[Array, "2"]:
        """`sizes` as an array."""
        return np.array(self.sizes, float)

    def start(self) -> Gains:
        """Nothing learned yet."""
        return _locked(np.full((3, 4), self.gain), np.zeros((3, 1)), np.zeros((3, 4)))

    def __call__(
        self,
        learned: Gains,
        matched: ActiveTracks,
        boxes: Float[Array, "k 4"],
        dt: float,
        camera: Camera,
    ) -> Filtered:
        """The filtered boxes of tracks (as predicted) that were detected as `boxes`, pixels."""
        if len(boxes) == 0:
            return Filtered(boxes, boxes, learned)
        k, size = boxes.shape[0], self.size_limits
        filtered, innovations = np.empty((k, 4)), np.empty((k, 4))
        after = Gains(np.empty((3, 4)), np.empty((3, 1)), np.empty((3, 4)))
        tracks = matched.hits, matched.time_since_update, matched.innovations
        how = dt, camera.far_corner, self.border, self.prior, LIMITS
        out = filtered, innovations, *after
        FILTER_BOXES(*learned, size, matched.beliefs.boxes, boxes, *tracks, *how, *out)
        return Filtered(filtered, innovations, _locked(*after))


def _locked(
    gains: Float[Array, "3 4"], pairs: Float[Array, "3 1"], power: Float[Array, "3 4"]
) -> Gains:
    """Gains that are never modified."""
    for array in (gains, pairs, power):
        array.setflags(write=False)
    return Gains(gains, pairs, power)
