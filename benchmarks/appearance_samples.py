"""Cars with their identities, synthetic and real, and how often the nearest descriptor is theirs.

Called by `benchmarks.appearance`.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy import ndarray as Array

from mot_sim.datasets import kitti_sequence
from mot_sim.training.appearance import MIN_HEIGHT_PIXELS, CarPicture, RenderedDrive, car_pictures

GAPS = (1, 5, 10)  # frames
STARTS = range(0, 120, 10)
FRAMES = tuple(sorted({start + gap for start in STARTS for gap in (0, *GAPS)}))
# Other seeds than those of `training_drives`, which has no T-junction.
ORDINARY = (
    RenderedDrive("t_junction", 900, ("noon",), FRAMES),
    RenderedDrive("intersection", 901, ("overcast",), FRAMES),
    RenderedDrive("street", 902, ("low_sun",), FRAMES),
    RenderedDrive("roundabout", 903, ("noon",), FRAMES),
)
LOOK_ALIKES = (
    RenderedDrive("look_alikes", 904, ("noon",), FRAMES),
    RenderedDrive("look_alikes", 905, ("overcast",), FRAMES),
)
# The frames of KITTI that have images and given labels.
CLIPS = {"0000": range(154), "0005": range(16), "0009": range(47, 63)}
CROP = 64  # pixels of the pictures that are kept for the sheet

Look = Callable[[CarPicture], Array]


@dataclass(frozen=True, eq=False)
class Seen:
    """One picture's cars: ids, descriptors by the name of what made them, and small pictures."""

    drive: str
    frame: int
    ids: Array
    vectors: dict[str, Array]
    crops: list[Array]


def synthetic(drives: Iterable[RenderedDrive]) -> Iterator[CarPicture]:
    """The pictures of drives."""
    for drive in drives:
        yield from car_pictures(drive)


def real(root: Path) -> Iterator[CarPicture]:
    """The labelled cars and vans of the clips, as high and as little hidden as the synthetic."""
    for name, frames in CLIPS.items():
        sequence = kitti_sequence(root, name, None, "none", images=True).subset(frames)
        truth = sequence.truth
        assert truth is not None
        assert truth.kinds is not None
        assert truth.occlusion is not None
        cars = np.isin(truth.kinds, ["Car", "Van"]) & (truth.ids >= 0) & (truth.occlusion <= 2)
        cars &= truth.boxes[:, 3] - truth.boxes[:, 1] >= MIN_HEIGHT_PIXELS
        for frame in sequence:
            assert frame.image is not None
            some = truth.select(cars & (truth.frames == frame.index))
            visible = np.ones(len(some))
            yield CarPicture(name, frame.index, frame.image, some.boxes, some.ids, visible)


def seen_by(pictures: Iterable[CarPicture], looks: dict[str, Look]) -> list[Seen]:
    """The pictures with the descriptors of all contenders."""
    return [
        Seen(
            picture.drive,
            picture.frame,
            picture.ids,
            {name: look(picture) for name, look in looks.items()},
            [crop_of(picture.image, box) for box in picture.boxes],
        )
        for picture in pictures
    ]


def crop_of(image: Array, box: Array) -> Array:
    """A small picture of what is in a box."""
    left, top, right, bottom = np.round(box).astype(int)
    part = image[max(top, 0) : bottom + 1, max(left, 0) : right + 1]
    return cv2.resize(part, (CROP * 3 // 2, CROP), interpolation=cv2.INTER_AREA)


@dataclass(frozen=True, eq=False)
class Matches:
    """hits of queries; chance: what guessing would hit. confused: how often whom for whom."""

    hits: int
    queries: int
    chance: float
    confused: Counter[tuple[str, int, int]]

    @property
    def rank1(self) -> float:
        """The share of queries whose nearest descriptor is of the same car."""
        return self.hits / self.queries if self.queries else float("nan")


def matches(seen: list[Seen], name: str, gap: int, memory: float = 0.0) -> Matches:
    """Every car of every frame looks for itself among all cars of the frame `gap` later.

    Only cars that are there again ask, and only where there is a choice. memory: the share that
    the mean of what was seen before keeps when a car is seen again; 0: the latest is asked with.
    """
    later = {(one.drive, one.frame): one for one in seen}
    hits = queries = 0
    chance, confused = 0.0, Counter[tuple[str, int, int]]()
    remembered: dict[tuple[str, int], Array] = {}
    for one in seen:
        vectors = one.vectors[name].copy()
        for row, number in enumerate(one.ids.tolist()):
            before = remembered.get((one.drive, number), vectors[row])
            vectors[row] = memory * before + (1.0 - memory) * vectors[row]
            remembered[one.drive, number] = vectors[row]
        other = later.get((one.drive, one.frame + gap))
        if other is None or len(other.ids) < 2:
            continue
        asking = np.isin(one.ids, other.ids) & np.isfinite(vectors).all(axis=1)
        square = ((vectors[asking][:, None] - other.vectors[name][None]) ** 2).sum(axis=2)
        if not len(square):
            continue
        found = other.ids[np.nan_to_num(square, nan=np.inf).argmin(axis=1)]
        wanted = one.ids[asking]
        hits += int((found == wanted).sum())
        queries += len(wanted)
        chance += len(wanted) / len(other.ids)
        wrong = found != wanted
        confused.update(
            (one.drive, a, b)
            for a, b in zip(wanted[wrong].tolist(), found[wrong].tolist(), strict=True)
        )
    return Matches(hits, queries, chance / max(queries, 1), confused)
