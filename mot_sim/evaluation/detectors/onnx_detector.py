"""A detector in an ONNX file: images in, `Detections` out."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float, Shaped, UInt8
from numpy import ndarray as Array

from mot_sim.datasets.box_tables import COCO_KINDS
from mot_sim.evaluation.detectors.heads import HEADS, NetworkBoxes, boxes_of_outputs
from mot_sim.evaluation.detectors.networks import OnnxNetwork, load_network
from tracker.errors import BadConfig, BadWeights, UnknownName
from tracker.types import Detections

# What networks are given that do not say what they take, px.
DEFAULT_SIZE = (640, 640)
GREY = 114  # around images that are brought to another shape, as YOLO's training has it
IMAGENET_MEAN = np.array([0.485, 0.456, 0.406], np.float32)
IMAGENET_STD = np.array([0.229, 0.224, 0.225], np.float32)

# From RGB bytes to the numbers that networks were trained on.
PIXELS: dict[str, Callable[[UInt8[Array, "h w 3"]], Float[Array, "h w 3"]]] = {
    "rgb": lambda image: image.astype(np.float32) / 255.0,
    "rgb255": lambda image: image.astype(np.float32),
    "bgr255": lambda image: image[:, :, ::-1].astype(np.float32),
    "imagenet": lambda image: (image.astype(np.float32) / 255.0 - IMAGENET_MEAN) / IMAGENET_STD,
}


@dataclass(frozen=True)
class Placement:
    """Where an image lies in what the network is given."""

    scale: tuple[float, float]
    """Pixels there per pixel of the image, in x and y."""
    corner: tuple[int, int]
    """Its upper left corner there, px."""

    def back(self, boxes: Float[Array, "n 4"]) -> Float[Array, "n 4"]:
        """Boxes there, in pixels of the image."""
        placed: Float[Array, "n 4"] = (boxes - np.tile(self.corner, 2)) / np.tile(self.scale, 2)
        return placed


def letterboxed(
    image: UInt8[Array, "h w 3"], size: tuple[int, int]
) -> tuple[UInt8[Array, "H W 3"], Placement]:
    """The image as large as it fits, grey around it."""
    height, width = image.shape[:2]
    scale = min(size[0] / width, size[1] / height)
    inner = tuple(max(1, round(side * scale)) for side in (width, height))
    left, top = ((outer - side) // 2 for outer, side in zip(size, inner, strict=True))
    canvas = np.full((size[1], size[0], 3), GREY, np.uint8)
    canvas[top : top + inner[1], left : left + inner[0]] = cv2.resize(image, inner)
    return canvas, Placement((inner[0] / width, inner[1] / height), (left, top))


def stretched(
    image: UInt8[Array, "h w 3"], size: tuple[int, int]
) -> tuple[UInt8[Array, "H W 3"], Placement]:
    """The image stretched to the size."""
    height, width = image.shape[:2]
    return cv2.resize(image, size), Placement((size[0] / width, size[1] / height), (0, 0))


FITS = {"letterbox": letterboxed, "stretch": stretched}


@dataclass(frozen=True, eq=False)
class OnnxDetector:
    """Boxes of cars (and pedestrians, cyclists) in images, by a network of anybody's."""

    network: OnnxNetwork
    """The network."""
    name: str
    """What it is called in messages."""
    size: tuple[int, int] = DEFAULT_SIZE
    """Width and height of the image that it is given, px, > 0."""
    head: str = "yolo"
    """What its outputs are, a name of HEADS."""
    pixels: str = "rgb"
    """What it was trained on, a name of PIXELS; networks that take bytes get them as they are."""
    fit: str = "letterbox"
    """How images are brought to the size, a name of FITS."""
    names: Mapping[int, str] | None = None
    """Names of its classes by number; None: as the file or the number of classes tells."""
    kinds: tuple[str, ...] = ("Car",)
    """The classes that are kept: Car, Pedestrian, Cyclist."""
    min_score: float = 0.1
    """Boxes with less are dropped, 0 to 1; less: more boxes, most of them wrong."""
    max_iou: float = 0.7
    """Of two boxes that overlap by more the weaker one is dropped, 0 to 1; more: twins stay."""

    def __post_init__(self) -> None:
        for name, share in (("min_score", self.min_score), ("max_iou", self.max_iou)):
            if not 0.0 <= share <= 1.0:
                raise BadConfig(f"{name} {share:g}: give a number from 0 to 1")
        if min(self.size) < 1:
            raise BadConfig(f"size {self.size[0]}x{self.size[1]}: give pixels above 0")
        registers: tuple[tuple[str, str, Iterable[str]], ...] = (
            ("kind of pixels", self.pixels, PIXELS),
            ("fit", self.fit, FITS),
            ("head", self.head, HEADS),
        )
        for what, name, register in registers:
            if name not in register:
                raise UnknownName.of(what, name, register)

    @classmethod
    def load(
        cls,
        path: Path,
        backend: str | None = None,
        size: tuple[int, int] | None = None,
        head: str | None = None,
        fit: str | None = None,
        **settings: Any,
    ) -> "OnnxDetector":
        """The detector of an ONNX file, tried on a grey image.

        backend: a name of BACKENDS; None: ONNX Runtime where it is installed, else OpenCV. size:
        None: the network's own, else 640x640. head: None: found out from what the network gives.
        fit: None: as is usual for the head. settings: the other fields. Raises BadWeights for files
        that are no detectors and networks without a class that is asked for.
        """
        if head is not None and head not in HEADS:
            raise UnknownName.of("head", head, HEADS)
        network = load_network(path, backend)
        fixed = network.input_size
        if size is not None and fixed is not None and size != fixed:
            raise BadConfig(
                f"size {size[0]}x{size[1]}: {path} takes {fixed[0]}x{fixed[1]} alone; leave it out"
            )
        detector = cls(network, str(path), size or fixed or DEFAULT_SIZE, **settings)
        blank = np.full((detector.size[1], detector.size[0], 3), GREY, np.uint8)
        outputs = network.run(detector._input(blank))
        head, found = boxes_of_outputs(
            outputs, detector.size, detector._given_names, head, str(path)
        )
        detector._wanted(found.names)
        return replace(detector, head=head, fit=fit or HEADS[head].fit)

    def __call__(self, image: UInt8[Array, "h w 3"]) -> Detections:
        """The boxes in an RGB image, the surest first."""
        given, placement = FITS[self.fit](image, self.size)
        outputs = self.network.run(self._input(given))
        _, found = boxes_of_outputs(outputs, self.size, self._given_names, self.head, self.name)
        return self._kept(found, placement, image.shape[:2])

    @property
    def _given_names(self) -> Mapping[int, str]:
        """Names of classes as they are given, else as the file has them."""
        return self.network.class_names if self.names is None else self.names

    def _wanted(self, names: Mapping[int, str]) -> dict[int, str]:
        """The kind of each class that is kept, by its number."""
        wanted = {
            number: COCO_KINDS[name.lower()]
            for number, name in names.items()
            if COCO_KINDS.get(name.lower()) in self.kinds
        }
        if wanted:
            return wanted
        known = ", ".join(names.values()) or "not known"
        raise BadWeights(
            f"{self.name}: no class {' or '.join(self.kinds)} among its classes ({known}); name "
            "them in their order: --names car,van,..."
        )

    def _input(self, image: UInt8[Array, "H W 3"]) -> Shaped[Array, "..."]:
        """The image as the network takes it."""
        pixels = image if self.network.is_byte else PIXELS[self.pixels](image)
        if not self.network.channels_last:
            pixels = pixels.transpose(2, 0, 1)
        return np.ascontiguousarray(pixels if self.network.rank == 3 else pixels[None])

    def _kept(
        self, found: NetworkBoxes, placement: Placement, shape: tuple[int, ...]
    ) -> Detections:
        """The boxes of the classes that are asked for, inside the image, without twins."""
        wanted = self._wanted(found.names)
        strong = np.flatnonzero((found.scores >= self.min_score) & np.isin(found.labels, [*wanted]))
        strong = strong[np.argsort(-found.scores[strong], kind="stable")]
        limits = np.array([shape[1] - 1.0, shape[0] - 1.0] * 2)
        boxes = np.clip(placement.back(found.boxes[strong]), 0.0, limits)
        scores, labels = np.minimum(found.scores[strong], 1.0), found.labels[strong]
        sides = boxes[:, 2:] - boxes[:, :2]
        kept = np.isfinite(boxes).all(axis=1) & (sides > 0.0).all(axis=1)
        if not found.is_suppressed and kept.any():
            rows = np.flatnonzero(kept)
            corners = np.concatenate((boxes[rows, :2], sides[rows]), axis=1)
            alone = cv2.dnn.NMSBoxesBatched(
                corners.tolist(), scores[rows].tolist(), labels[rows].tolist(), 0.0, self.max_iou
            )
            kept = np.isin(np.arange(len(boxes)), rows[np.asarray(alone, int).ravel()])
        kinds = np.array([wanted[label] for label in labels[kept].tolist()], dtype="U16")
        return Detections(boxes[kept], scores[kept], kinds=kinds)
