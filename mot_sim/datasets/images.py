"""Folders of numbered images: found once, decoded one at a time when somebody asks."""

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import cv2
import numpy as np
from jaxtyping import UInt8
from numpy import ndarray as Array

from tracker.errors import BadFile, DatasetNotFound

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp")

log = logging.getLogger(__name__)


@runtime_checkable
class ImageSource(Protocol):
    """What has the images of a drive: a folder, or something that draws them."""

    def load(self, frame: int) -> UInt8[Array, "h w 3"] | None:
        """The RGB image of a frame; None when there is none for it."""
        ...


@dataclass(frozen=True, eq=False)
class ImageFolder:
    """The numbered images of one drive: 000000.png is frame `first_frame`, and so on."""

    paths: dict[int, Path]
    image_size: tuple[int, int]

    @classmethod
    def find(cls, folder: Path, first_frame: int = 0) -> "ImageFolder | None":
        """The images of a folder whose names are numbers; None when there are none.

        The first image is decoded for its size. first_frame: the number in the name of frame 0.
        """
        if not folder.is_dir():
            return None
        paths = {
            int(path.stem) - first_frame: path
            for path in sorted(folder.iterdir())
            if path.suffix.lower() in SUFFIXES and path.stem.isdecimal()
        }
        if not paths:
            return None
        height, width = _decode(paths[min(paths)]).shape[:2]
        return cls(paths, (width, height))

    @classmethod
    def require(cls, folder: Path, first_frame: int = 0) -> "ImageFolder":
        """Like `find`; raises DatasetNotFound when there are no numbered images."""
        found = cls.find(folder, first_frame)
        if found is None:
            there = "no numbered images in it" if folder.is_dir() else "no such folder"
            raise DatasetNotFound(
                f"{folder}: {there}; give images named 000000.png, or ask for none"
            )
        return found

    def warn_of_gaps(self, frame_count: int) -> None:
        """Log how many frames have no image, if some have none."""
        found = sum(frame in self.paths for frame in range(frame_count))
        if found < frame_count:
            folder = self.paths[min(self.paths)].parent
            log.warning("%s: images for %d of %d frames only", folder, found, frame_count)

    def load(self, frame: int) -> UInt8[Array, "h w 3"] | None:
        """The RGB image of a frame; None when the folder has none for it.

        Raises BadFile for what is not an image and for a size other than the first one's.
        """
        path = self.paths.get(frame)
        if path is None:
            return None
        image = _decode(path)
        height, width = image.shape[:2]
        if (width, height) != self.image_size:
            raise BadFile(
                f"{path}: {width}x{height} pixels where the first image of the folder has "
                f"{self.image_size[0]}x{self.image_size[1]}; all frames share one camera"
            )
        return image


def _decode(path: Path) -> UInt8[Array, "h w 3"]:
    encoded = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    image = cv2.imdecode(encoded, cv2.IMREAD_COLOR_RGB) if len(encoded) else None
    if image is None:
        raise BadFile(f"{path}: not an image that OpenCV can decode")
    return image
