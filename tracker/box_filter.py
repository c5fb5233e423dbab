"""Mixes new boxes with the predicted ones: a filter that learns its own gain."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.lifecycle import MAX_CONSECUTIVE_STEPS, ActiveTracks
from tracker.types import Camera

# Boxes times this are centres and sizes; and back.
TO_CENTRE = np.array(
    [[0.5, 0.0, -1.0, 0.0], [0.0, 0.5, 0.0, -1.0], [0.5, 0.0, 1.0, 0.0], [0.0, 0.5, 0.0, 1.0]]
)
FROM_CENTRE = np.linalg.inv(TO_CENTRE)
# An innovation beyond this share of the box's height tells nothing of the detector's noise.
MAX_INNOVATION = 0.5
# The gain never falls below this: what is seen must not be overruled for good.
MIN_GAIN = 0.2
# Small, middle and large boxes learn gains of their own.
SIZE_CLASSES = np.arange(3)[:, None]
# Keeps a division from 0 / 0.
MIN_POWER = 1e-12


class Gains(NamedTuple):
    """What was learned. Rows: small, middle, large boxes; columns: centre x, y, width, height."""

    gains: Float[Array, "3 4"]
    """Share of an innovation that is taken, 0.2 to 1; 1 = the new box as it is."""
    pairs: Float[Array, "3 1"]
    """Pairs of successive innovations that were used, for each size of box."""
    power: Float[Array, "3 4"]
    """Summed squares of those innovations, in box heights squared."""


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
        expected = matched.beliefs.boxes
        off = (boxes - expected).dot(TO_CENTRE)
        sides = expected[:, 2:] - expected[:, :2]
        shorter = np.minimum(sides[:, 0], sides[:, 1])
        size_class = (shorter > self.sizes[0]) + (shorter > self.sizes[1]).astype(np.int64)
        gain = np.maximum(learned.gains.take(size_class, 0), (1.0 / (matched.hits + 1.0))[:, None])
        unusable = matched.time_since_update > MAX_CONSECUTIVE_STEPS * dt
        if np.count_nonzero(unusable) and dt > 0.0:
            gain = 1.0 - (1.0 - gain) ** (matched.time_since_update / dt)[:, None]
        beyond = boxes[:, :2] < self.border
        beyond |= boxes[:, 2:] > camera.far_corner[:2] - self.border
        cut = beyond[:, 0] | beyond[:, 1]
        if np.count_nonzero(cut):
            gain[cut] = 1.0
            unusable |= cut
        innovations = off / np.maximum(sides[:, 1:], 1.0)
        innovations = np.minimum(np.maximum(innovations, -MAX_INNOVATION), MAX_INNOVATION)
        innovations[unusable] = np.nan
        learned = self._learn(learned, size_class, matched.innovations, innovations)
        return Filtered(expected + (off * gain).dot(FROM_CENTRE), innovations, learned)

    def _learn(
        self,
        learned: Gains,
        size_class: Int[Array, " k"],
        before: Float[Array, "k 4"],
        now: Float[Array, "k 4"],
    ) -> Gains:
        """One step towards white innovations: gain + sum of products / sum of squares."""
        usable = np.isfinite(before[:, 0] + now[:, 0]).nonzero()[0]
        if len(usable) == 0:
            return learned
        a, b = before.take(usable, 0), now.take(usable, 0)
        member = (size_class.take(usable) == SIZE_CLASSES).astype(float)
        pairs = learned.pairs + np.add.reduce(member, 1, keepdims=True)
        power = learned.power + member.dot(0.5 * (a * a + b * b))
        worth = power * (1.0 + self.prior / np.maximum(pairs, 1.0)) + MIN_POWER
        gains = learned.gains + member.dot(a * b) / worth
        return _locked(np.minimum(np.maximum(gains, MIN_GAIN), 1.0), pairs, power)


def _locked(
    gains: Float[Array, "3 4"], pairs: Float[Array, "3 1"], power: Float[Array, "3 4"]
) -> Gains:
    """Gains that are never modified."""
    for array in (gains, pairs, power):
        array.setflags(write=False)
    return Gains(gains, pairs, power)
