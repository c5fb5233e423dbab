"""Folders of numbered images: found once, decoded one at a time when asked for."""

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import cv2
import numpy as np
from jaxtyping import Shaped, UInt8
from numpy import ndarray as Array

from mot_sim.files.text import MAX_FRAMES, what_is_there
from tracker.errors import BadFile, DatasetNotFound

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp")

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
MAX_DEFLATE_RATIO = 1032  # decoded bytes per byte of a PNG
PNG_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}  # by colour type

log = logging.getLogger(__name__)


@runtime_checkable
class ImageSource(Protocol):
    """Gives the images of a drive: a folder of files, or a renderer."""

    def load(self, frame: int) -> UInt8[Array, "h w 3"] | None:
        """The RGB image of a frame; None when there is none for it."""
        ...


@dataclass(frozen=True, eq=False)
class ImageFolder:
    """The numbered images of one drive: 000000.png is frame `first_frame`, and so on."""

    paths: dict[int, Path]
    """The image file of each frame that has one, frames counted from 0."""
    image_size: tuple[int, int]
    """Width and height of all images, px."""

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
            if path.suffix.lower() in IMAGE_SUFFIXES and path.stem.isdecimal()
        }
        if not paths:
            return None
        last = max(paths)
        if last >= MAX_FRAMES:
            raise BadFile(f"{paths[last]}: an image of a frame beyond {MAX_FRAMES - 1}; rename it")
        height, width = _decode(paths[min(paths)]).shape[:2]
        return cls(paths, (width, height))

    @classmethod
    def require(cls, folder: Path, first_frame: int = 0) -> "ImageFolder":
        """Like `find`; raises DatasetNotFound when there are no numbered images."""
        found = cls.find(folder, first_frame)
        if found is None:
            there = what_is_there(folder, "no numbered images in it")
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


def decoded(path: Path, flags: int) -> Shaped[Array, "h w *c"] | None:
    """The pixels of an image file; None for what OpenCV cannot decode. Raises BadFile."""
    try:
        raw = path.read_bytes()
        if raw.startswith(PNG_SIGNATURE) and not _is_whole(raw):
            return None
        encoded = np.frombuffer(raw, dtype=np.uint8)
        return cv2.imdecode(encoded, flags) if len(encoded) else None
    except OSError as error:
        raise BadFile(f"{path}: cannot be read: {error.strerror}") from None
    except cv2.error:  # more pixels than it takes
        return None


def _is_whole(raw: bytes) -> bool:
    """Whether the bytes of a PNG can hold its pixels, and all of the pieces that it is made of.

    OpenCV makes room for what the file tells before it looks whether that is there.
    """
    width, height = (int.from_bytes(raw[at : at + 4], "big") for at in (16, 20))
    depth, colour = (*raw[24:26], 0, 0)[:2]
    if height * width * depth * PNG_CHANNELS.get(colour, 1) > 8 * MAX_DEFLATE_RATIO * len(raw):
        return False
    at = len(PNG_SIGNATURE)
    while at + 12 <= len(raw):
        piece, at = raw[at + 4 : at + 8], at + 12 + int.from_bytes(raw[at : at + 4], "big")
        if piece == b"IEND":
            return at <= len(raw)
    return False


def _decode(path: Path) -> UInt8[Array, "h w 3"]:
    image = decoded(path, cv2.IMREAD_COLOR)
    if image is None:
        raise BadFile(f"{path}: not an image that OpenCV can decode")
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
