"""How much cuboids agree: intersection over union of their volumes, distance of their centres."""

from dataclasses import dataclass
from math import inf, isfinite

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.errors import BadConfig
from tracker.geometry import convex_intersection
from tracker.types import Cuboids


def known_cuboids(cuboids: Cuboids) -> Bool[Array, " n"]:
    """Which rows hold a whole cuboid: place, heading and size; NaN stands for what is unknown."""
    numbers = np.column_stack([cuboids.base, cuboids.yaw, cuboids.size])
    return np.asarray(np.isfinite(numbers).all(axis=1))


def cuboid_iou(a: Cuboids, b: Cuboids) -> Float[Array, " n"]:
    """Intersection over union of the volumes of cuboid i of a and cuboid i of b.

    Both are upright in one frame: the area that the footprints share (exact polygons) times the
    height that the cuboids share. A heading off by pi makes no difference. 0 for cuboids that are
    not wholly known.
    """
    height = np.minimum(a.base[:, 1], b.base[:, 1])
    height -= np.maximum(a.base[:, 1] - a.size[:, 1], b.base[:, 1] - b.size[:, 1])
    reach = 0.5 * (np.hypot(a.size[:, 0], a.size[:, 2]) + np.hypot(b.size[:, 0], b.size[:, 2]))
    near = (height > 0.0) & (centre_distance(a, b) < reach)
    near &= known_cuboids(a) & known_cuboids(b)
    iou = np.zeros(len(near))
    if near.any():
        a, b = a.select(near), b.select(near)
        shared = convex_intersection(a.footprint(), b.footprint()) * height[near]
        iou[near] = shared / (a.size.prod(axis=1) + b.size.prod(axis=1) - shared)
    return iou


def centre_distance(a: Cuboids, b: Cuboids) -> Float[Array, " n"]:
    """Distance of the centres of cuboid i of a and cuboid i of b, seen from above, m."""
    return np.hypot(a.base[:, 0] - b.base[:, 0], a.base[:, 2] - b.base[:, 2])


@dataclass(frozen=True)
class Criterion:
    """What makes a cuboid a match of a label: 3D IoU of at least, or centres within metres.

    Raises BadConfig for thresholds that nothing or everything would meet.
    """

    measure: str
    """iou or distance, the latter seen from above."""
    threshold: float
    """Least 3D IoU in (0, 1], or the largest distance, m, finite and > 0."""

    def __post_init__(self) -> None:
        if self.measure not in ("iou", "distance"):
            raise BadConfig(f"criterion {self.measure!r}: give iou or distance")
        most = 1.0 if self.measure == "iou" else inf
        if not (0.0 < self.threshold <= most and isfinite(self.threshold)):
            what = "IoU thresholds are in (0, 1]" if most == 1.0 else "distances are above 0 m"
            raise BadConfig(
                f"3D threshold {self.threshold:g}: {what}; write .25 for IoU, 2m for metres"
            )

    @classmethod
    def parse(cls, text: str) -> "Criterion":
        """From `.25` (3D IoU) or `2m` (distance of the centres). Raises BadConfig."""
        word = text.strip().lower()
        try:
            if word.endswith("m"):
                return cls("distance", float(word[:-1]))
            return cls("iou", float(word))
        except ValueError:
            raise BadConfig(
                f"3D threshold {text!r}: write .25 for IoU, 2m for the distance of centres"
            ) from None

    @property
    def name(self) -> str:
        """How tables name it: `0.25` or `2m`."""
        return f"{self.threshold:g}" + ("m" if self.measure == "distance" else "")

    @property
    def least(self) -> float:
        """The least similarity of a match."""
        return self.threshold if self.measure == "iou" else 0.5

    def similarity(self, a: Cuboids, b: Cuboids) -> Float[Array, " n"]:
        """How alike cuboid i of a and cuboid i of b are, in [0, 1]; 0 where something is unknown.

        3D IoU; or 1 at one place, falling evenly to 1/2 at the threshold and 0 at twice it.
        """
        if self.measure == "iou":
            return cuboid_iou(a, b)
        apart = centre_distance(a, b) / (2.0 * self.threshold)
        return np.maximum(1.0 - np.where(np.isfinite(apart), apart, 1.0), 0.0)

    def precision(self, similarity: float) -> float:
        """A mean similarity of matches as people read it: IoU, or metres between centres."""
        if self.measure == "iou":
            return similarity
        return 2.0 * self.threshold * (1.0 - similarity)
