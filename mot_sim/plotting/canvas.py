"""Strokes on an RGB image: smooth polygons and lines, text."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from mot_sim.plotting.colours import Colour

FRACTION_BITS = 4  # fractional bits: corners are placed to a sixteenth of a pixel
MAX_COORDINATE = 8000.0  # pixels; OpenCV's fixed-point corners overflow beyond 16 bits
FONT_FILE = "DejaVuSans.ttf"  # of matplotlib

Image = UInt8[Array, "h w 3"]


def fixed_point(points: Float[Array, "*n 2"]) -> Array:
    """The points as OpenCV's fixed-point integers."""
    return np.round(points.clip(-MAX_COORDINATE, MAX_COORDINATE) * (1 << FRACTION_BITS)).astype(
        np.int32
    )


def fill_polygon(image: Image, corners: Float[Array, "n 2"], colour: Colour) -> None:
    """Fill a convex polygon; nothing for fewer than three corners."""
    if len(corners) >= 3:
        cv2.fillConvexPoly(image, fixed_point(corners), colour, cv2.LINE_AA, FRACTION_BITS)


def draw_line(
    image: Image, points: Float[Array, "n 2"], colour: Colour, width: int = 1, closed: bool = False
) -> None:
    """A line through the points."""
    if len(points) >= 2:
        draw_lines(image, [points], colour, width, closed)


def draw_lines(
    image: Image,
    lines: Sequence[Float[Array, "_ 2"]],
    colour: Colour,
    width: int = 1,
    closed: bool = False,
) -> None:
    """Several lines, each through two points or more, one after the other."""
    if not len(lines):
        return
    cv2.polylines(
        image, [fixed_point(each) for each in lines], closed, colour, width, cv2.LINE_AA,
        FRACTION_BITS,
    )  # fmt: skip


def draw_box(image: Image, corners: Float[Array, "4"], colour: Colour, width: int = 1) -> None:
    """The outline of a box x_min, y_min, x_max, y_max."""
    left, top, right, bottom = np.round(corners).astype(int).tolist()
    cv2.rectangle(image, (left, top), (right, bottom), colour, width)


def draw_dashed_box(
    image: Image, corners: Float[Array, "4"], colour: Colour, width: int = 1, dash: float = 7.0
) -> None:
    """The outline of a box x_min, y_min, x_max, y_max in dashes. dash: their length, pixels."""
    left, top, right, bottom = corners.tolist()
    ring = np.array([(left, top), (right, top), (right, bottom), (left, bottom), (left, top)])
    dashes = []
    for start, end in pairwise(ring):
        count = max(1, round(float(np.abs(end - start).sum()) / (2.0 * dash)))
        marks = start + np.linspace(0.0, 1.0, 2 * count + 1)[:, None] * (end - start)
        dashes.append(np.stack((marks[:-1:2], marks[1::2]), axis=1))
    cv2.polylines(
        image,
        list(fixed_point(np.concatenate(dashes))),
        False,
        colour,
        width,
        cv2.LINE_AA,
        FRACTION_BITS,
    )


def tint(image: Image, corners: Float[Array, "4"], colour: Colour, share: float) -> None:
    """Mix a share of a colour into the pixels of a box."""
    left, top, right, bottom = np.round(corners).astype(int).tolist()
    part = image[max(top, 0) : max(bottom + 1, 0), max(left, 0) : max(right + 1, 0)]
    part[:] = np.rint(part + share * (np.array(colour, float) - part)).astype(np.uint8)


def tint_polygon(image: Image, corners: Float[Array, "n 2"], colour: Colour, share: float) -> None:
    """Mix a share of a colour into the pixels of a convex polygon."""
    height, width = image.shape[:2]
    low = np.floor(corners.min(axis=0)).clip(0, (width, height)).astype(int)
    high = np.ceil(corners.max(axis=0) + 1.0).clip(0, (width, height)).astype(int)
    if (high <= low).any():
        return
    part = image[low[1] : high[1], low[0] : high[0]]
    mask = np.zeros(part.shape, np.uint8)
    fill_polygon(mask, corners - low, (255, 255, 255))
    mixed = part + share / 255.0 * mask * (np.array(colour, float) - part)
    part[:] = np.rint(mixed).astype(np.uint8)


def draw_text(
    image: Image, words: str, place: tuple[int, int], colour: Colour, size: int = 16
) -> int:
    """Write words with their base line at place; gives the x where they end."""
    letters, above = _letters(words, size)
    (left, base), (rows, columns) = place, letters.shape
    top = base - above
    first_row, first_column = max(-top, 0), max(-left, 0)
    part = image[max(top, 0) : max(top + rows, 0), max(left, 0) : max(left + columns, 0)]
    ink = letters[first_row:, first_column:][: part.shape[0], : part.shape[1], None] / 255.0
    part[:] = np.rint(part + ink * (np.array(colour, float) - part)).astype(np.uint8)
    return left + columns


def text_width(words: str, size: int = 16) -> int:
    """How many pixels wide the words will be."""
    return _letters(words, size)[0].shape[1]


@lru_cache(maxsize=1024)
def _letters(words: str, size: int) -> tuple[UInt8[Array, "h w"], int]:
    """How much ink words have at each pixel, 255 all; and how many rows are above the base line."""
    from matplotlib import get_data_path  # noqa: PLC0415 - importing mot_sim waits for no plots
    from matplotlib.ft2font import FT2Font  # noqa: PLC0415

    if not words:
        return np.zeros((0, 0), np.uint8), 0
    # (A font draws into a picture of its own: each has one.)
    font = FT2Font(str(Path(get_data_path(), "fonts", "ttf", FONT_FILE)))
    font.set_size(size, 72)  # a point is a pixel
    font.set_text(words, 0.0)
    font.draw_glyphs_to_bitmap(antialiased=True)
    letters = np.array(font.get_image(), np.uint8)
    _, height = font.get_width_height()
    return letters, round((height - font.get_descent()) / 64.0)
