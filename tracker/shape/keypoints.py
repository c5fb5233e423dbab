"""The keypoint network at use: image and boxes in, 36 keypoints a car out, through OpenCV.

A stacked hourglass (Newell et al., ECCV 2016, as in Murthy et al., ICRA 2017), small, trained on
renders by `mot_sim.training`; its weights are ONNX with a JSON that tells where they come from.
"""

import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float, Float32, Shaped, UInt8
from numpy import ndarray as Array

from tracker.errors import BadImage, BadWeights
from tracker.shape.crops import CROP_SIDE, cut_crops, from_shares, show_something, windows_of
from tracker.shape.prior import KEYPOINTS_36
from tracker.types.rows import Rows

SHIPPED_HOURGLASS = Path(__file__).parent.parent / "weights" / "hourglass.onnx"
HOURGLASS_FORMAT = 1  # of the JSON beside the weights
OUTPUT_NAMES = ("heatmaps", "activations")
# The network is given (grey level - INPUT_MIDDLE) * INPUT_SCALE.
INPUT_SCALE = 1.0 / 64.0
INPUT_MIDDLE = 128.0
MAX_CROPS_AT_ONCE = 32  # crops at once
# For each keypoint the row of its mirror image: left ones come first.
OTHER_SIDE = np.roll(np.arange(len(KEYPOINTS_36)), len(KEYPOINTS_36) // 2)
# Cells around the peak whose mean is the point; `benchmarks.keypoints --synthetic` tries others.
PEAK_REACH = 2
NETWORK_HINT = "give an ONNX file that `mot-sim train-keypoints` wrote, with its .json beside it"


@dataclass(frozen=True, eq=False)
class SeenKeypoints(Rows):
    """The network's output for boxes, one row each; NaN where a box shows nothing."""

    keypoints: Float[Array, "n 36 3"]
    """u, v (px of the image) and confidence: the probability that the keypoint is visible and near
    that place; in the order of KEYPOINTS_36."""
    activations: Float32[Array, "n c s s"]
    """Pooled maps of the first layer, which still holds colours, and of the last one."""


@dataclass(frozen=True, eq=False)
class Hourglass:
    """The keypoint network, loaded; call it with an image and boxes."""

    network: Any = field(repr=False)
    """The network as OpenCV loaded it."""
    card: dict[str, Any]
    """What the JSON beside the weights says of them."""
    sha256: str
    """SHA-256 of the ONNX file."""
    mirrored: bool = True
    """Whether each crop's mirror image is looked at, too, and the log odds are averaged: twice the
    time, and fewer cars turned round (`benchmarks.turned_fits`). Activations are of the crop
    alone."""

    @classmethod
    def load(cls, path: Path | None = None, mirrored: bool = True) -> "Hourglass":
        """The network of an ONNX file; None: the shipped one.

        Raises BadWeights for files that are missing, damaged, or of another network.
        """
        path = SHIPPED_HOURGLASS if path is None else Path(path)
        card, content = _card_of(path), _bytes_of(path)
        found = hashlib.sha256(content).hexdigest()
        if found != card["sha256"]:
            raise BadWeights(
                f"{path}: its SHA-256 is {found[:16]}..., its .json says {card['sha256'][:16]}...: "
                f"one of the two is damaged or of another training; {NETWORK_HINT}"
            )
        try:
            network = cv2.dnn.readNetFromONNX(np.frombuffer(content, np.uint8))
        except cv2.error as error:
            raise BadWeights(
                f"{path} is no ONNX that OpenCV reads ({error.err}): {NETWORK_HINT}"
            ) from error
        hourglass = cls(network, card, found, mirrored)
        hourglass._check(path)
        return hourglass

    def __call__(self, image: Shaped[Array, "..."], boxes: Float[Array, "n 4"]) -> SeenKeypoints:
        """The keypoints of the cars in boxes (x_min, y_min, x_max, y_max, pixels).

        image: BGR with 8 bits, as OpenCV reads it, or grey, which is taken as three equal
        channels. All boxes are looked at together. NaN rows for boxes beside the image, of a
        pixel or less, or not finite. Raises BadImage for any other image.
        """
        pixels = colour_of(image)
        seen = SeenKeypoints(
            np.full((len(boxes), len(KEYPOINTS_36), 3), np.nan),
            np.full((len(boxes), *self.card["activations"]), np.nan, np.float32),
        )
        rows = np.flatnonzero(show_something(boxes, (pixels.shape[1], pixels.shape[0])))
        windows = windows_of(boxes[rows])
        for start in range(0, len(rows), MAX_CROPS_AT_ONCE):
            some = slice(start, start + MAX_CROPS_AT_ONCE)
            crops = cut_crops(pixels, windows[some])
            heatmaps, activations = self.run(crops)
            if self.mirrored:
                turned = self.run(np.ascontiguousarray(crops[:, :, ::-1]))[0]
                heatmaps = 0.5 * (heatmaps + turned[:, OTHER_SIDE, :, ::-1])
            points = decode(heatmaps)
            points[:, :, :2] = from_shares(points[:, :, :2], windows[some])
            seen.keypoints[rows[some]] = points
            seen.activations[rows[some]] = activations
        return seen

    def run(
        self, crops: UInt8[Array, "n s s 3"]
    ) -> tuple[Float32[Array, "n 36 h w"], Float32[Array, "n c a a"]]:
        """The network's two outputs for one or more BGR crops."""
        self.network.setInput(network_input(crops))
        heatmaps, activations = self.network.forward(list(OUTPUT_NAMES))
        return heatmaps, activations

    def _check(self, path: Path) -> None:
        """BadWeights unless the network takes our crops and gives what the card promises."""
        try:
            blank = np.zeros((2, CROP_SIDE, CROP_SIDE, 3), np.uint8)
            given = [output.shape for output in self.run(blank)]
        except (cv2.error, ValueError) as error:
            raise BadWeights(
                f"{path} does not take crops of 3x{CROP_SIDE}x{CROP_SIDE} and give "
                f"{', '.join(OUTPUT_NAMES)} "
                f"({str(error).strip().splitlines()[-1]}): {NETWORK_HINT}"
            ) from error
        wanted = [(2, *self.card[name]) for name in OUTPUT_NAMES]
        if given != wanted or self.card["heatmaps"][0] != len(KEYPOINTS_36):
            raise BadWeights(
                f"{path} gives {given} for two crops; its .json promises {wanted}, and there are "
                f"{len(KEYPOINTS_36)} keypoints: {NETWORK_HINT}"
            )


def network_input(crops: UInt8[Array, "n s s 3"]) -> Float32[Array, "n 3 s s"]:
    """Crops as the network is given them."""
    planes = np.ascontiguousarray(crops.transpose(0, 3, 1, 2), np.float32)
    planes -= np.float32(INPUT_MIDDLE)
    planes *= np.float32(INPUT_SCALE)
    return planes


def colour_of(image: Shaped[Array, "..."]) -> UInt8[Array, "h w 3"]:
    """An 8-bit image with three channels; grey is tripled. BadImage for any other."""
    if image.dtype != np.uint8:
        cure = (
            "convert it, for example (image / 257).round().astype(np.uint8)"
            if image.dtype == np.uint16
            else "give uint8"
        )
        raise BadImage(f"an image of type {image.dtype}: the keypoint network sees 8 bits; {cure}")
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if image.ndim == 2 and image.size:
        return cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_GRAY2BGR)
    if image.ndim != 3 or image.shape[2] != 3 or not image.size:
        raise BadImage(f"an image of shape {image.shape}: give height x width x 3, or grey")
    return image


def _bytes_of(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise BadWeights(f"{path}: {error.strerror}; {NETWORK_HINT}") from error


def _card_of(path: Path) -> dict[str, Any]:
    """What the JSON beside an ONNX file says; BadWeights where it does not say enough."""
    beside = path.with_suffix(".json")
    try:
        card = json.loads(_bytes_of(beside))
    except (ValueError, RecursionError) as error:
        raise BadWeights(f"{beside}: {error}; {NETWORK_HINT}") from error
    wanted = {"format": int, "sha256": str, "heatmaps": list, "activations": list}
    for name, kind in wanted.items():
        if not isinstance(card, dict) or not isinstance(card.get(name), kind):
            raise BadWeights(f"{beside} has no {name}; {NETWORK_HINT}")
    if card["format"] != HOURGLASS_FORMAT:
        raise BadWeights(
            f"{beside} has format {card['format']}, this version reads {HOURGLASS_FORMAT}"
        )
    return dict(card)


def chances(heatmaps: Float32[Array, "n k h w"]) -> Float32[Array, "n k h w"]:
    """The probability that a keypoint is seen in a cell; what is left to 1: that it is not seen.

    heatmaps: log odds of each cell against `not seen`, whose own is 0.
    """
    top = np.maximum(heatmaps.max(axis=(2, 3), keepdims=True, initial=0.0), 0.0)
    raised = np.exp(heatmaps - top)
    raised /= raised.sum(axis=(2, 3), keepdims=True) + np.exp(-top)
    return raised


def decode(heatmaps: Float32[Array, "n k h w"], reach: int = PEAK_REACH) -> Float[Array, "n k 3"]:
    """The points of heatmaps: x, y as shares of the crop's sides, and a confidence.

    A point is the mean of the cells around the likeliest one, weighted by their chances; its
    confidence is the chance that the keypoint is seen in one of these. reach: how many cells
    around are taken.
    """
    n, k, h, w = heatmaps.shape
    maps = chances(heatmaps).reshape(n * k, h, w)
    peaks = maps.reshape(n * k, h * w).argmax(axis=1)
    rows, columns = np.divmod(peaks, w)
    around = np.arange(-reach, reach + 1)
    v = rows[:, None] + around
    u = columns[:, None] + around
    inside = ((v >= 0) & (v < h))[:, :, None] & ((u >= 0) & (u < w))[:, None, :]
    cells = maps[
        np.arange(n * k)[:, None, None], v.clip(0, h - 1)[:, :, None], u.clip(0, w - 1)[:, None, :]
    ]
    cells = np.where(inside, cells, 0.0).astype(np.float64)
    sums = cells.sum(axis=(1, 2))
    share = np.maximum(sums, 1e-300)
    x = ((cells.sum(axis=1) * u).sum(axis=1) / share + 0.5) / w
    y = ((cells.sum(axis=2) * v).sum(axis=1) / share + 0.5) / h
    return np.stack((x, y, sums), axis=1).reshape(n, k, 3)
