"""What is checked of images and boxes before anything is seen in them."""

import numpy as np
from jaxtyping import Bool, Float, UInt8
from numpy import ndarray as Array

from tracker.errors import BadDetections, BadImage
from tracker.types import Camera

BOX_MARGIN_PIXELS = 3.0  # pixels around a box that are hidden with it


def check_image(image: Array, camera: Camera) -> UInt8[Array, "h w 3"]:
    """The image when it is RGB, 8 bits, and of the camera's size; else BadImage."""
    if image.dtype != np.uint8:
        raise BadImage(
            f"an image of {image.dtype}: give 8 bits a channel (uint8); 16 bits: image // 257"
        )
    if image.ndim != 3 or image.shape[2] != 3:
        raise BadImage(
            f"an image of shape {image.shape}: give RGB, (height, width, 3); grey: "
            "np.repeat(image[:, :, None], 3, axis=2)"
        )
    height, width = image.shape[:2]
    if (width, height) != camera.image_size:
        raise BadImage(
            f"an image of {width}x{height} pixels, the camera's calibration is for "
            f"{camera.image_size[0]}x{camera.image_size[1]}: give the size that K belongs to"
        )
    return image


def without_boxes(boxes: Float[Array, "n 4"], image_size: tuple[int, int]) -> Bool[Array, "h w"]:
    """Which pixels lie in none of the boxes, some pixels around them included.

    Boxes are clipped to the image; those outside it or without area hide nothing.
    """
    if not np.isfinite(boxes).all():
        row = int(np.flatnonzero(~np.isfinite(boxes).all(axis=1))[0])
        raise BadDetections(f"box {row} is not finite: {boxes[row].tolist()}; leave it out")
    width, height = image_size
    free = np.ones((height, width), dtype=bool)
    outer = boxes + (-BOX_MARGIN_PIXELS, -BOX_MARGIN_PIXELS, BOX_MARGIN_PIXELS, BOX_MARGIN_PIXELS)
    corners = np.clip(np.round(outer), 0, [width, height, width, height]).astype(int)
    area = (boxes[:, 2] > boxes[:, 0]) & (boxes[:, 3] > boxes[:, 1])
    for x_min, y_min, x_max, y_max in corners[area].tolist():
        free[y_min : y_max + 1, x_min : x_max + 1] = False
    return free
