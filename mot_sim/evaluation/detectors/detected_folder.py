"""Drives of images to look at, and a folder of what a detector found in them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray as Array

from mot_sim.datasets.images import ImageFolder
from mot_sim.datasets.kitti.labels import NO_ALPHA, NO_CUBOID
from mot_sim.datasets.recorded import DetectionLog
from mot_sim.files.resumable_folder import TextPartsFolder
from mot_sim.files.text import what_is_there
from mot_sim.files.writing import write_lines
from tracker.errors import DatasetNotFound
from tracker.types import Detections

KITTI_IMAGES = ("training/image_02", "testing/image_02", "image_02")


def image_drives(folder: Path) -> dict[str, ImageFolder]:
    """The drives of numbered images in a folder, by name.

    A KITTI tree (that of `mot-sim record` too), a folder of folders of images, or one of images,
    which is a drive of the folder's name. Raises DatasetNotFound where there are none.
    """
    home = next((folder / inner for inner in KITTI_IMAGES if (folder / inner).is_dir()), folder)
    alone = ImageFolder.find(home)
    if alone is not None:
        return {home.resolve().name: alone}
    inner = sorted(path for path in home.iterdir() if path.is_dir()) if home.is_dir() else []
    drives = {path.name: ImageFolder.find(path) for path in inner}
    found = {name: images for name, images in drives.items() if images is not None}
    if not found:
        there = what_is_there(folder, "no numbered images in it")
        raise DatasetNotFound(
            f"{folder}: {there}; give images named 000000.png, folders of them, or a KITTI tree "
            "(record one without --no-images)"
        )
    return found


def detect_in(
    detector: Callable[[UInt8[Array, "h w 3"]], Detections],
    images: ImageFolder,
    tell: Callable[[], None] = lambda: None,
) -> DetectionLog:
    """What a detector finds in every image of a drive. tell: called after each."""
    frames, parts = [], []
    for frame in sorted(images.paths):
        image = images.load(frame)
        assert image is not None  # it has a path
        found = detector(image)
        frames.append(np.full(len(found), frame))
        parts.append(found)
        tell()
    return DetectionLog(np.concatenate(frames), Detections.concatenate(parts))


def kitti_rows(log: DetectionLog) -> list[str]:
    """Detections as rows of KITTI's results, which all commands read: ids are -1, no cuboids."""
    cuboid = " ".join(f"{number:g}" for number in NO_CUBOID)
    found, rows = log.detections, []
    kinds = np.full(len(found), "Car") if found.kinds is None else found.kinds
    for frame, kind, box, score in zip(log.frames, kinds, found.boxes, found.scores, strict=True):
        corners = " ".join(f"{side:.6f}" for side in box)
        rows.append(f"{frame} -1 {kind} -1 -1 {NO_ALPHA:g} {corners} {cuboid} {score:.9g}")
    return rows


@dataclass(eq=False)
class DetectedFolder(TextPartsFolder):
    """`NAME.txt` of each finished drive, and `detect.json`; see `ResumableFolder`."""

    FILE = "detect.json"
    PARTS = "drives"
    STRANGE = "no detections of ours"
    DAMAGED = "not detections of ours"
    STANDS = "holds detections already; --resume does the rest, --overwrite replaces them"

    finished: dict[str, int] = field(default_factory=dict)
    """How many boxes were found in each finished drive."""

    @classmethod
    def parse(cls, told: Any, file: Path) -> dict[str, int]:
        """The finished drives that a `detect.json` names."""
        parts = {name: int(count) for name, count in told.items()}
        if any(Path(name).name != name for name in parts):
            raise ValueError("a drive is named like a path")
        return parts

    def add(self, name: str, log: DetectionLog) -> None:
        """Keep a finished drive."""
        self.finished[name] = len(log.frames)
        try:
            self.write()
            write_lines(self.result(name), kitti_rows(log))
        except BaseException:
            del self.finished[name]
            raise

    def describe(self) -> tuple[bool, dict[str, int]]:
        """Whether all drives are finished; the boxes of each."""
        return all(name in self.finished for name in self.wanted), dict(self.finished)
