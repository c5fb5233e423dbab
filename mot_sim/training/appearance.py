"""Learning the weights of eq. 5 in closed form, from rendered cars whose identity is known.

Two pictures of one car differ by what time, view, light and occlusion change; two cars differ by
more. With Gaussians for both, the log-likelihood ratio of "one car" against "two cars" is a
squared distance after one linear map (Koestinger et al., CVPR 2012); that map is the weights.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8
from numpy import ndarray as Array
from scipy.linalg import eigh

from mot_sim.files.settings import versions
from mot_sim.simulation import random_numbers
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.scene import Knob, Rollout
from mot_sim.simulation.scenery import find_weather
from mot_sim.simulation.truth.annotate import annotate_frame
from tracker.descriptors import Descriptor, Learned, Weights, features_of
from tracker.errors import BadConfig
from tracker.shape import Hourglass

# Cars that are less visible (KITTI's occlusion 2) or lower are left out.
MIN_VISIBLE_SHARE = 0.2
MIN_HEIGHT_PIXELS = 25.0
# Error of a detector's edges, as a share of the box's sides: RRC's (docs/detector.md).
EDGE_STD = 0.03
# What the shipped weights are learned from: every sixth frame of 35 drives, each in two weathers.
TRAINING_SCENES = (
    "intersection",
    "street",
    "roundabout",
    "merge",
    "gauntlet",
    "highway",
    "stop_and_go",
)
TRAINING_WEATHERS = (
    ("noon", "overcast"),
    ("clear", "dusk"),
    ("low_sun", "noon"),
    ("overcast", "rain"),
    ("noon", "low_sun"),
    ("fog", "clear"),
)
TRAINING_SEEDS = tuple(range(100, 105))
TRAINING_FRAMES = tuple(range(0, 120, 6))
MIN_CARS = 8  # with more than one picture each
# The unit of distance is set by pairs of pictures of one drive at most so many frames apart.
MAX_PAIR_FRAMES = 12
# Features are scaled to equal spread first; spreads below this share of the median are raised.
MIN_SPREAD_SHARE = 0.05


@dataclass(frozen=True, eq=False)
class CarPicture:
    """One image and the cars in it."""

    drive: str
    """Name of the drive; ids are unique within it."""
    frame: int
    """Index of the frame."""
    image: UInt8[Array, "h w 3"]
    """RGB image."""
    boxes: Float[Array, "n 4"]
    """Boxes of the cars: x_min, y_min, x_max, y_max in px."""
    ids: Int[Array, " n"]
    """Id of each car in its drive."""
    visible: Float[Array, " n"]
    """Visible share of each car, 0..1."""


@dataclass(frozen=True)
class RenderedDrive:
    """A run of a scene, drawn in one or more weathers with the same cars."""

    scene: str
    """Name of the scene."""
    seed: int
    """Seed of traffic and cars."""
    weathers: tuple[str, ...]
    """Names of the weathers it is drawn in, at least one."""
    frames: tuple[int, ...]
    """Indices of the frames that are drawn in each weather, at least one."""
    beside: float = 1.0
    """Density of houses, trees and furniture beside the roads; 1 as usual, raising it makes more of
    them."""

    @property
    def name(self) -> str:
        """Scene and seed: car ids are unique within one drive."""
        return f"{self.scene}/{self.seed}"

    @property
    def pictures(self) -> int:
        """How many pictures there are."""
        return len(self.weathers) * len(self.frames)


def training_drives(seeds: Sequence[int] = TRAINING_SEEDS) -> list[RenderedDrive]:
    """The drives that weights are learned from: every scene with every seed."""
    pairs = [(scene, seed) for seed in seeds for scene in TRAINING_SCENES]
    return [
        RenderedDrive(
            scene, seed, TRAINING_WEATHERS[number % len(TRAINING_WEATHERS)], TRAINING_FRAMES
        )
        for number, (scene, seed) in enumerate(pairs)
    ]


def car_pictures(drive: RenderedDrive, edge_std: float = EDGE_STD) -> Iterator[CarPicture]:
    """The pictures of a drive, all frames of one weather and then of the next.

    edge_std: of the boxes' edges, as a share of their sides; drawn by (seed, id, frame).
    """
    beside = dict.fromkeys(("houses", "trees", "furniture"), drive.beside)
    knobs: dict[str, Knob] = {"weather": drive.weathers[0], **beside}
    first = find_scene(drive.scene, frames=max(drive.frames) + 1, **knobs)
    take = Rollout.of(first, drive.seed)
    truths = {}
    for frame in drive.frames:
        world = take.traffic_states[frame]
        scenery = take.scenery_in(world)
        truths[frame] = annotate_frame(world, take.scene_meshes, frame, None, scenery).truth
    for number, weather in enumerate(drive.weathers):
        scene = replace(first, weather=find_weather(weather))
        drawn = RenderedImages(Rollout(scene, drive.seed, take.traffic))
        for frame in drive.frames:
            truth = truths[frame]
            boxes, ids = truth.tracks.boxes, truth.tracks.ids
            key = np.full(len(ids), frame + 100_000 * number)
            sides = np.tile(boxes[:, 2:] - boxes[:, :2], 2)
            off = random_numbers.normal(drive.seed, "identities/boxes", ids, key, 4)
            jittered = take.scene.rig.camera.clip_boxes(boxes + edge_std * sides * off)
            heights = jittered[:, 3] - jittered[:, 1]
            kept = (truth.visible >= MIN_VISIBLE_SHARE) & (heights >= MIN_HEIGHT_PIXELS)
            kept &= jittered[:, 2] - jittered[:, 0] >= 0.5 * MIN_HEIGHT_PIXELS
            image = drawn.render(frame).image
            yield CarPicture(
                drive.name, frame, image, jittered[kept], ids[kept], truth.visible[kept]
            )


@dataclass(frozen=True)
class LearningOptions:
    """How descriptor weights are learned. Raises BadConfig for values that are not allowed."""

    grid: int = 4
    """Cells along each side of the box over which activations are pooled, 1 or more; more keep
    finer detail."""
    length: int = 128
    """Numbers of a descriptor, 1 or more; the features limit it. More keep finer differences."""
    shrink: float = 0.2
    """Share, above 0, to 1, by which the scatter within cars is drawn to a sphere; raising it fits
    the data less closely."""

    def __post_init__(self) -> None:
        if self.grid < 1 or self.length < 1 or not 0.0 < self.shrink <= 1.0:
            raise BadConfig(
                f"grid {self.grid}, length {self.length}, shrink {self.shrink:g}: give 1 or more, "
                "1 or more, and a share above 0, to 1"
            )


@dataclass(frozen=True, eq=False)
class DescriptorDataset:
    """Feature vectors of cars whose identity is known: one row per car and picture."""

    vectors: Float[Array, "n f"]
    """Feature vector of each row."""
    cars: Int[Array, " n"]
    """Identity of each row's car, unique over all drives."""
    drives: Int[Array, " n"]
    """Number of the drive of each row."""
    frames: Int[Array, " n"]
    """Frame in which each row's car was seen."""

    @classmethod
    def of(
        cls, pictures: Iterable[CarPicture], look: Callable[[CarPicture], Float[Array, "m f"]]
    ) -> "DescriptorDataset":
        """The vectors of all boxes of all pictures; boxes without one are left out.

        Raises BadConfig if fewer than MIN_CARS cars are seen more than once.
        """
        parts: list[tuple[Array, ...]] = []
        names: dict[str, int] = {}
        for picture in pictures:
            vectors = look(picture)
            known = np.flatnonzero(np.isfinite(vectors).all(axis=1))
            drive = names.setdefault(picture.drive, len(names))
            where = np.full(len(known), drive), np.full(len(known), picture.frame)
            parts.append((vectors[known], picture.ids[known] + (drive << 32), *where))
        if not parts:
            raise BadConfig("no pictures to learn from: give some drives")
        whole = cls(*(np.concatenate(column) for column in zip(*parts, strict=True)))
        _, car, count = np.unique(whole.cars, return_inverse=True, return_counts=True)
        if np.count_nonzero(count > 1) < MIN_CARS:
            raise BadConfig(
                f"{np.count_nonzero(count > 1)} cars are seen more than once: at least "
                f"{MIN_CARS} are needed, give more drives or more frames"
            )
        return whole.select(count[car] > 1)

    def select(self, rows: Bool[Array, " n"]) -> "DescriptorDataset":
        """Some of the rows."""
        return DescriptorDataset(
            self.vectors[rows], self.cars[rows], self.drives[rows], self.frames[rows]
        )


@dataclass(frozen=True, eq=False)
class LearnedDescriptor:
    """Learned weights, and the descriptors that they give the cars they were learned from."""

    weights: Weights
    """The weights, with the unit of distance."""
    described: DescriptorDataset
    """The data that they were learned from, with descriptors as vectors."""

    @property
    def equal_error(self) -> float:
        """The share of pairs on the wrong side of the unit of distance, equal for both kinds."""
        same, _ = pair_distances(self.described)
        return float((same > self.weights.unit).mean())

    @property
    def summary(self) -> str:
        """How much was learned from, and how well one car is told from two, in one line."""
        cars, sightings = len(np.unique(self.described.cars)), len(self.described.cars)
        return (
            f"{cars} cars, {sightings} sightings; one car or two: "
            f"{100 * self.equal_error:.1f} % wrong of either, at distance {self.weights.unit:.4f}"
        )

    def provenance(
        self, drives: Sequence[RenderedDrive], options: LearningOptions
    ) -> dict[str, object]:
        """How the weights were made, to be stored with them."""
        return {
            "drives": [asdict(drive) for drive in drives],
            "options": asdict(options),
            "edge_std": EDGE_STD,
            "cars": len(np.unique(self.described.cars)),
            "sightings": len(self.described.cars),
            "equal_error": round(self.equal_error, 4),
            "versions": versions(),
        }


def learn_descriptor(
    pictures: Iterable[CarPicture], hourglass: Hourglass, options: LearningOptions | None = None
) -> LearnedDescriptor:
    """The weights for a network's activations. Raises BadConfig for too few cars."""
    options = options or LearningOptions()

    def look(picture: CarPicture) -> Float[Array, "m f"]:
        maps = hourglass(np.ascontiguousarray(picture.image[:, :, ::-1]), picture.boxes).activations
        return features_of(picture.image, picture.boxes, maps, options.grid).astype(float)

    dataset = DescriptorDataset.of(pictures, look)
    spread = dataset.vectors.std(axis=0)
    spread = np.maximum(spread, MIN_SPREAD_SHARE * np.median(spread)) + 1e-9
    even = replace(dataset, vectors=dataset.vectors / spread)
    mean, axes = likelihood_map(even, options.length, options.shrink)
    mean, axes = mean * spread, axes / spread[:, None]
    arrays = axes.astype(np.float32), mean.astype(np.float32)
    content = Weights(*arrays, options.grid, hourglass.sha256, 1.0)
    described = replace(dataset, vectors=Learned(*content).project(dataset.vectors.astype("f4")))
    return LearnedDescriptor(content._replace(unit=unit_of(described)), described)


def likelihood_map(
    dataset: DescriptorDataset, length: int, shrink: float
) -> tuple[Float[Array, " f"], Float[Array, "f d"]]:
    """The mean of the vectors, and the map after which a squared distance tells one car from two.

    Cars are compared with those of their own drive: what all cars of a drive have in common, its
    light for example, does not distinguish them.
    """
    x, car = dataset.vectors, np.unique(dataset.cars, return_inverse=True)[1]
    count = np.bincount(car)
    means = np.zeros((len(count), x.shape[1]))
    np.add.at(means, car, x)
    means /= count[:, None]
    off = x - means[car]
    within = off.T @ off / (len(x) - len(count))
    blur = (1.0 / count).mean() * within  # the error of means of so few pictures
    within = (1.0 - shrink) * within + shrink * np.trace(within) / len(within) * np.eye(len(within))
    drive = np.zeros(len(count), np.int64)
    drive[car] = dataset.drives
    for number in np.unique(drive):
        means[drive == number] -= means[drive == number].mean(axis=0)
    between = means.T @ means / max(len(count) - len(np.unique(drive)), 1) - blur
    size = len(within)
    ratio, axes = eigh(between, within, subset_by_index=[max(size - length, 0), size - 1])
    ratio = np.maximum(ratio, 0.0)
    # In these axes one car's sightings differ by variance 2, two cars' by 2 + 2 ratio.
    return x.mean(axis=0), axes * np.sqrt(ratio / (1.0 + ratio))


def unit_of(dataset: DescriptorDataset) -> float:
    """The distance with equal errors: pairs of one car beyond it, pairs of two cars within it.

    Pairs are of one drive, in two frames at most MAX_PAIR_FRAMES apart: what a tracker compares.
    """
    same, other = pair_distances(dataset)
    edges = np.sort(np.concatenate((same, other)))
    missed = 1.0 - np.searchsorted(np.sort(same), edges, side="right") / len(same)
    taken = np.searchsorted(np.sort(other), edges, side="right") / len(other)
    return float(edges[np.argmax(taken >= missed)])


def pair_distances(dataset: DescriptorDataset) -> tuple[Float[Array, " s"], Float[Array, " o"]]:
    """Distances of pairs of one car, and of pairs of two cars."""
    same, other = [], []
    for drive in np.unique(dataset.drives):
        some = dataset.select(dataset.drives == drive)
        square = (some.vectors**2).sum(axis=1)
        distance = square[:, None] + square - 2.0 * some.vectors @ some.vectors.T
        apart = np.abs(some.frames[:, None] - some.frames)
        rows, columns = np.nonzero(np.triu((apart > 0) & (apart <= MAX_PAIR_FRAMES)))
        one = some.cars[rows] == some.cars[columns]
        found = np.sqrt(np.maximum(distance[rows, columns], 0.0))
        same.append(found[one])
        other.append(found[~one])
    return np.concatenate(same), np.concatenate(other)


def unit_of_descriptor(pictures: Iterable[CarPicture], descriptor: Descriptor) -> float:
    """The unit of a descriptor that needs no network, in its own lengths."""
    return unit_of(DescriptorDataset.of(pictures, lambda each: descriptor(each.image, each.boxes)))
