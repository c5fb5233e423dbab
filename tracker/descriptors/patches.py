"""Cutting boxes out of an image: what is checked, and patches of one size."""

import cv2
import numpy as np
from jaxtyping import Bool, Float, UInt8
from numpy import ndarray as Array

from tracker.errors import BadImage

MIN_SIDE_PIXELS = 2.0  # pixels of a box inside the image, below which there is nothing to describe


def require_rgb(image: Array) -> None:
    """BadImage for what is not RGB with 8 bits."""
    if image.dtype == np.uint8 and image.ndim == 3 and image.shape[2] == 3:
        return
    if image.dtype == np.uint16:
        cure = "divide by 256 and convert to uint8"
    elif image.ndim == 2:
        cure = "convert it, cv2.cvtColor(image, cv2.COLOR_GRAY2RGB)"
    else:
        cure = "give an array (h, w, 3) of uint8"
    raise BadImage(f"an image of shape {image.shape} and type {image.dtype}, not 8-bit RGB: {cure}")


def can_be_cut(image: Array, boxes: Float[Array, "n 4"]) -> Bool[Array, " n"]:
    """Which boxes are at least two pixels wide and high inside the image."""
    inside = boxes.clip(0.0, np.array([image.shape[1] - 1.0, image.shape[0] - 1.0] * 2))
    return (inside[:, 2:] - inside[:, :2] >= MIN_SIDE_PIXELS).all(axis=1)


def patches(
    image: UInt8[Array, "h w 3"], boxes: Float[Array, "n 4"], side: int
) -> UInt8[Array, "n s s 3"]:
    """What is inside boxes of the image, each squeezed or stretched to a square.

    Pixel centres are integers. Boxes are cut at the image's border; they must lie inside it by
    at least a pixel, see `can_be_cut`.
    """
    limit = np.array([image.shape[1], image.shape[0]] * 2)
    left, top, right, bottom = np.round(boxes).astype(np.int64).clip(0, np.tile(limit[:2] - 1, 2)).T
    cut = np.empty((len(boxes), side, side, 3), np.uint8)
    for row, (x0, y0, x1, y1) in enumerate(zip(left, top, right, bottom, strict=True)):
        part = image[y0 : y1 + 1, x0 : x1 + 1]
        shrinks = part.shape[0] > side or part.shape[1] > side
        how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        cv2.resize(part, (side, side), dst=cut[row], interpolation=how)
    return cut
