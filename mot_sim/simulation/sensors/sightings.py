"""What a detector could see of the objects of a drive: from exact truth, or from KITTI's labels."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, Shaped, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.cars import Vehicles
from mot_sim.simulation.truth import Truth
from tracker.types import Cuboids, Rows, Tracks

VEHICLES = ("Car", "Van", "Truck")
# The visible fraction that stands for KITTI's occlusion levels 0, 1, 2, and 3 (unknown: RRC finds
# .89 of those cars, as many as of the partly occluded ones); the part of the box outside the image
# that stands for truncation 0, 1, 2. Annotators judged by eye: middles of their levels.
LABEL_VISIBLE = np.array([0.95, 0.65, 0.35, 0.65])
LABEL_TRUNCATION = np.array([0.0, 0.2, 0.6])
PASSAGE_FRAMES = 4  # before and after, over which a change of level is spread


@dataclass(frozen=True, eq=False)
class Sightings(Rows):
    """What the chain of effects needs to know: one row per frame and object, in that order."""

    frames: Int[Array, " n"]
    """The frame."""
    ids: Int[Array, " n"]
    """The object."""
    boxes: Float[Array, "n 4"]
    """Inside the image, pixels."""
    amodal_boxes: Float[Array, "n 4"]
    """Not clipped to the image, pixels; of labels the same as `boxes`."""
    visible_boxes: Float[Array, "n 4"]
    """Around the visible pixels; NaN where unknown."""
    visible: Float[Array, " n"]
    """Visible fraction, 0 to 1."""
    truncation: Float[Array, " n"]
    """Part of the amodal box outside the image, 0 to 1."""
    depth: Float[Array, " n"]
    """Metres along the road's z; NaN where unknown."""
    kinds: Shaped[Array, " n"]
    """Class, as KITTI spells it."""
    cuboids: Cuboids | None = None
    """In the road frame; None: unknown."""
    keypoints: Float[Array, "n k 2"] | None = None
    """Pixels, NaN behind the camera; None: unknown."""
    keypoint_states: UInt8[Array, "n k"] | None = None
    """0 visible, 1 self-occluded, 2 occluded by another, 3 truncated; None: unknown."""
    shape: Float[Array, "n b"] | None = None
    """Coefficients of eq. 1; None: unknown."""
    unlabelled: Int[Array, " n"] | None = None
    """0 with a label, 1 before a car's first one, 2 after its last one, 3 either of both inside a
    DontCare region; None: all have labels."""

    @property
    def height(self) -> Float[Array, " n"]:
        """Pixels from the upper to the lower edge, inside the image."""
        return self.boxes[:, 3] - self.boxes[:, 1]

    @classmethod
    def from_truth(cls, truth: Truth, vehicles: Vehicles | None = None) -> "Sightings":
        """Of a synthetic episode; vehicles: who the cars are, where shapes are to be seen too."""
        tracks = truth.tracks
        return cls(
            frames=tracks.frames,
            ids=tracks.ids,
            boxes=tracks.boxes,
            amodal_boxes=truth.amodal_boxes,
            visible_boxes=truth.visible_boxes,
            visible=truth.visible,
            truncation=truth.truncation,
            depth=_depth(tracks),
            kinds=_kinds(tracks),
            cuboids=tracks.cuboids,
            keypoints=truth.keypoints,
            keypoint_states=truth.keypoint_states,
            shape=None if vehicles is None else vehicles.coefficients[vehicles.rows(tracks.ids)],
        )

    @classmethod
    def from_labels(cls, labels: Tracks) -> "Sightings":
        """Of a real drive: its cars, vans and trucks; the visible fraction from KITTI's levels.

        A car whose level changes passes through what lies between, over 0.9 s.
        """
        vehicles = np.isin(_kinds(labels), VEHICLES) & (labels.ids >= 0)
        rows = np.flatnonzero(vehicles)
        rows = rows[np.argsort(labels.frames[rows], kind="stable")]
        labels = labels.select(rows)
        none = np.zeros(len(labels), np.int64)
        occlusion = none if labels.occlusion is None else labels.occlusion.clip(0, 3)
        levels = none if labels.truncation is None else labels.truncation.clip(0, 2)
        truncations = np.where(levels > 0, _passing(LABEL_TRUNCATION[levels], labels), 0.0)
        return cls(
            frames=labels.frames,
            ids=labels.ids,
            boxes=labels.boxes,
            amodal_boxes=labels.boxes,
            visible_boxes=np.full((len(labels), 4), np.nan),
            visible=_passing(LABEL_VISIBLE[occlusion], labels),
            truncation=truncations,
            depth=_depth(labels),
            kinds=_kinds(labels),
            cuboids=labels.cuboids,
        )


def _passing(values: Float[Array, " n"], labels: Tracks) -> Float[Array, " n"]:
    """The mean of each object's values over the frames about each one, as far as it is there."""
    if not len(values):
        return values
    code = labels.ids * (1 << 32) + labels.frames
    order = np.argsort(code, kind="stable")
    total, count = np.zeros(len(code)), np.zeros(len(code))
    for lag in range(-PASSAGE_FRAMES, PASSAGE_FRAMES + 1):
        at = order[np.searchsorted(code[order], code + lag).clip(max=len(code) - 1)]
        there = code[at] == code + lag
        total += np.where(there, values[at], 0.0)
        count += there
    return np.round(total / count, 6)


def _depth(tracks: Tracks) -> Float[Array, " n"]:
    return np.full(len(tracks), np.nan) if tracks.cuboids is None else tracks.cuboids.base[:, 2]


def _kinds(tracks: Tracks) -> Shaped[Array, " n"]:
    return np.full(len(tracks), "Car", "<U8") if tracks.kinds is None else tracks.kinds
