"""Pictures of cars with their identities, from which the weights of eq. 5 are learned."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int, UInt8
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.scene import Knob, Rollout
from mot_sim.simulation.scenery import find_weather
from mot_sim.simulation.truth.annotate import annotate_frame

# A car is shown from so much of it visible on (KITTI's occlusion 2), and from so many pixels high.
MIN_VISIBLE_SHARE = 0.2
MIN_HEIGHT_PIXELS = 25.0
# How far a detector's edges are off, as a share of the box's sides: RRC's (docs/detector.md).
EDGE_STD = 0.03


@dataclass(frozen=True, eq=False)
class CarPicture:
    """One picture (RGB) and the cars in it; ids are those of one drive. visible: fractions."""

    drive: str
    frame: int
    image: UInt8[Array, "h w 3"]
    boxes: Float[Array, "n 4"]
    ids: Int[Array, " n"]
    visible: Float[Array, " n"]


@dataclass(frozen=True)
class RenderedDrive:
    """A run of a scene, drawn in one or more weathers; the cars are the same in all of them.

    frames: those that are drawn, in each weather. beside: how many houses, trees and lamps stand
    beside the roads, 1 as usual.
    """

    scene: str
    seed: int
    weathers: tuple[str, ...]
    frames: tuple[int, ...]
    beside: float = 1.0

    @property
    def name(self) -> str:
        """How the cars of this drive are told from those of others."""
        return f"{self.scene}/{self.seed}"

    @property
    def pictures(self) -> int:
        """How many there are."""
        return len(self.weathers) * len(self.frames)


# What the shipped weights are learned from: every sixth frame of 35 drives, each in two weathers.
TRAINING_SCENES = (
    "intersection", "street", "roundabout", "merge", "gauntlet", "highway", "stop_and_go",
)  # fmt: skip
TRAINING_WEATHERS = (
    ("noon", "overcast"), ("clear", "dusk"), ("low_sun", "noon"), ("overcast", "rain"),
    ("noon", "low_sun"), ("fog", "clear"),
)  # fmt: skip
TRAINING_SEEDS = tuple(range(100, 105))
TRAINING_FRAMES = tuple(range(0, 120, 6))


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
