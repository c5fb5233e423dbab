"""The life of a labelled car before its first label and after its last one.

Annotators begin with a car when it is large enough and end with it when little is left; detectors
see it earlier and later: RRC finds 38 % of KITTI's cars a frame before their first label. Without
that life a tracker that waits for several boxes before it reports a car is always late in a
re-enacted drive, and never on KITTI.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.matching import EPSILON
from mot_sim.metrics.preprocessing import in_dont_care
from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.checks import require_rates, require_table
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.errors import BadConfig
from tracker.types import Camera, Tracks

LIFE_SECONDS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.3, 1.6)  # from the label
TREND_ROWS = 4  # of labels, from which a car's path goes on
MIN_SIDE_PIXELS = 3.0  # of an extrapolated box inside the image; what is smaller has no row
BEFORE, AFTER, IN_DONT_CARE = 1, 2, 3  # of Sightings.unlabelled
NONE = (0.0,) * len(LIFE_SECONDS)


@dataclass(frozen=True)
class Lives:
    """How long cars are there before and after their labels; only for drives from labels."""

    before: tuple[float, ...] = NONE
    """Share of the cars, 0 to 1, that are there at each of LIFE_SECONDS before their first label,
    never rising; more: cars are seen earlier than they are labelled."""
    after: tuple[float, ...] = NONE
    """The same after their last label."""
    before_dont_care: tuple[float, ...] = NONE
    """Of `before`, where the box lies in a DontCare region: annotators saw something there."""
    after_dont_care: tuple[float, ...] = NONE
    """Of `after`, where the box lies in a DontCare region."""

    def __post_init__(self) -> None:
        for name in ("before", "after", "before_dont_care", "after_dont_care"):
            shares = getattr(self, name)
            require_table(f"lives {name}", LIFE_SECONDS, shares)
            require_rates(f"lives {name}", *shares)
            if any(later > sooner for sooner, later in pairwise(shares)):
                raise BadConfig(f"lives {name} {shares}: who is there was there before: falling")

    def __call__(
        self,
        sightings: Sightings,
        seed: int,
        camera: Camera,
        frame_count: int,
        step: float,
        labels: Tracks | None = None,
    ) -> Sightings:
        """The sightings with the rows of those lives; step: seconds between frames.

        labels: with the DontCare regions; None: there are none.
        """
        lags, more = beside_labels(sightings, camera, frame_count, step, labels)
        if more.unlabelled is None or not len(more):
            return sightings
        inside = more.unlabelled == IN_DONT_CARE
        chance = random_numbers.uniform(seed, "lives", more.ids, np.zeros_like(more.ids), 2)
        there = np.where(
            lags < 0,
            chance[:, 0] < _share(self.before, self.before_dont_care, inside, -lags * step),
            chance[:, 1] < _share(self.after, self.after_dont_care, inside, lags * step),
        )
        labelled = replace(sightings, unlabelled=np.zeros(len(sightings), np.int64))
        both = Sightings.concatenate([labelled, more.select(there)])
        return both.select(np.lexsort((both.ids, both.frames)))

    def scaled(self, factor: float) -> "Lives":
        """The same with shares outside DontCare regions times a factor, at most 1."""
        before, after = (
            tuple(round(min(factor * share, 1.0), 4) for share in shares)
            for shares in (self.before, self.after)
        )
        return replace(self, before=before, after=after)


def share_at(shares: tuple[float, ...], seconds: Float[Array, " n"]) -> Float[Array, " n"]:
    """The share that is there so long before or after the label; none beyond LIFE_SECONDS."""
    return np.interp(seconds, LIFE_SECONDS, shares, right=0.0)


def _share(
    outside: tuple[float, ...],
    inside: tuple[float, ...],
    is_inside: Bool[Array, " n"],
    seconds: Float[Array, " n"],
) -> Float[Array, " n"]:
    return np.where(is_inside, share_at(inside, seconds), share_at(outside, seconds))


def in_regions(rows: Sightings, labels: Tracks | None) -> Bool[Array, " n"]:
    """Whose box lies in a DontCare region of the labels."""
    if labels is None or labels.kinds is None:
        return np.zeros(len(rows), bool)
    regions = labels.select(labels.kinds == "DontCare")
    regions = regions.select(np.argsort(regions.frames, kind="stable"))
    return in_dont_care(rows.frames, rows.boxes, regions, EPSILON)


def beside_labels(
    sightings: Sightings, camera: Camera, frame_count: int, step: float, labels: Tracks | None
) -> tuple[Int[Array, " m"], Sightings]:
    """What `extrapolated` gives; `unlabelled` tells the side, and who is in a DontCare region."""
    lags, rows = extrapolated(sightings, camera, frame_count, step)
    side = np.where(lags < 0, BEFORE, AFTER)
    side = np.where(in_regions(rows, labels), IN_DONT_CARE, side)
    return lags, replace(rows, unlabelled=side)


def extrapolated(
    sightings: Sightings, camera: Camera, frame_count: int, step: float
) -> tuple[Int[Array, " m"], Sightings]:
    """Rows of all cars for all of LIFE_SECONDS; beside each, frames from the label, before: < 0.

    Box and place go on as they moved over the first or the last TREND_ROWS rows; all else stays
    as it was. Rows outside the drive and boxes (nearly) outside the image are left out.
    """
    most = round(LIFE_SECONDS[-1] / step)
    order = np.lexsort((sightings.frames, sightings.ids))
    ids, frames = sightings.ids[order], sightings.frames[order]
    if not len(order) or most < 1:
        return np.zeros(0, np.int64), sightings.select(np.zeros(0, np.int64))
    starts = np.flatnonzero(np.concatenate(([True], ids[1:] != ids[:-1])))
    ends = np.concatenate((starts[1:], [len(ids)])) - 1
    parts = []
    for edges, others, side in (
        (starts, np.minimum(starts + TREND_ROWS - 1, ends), -1),
        (ends, np.maximum(ends - TREND_ROWS + 1, starts), 1),
    ):
        edge, other = np.repeat(edges, most), np.repeat(others, most)
        lags = side * np.tile(np.arange(1, most + 1), len(edges))
        inside = (frames[edge] + lags >= 0) & (frames[edge] + lags < frame_count)
        parts.append((order[edge[inside]], order[other[inside]], lags[inside]))
    edge, other, lags = (np.concatenate(column) for column in zip(*parts, strict=True))
    return _usable(lags, _moved(sightings, edge, other, lags, camera))


def _moved(
    sightings: Sightings,
    edge: Int[Array, " m"],
    other: Int[Array, " m"],
    lags: Int[Array, " m"],
    camera: Camera,
) -> Sightings:
    """The sightings of the rows `edge`, `lags` frames further on the way from or to `other`."""
    apart = sightings.frames[edge] - sightings.frames[other]
    far = np.where(apart == 0, 0.0, lags / np.where(apart == 0, 1, apart))
    rows = sightings.select(edge)

    def further(values: Float[Array, "n *k"]) -> Float[Array, "m *k"]:
        factor = far.reshape(-1, *[1] * (values.ndim - 1))
        moved: Array = values[edge] + factor * (values[edge] - values[other])
        return moved

    cuboids = rows.cuboids
    if cuboids is not None and sightings.cuboids is not None:
        cuboids = replace(cuboids, base=further(sightings.cuboids.base))
    return replace(
        rows,
        frames=rows.frames + lags,
        boxes=camera.clip_boxes(further(sightings.boxes)),
        amodal_boxes=further(sightings.amodal_boxes),
        visible_boxes=camera.clip_boxes(further(sightings.visible_boxes)),
        depth=further(sightings.depth),
        cuboids=cuboids,
    )


def _usable(lags: Int[Array, " m"], rows: Sightings) -> tuple[Int[Array, " k"], Sightings]:
    """The rows whose box is one, and is inside the image."""
    sides = np.minimum(
        rows.boxes[:, 2:] - rows.boxes[:, :2], rows.amodal_boxes[:, 2:] - rows.amodal_boxes[:, :2]
    )
    usable: Bool[Array, " m"] = (sides >= MIN_SIDE_PIXELS).all(axis=1)
    return lags[usable], rows.select(usable)
