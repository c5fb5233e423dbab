"""Square pieces of an image around boxes, as the keypoint network sees them."""

import cv2
import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

# Pixels of a crop's sides.
CROP_SIDE = 64
# A crop's side over the longer side of its box: a detector's boxes are a little off.
CROP_MARGIN = 1.15
# A box whose longer side is shorter, in pixels, shows nothing.
MIN_BOX_PIXELS = 2.0
# How many times finer than the crop an image is read before it is averaged.
MAX_OVERSAMPLING = 12
# What is beyond the image.
OUTSIDE_COLOUR = (114, 114, 114)


def windows_of(boxes: Float[Array, "n 4"], margin: float = CROP_MARGIN) -> Float[Array, "n 3"]:
    """Centre u, v and side of the squares around boxes, pixels of the image."""
    centre = 0.5 * (boxes[:, :2] + boxes[:, 2:])
    longer = (boxes[:, 2:] - boxes[:, :2]).max(axis=1)
    return np.concatenate((centre, margin * longer[:, None]), axis=1)


def show_something(boxes: Float[Array, "n 4"], image_size: tuple[int, int]) -> UInt8[Array, " n"]:
    """1 for boxes that are finite, at least LEAST pixels long, and reach into the image; else 0."""
    width, height = image_size
    finite = np.isfinite(boxes).all(axis=1)
    left, top, right, bottom = np.where(finite[:, None], boxes, 0.0).T
    large = np.maximum(right - left, bottom - top) >= MIN_BOX_PIXELS
    proper = (right > left) & (bottom > top)
    inside = (right > 0.0) & (bottom > 0.0) & (left < width - 1.0) & (top < height - 1.0)
    return (finite & large & proper & inside).astype(np.uint8)


def cut_crops(
    image: UInt8[Array, "h w c"], windows: Float[Array, "n 3"], side: int = CROP_SIDE
) -> UInt8[Array, "n {side} {side} c"]:
    """The image inside square windows, resized to `side` pixels; grey beyond the image.

    Large windows are averaged, small ones interpolated.
    """
    crops = np.empty((len(windows), side, side, image.shape[2]), np.uint8)
    for row, (u, v, extent) in enumerate(windows.tolist()):
        times = int(np.clip(round(extent / side), 1, MAX_OVERSAMPLING))
        fine = times * side
        step = extent / fine
        A = np.array([
            [step, 0.0, u - 0.5 * extent + 0.5 * step],
            [0.0, step, v - 0.5 * extent + 0.5 * step],
        ])  # fmt: skip
        piece = cv2.warpAffine(
            image, A, (fine, fine), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_CONSTANT, borderValue=OUTSIDE_COLOUR,
        )  # fmt: skip
        if times > 1:
            piece = cv2.resize(piece, (side, side), interpolation=cv2.INTER_AREA)
        crops[row] = piece.reshape(side, side, -1)
    return crops


def from_shares(
    shares: Float[Array, "n k 2"], windows: Float[Array, "n 3"]
) -> Float[Array, "n k 2"]:
    """Image pixels of points that are given as shares of their window, 0 to 1 from its corner."""
    return windows[:, None, :2] + (shares - 0.5) * windows[:, None, 2:]


def to_shares(points: Float[Array, "n k 2"], windows: Float[Array, "n 3"]) -> Float[Array, "n k 2"]:
    """Image pixels as shares of their window: the inverse of `from_shares`."""
    return (points - windows[:, None, :2]) / windows[:, None, 2:] + 0.5
