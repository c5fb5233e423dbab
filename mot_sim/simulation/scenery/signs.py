"""Traffic signs as they stand beside German roads: plates with rims and symbols on posts."""

from functools import cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.renderers import Semantic
from mot_sim.simulation.scenery.solids import Colour, Solid, facing, join, prism

STEEL_COLOUR: Colour = (128, 132, 134)
BACK_COLOUR: Colour = (120, 122, 124)
RED, BLUE, YELLOW = (176, 28, 32), (24, 74, 150), (222, 176, 30)
WHITE, BLACK = (230, 230, 224), (26, 26, 28)
POST_METRES, MIDDLE_METRES = 2.62, 2.4  # how high the post is, and the plate's middle
Box = tuple[float, float, float, float]  # left, low, right, high, in radii
# Strokes of a digit 1 wide and 2 high: left, low, right and high of each.
STROKES: dict[str, Box] = {
    "top": (0.0, 1.75, 1.0, 2.0), "middle": (0.0, 0.88, 1.0, 1.12), "foot": (0.0, 0.0, 1.0, 0.25),
    "left high": (0.0, 1.0, 0.28, 2.0), "left low": (0.0, 0.0, 0.28, 1.0),
    "right high": (0.72, 1.0, 1.0, 2.0), "right low": (0.72, 0.0, 1.0, 1.0),
}  # fmt: skip
EXCLAMATION = ((-0.06, -0.1, 0.06, 0.32), (-0.06, -0.28, 0.06, -0.16))
DIGITS = {
    "0": ("top", "foot", "left high", "left low", "right high", "right low"),
    "3": ("top", "middle", "foot", "right high", "right low"),
    "5": ("top", "middle", "foot", "left high", "right low"),
    "P": ("top", "middle", "left high", "left low", "right high"),
}


class SignFace(NamedTuple):
    """What is painted on a plate."""

    corners: int
    """Of the plate; 24 for a disc."""
    turn: float
    """By how much of a corner it is turned from standing on an edge's middle, point up: 0."""
    rim: Colour
    """Colour of the rim."""
    middle: Colour
    """Colour within the rim."""
    width: float
    """Of the rim, in radii."""
    ink: Colour
    """Colour of the symbol."""
    symbol: tuple[Box, ...]
    """Rectangles of the symbol, in radii about the plate's middle."""


def lettered(text: str, width: float) -> tuple[Box, ...]:
    """The strokes of digits beside each other, each so wide and twice as high, in radii."""
    found, gap = [], 0.35 * width
    left = -0.5 * (len(text) * width + (len(text) - 1) * gap)
    for character in text:
        for stroke in DIGITS[character]:
            a, low, b, high = STROKES[stroke]
            found.append(
                (left + a * width, (low - 1) * width, left + b * width, (high - 1) * width)
            )
        left += width + gap
    return tuple(found)


SIGN_FACES = (
    SignFace(24, 0.0, RED, WHITE, 0.22, BLACK, lettered("30", 0.36)),  # speed limits
    SignFace(24, 0.0, RED, WHITE, 0.22, BLACK, lettered("50", 0.36)),
    SignFace(3, 0.5, RED, WHITE, 0.32, WHITE, ()),  # give way
    SignFace(4, 0.0, WHITE, YELLOW, 0.2, YELLOW, ()),  # priority road
    SignFace(4, 0.5, WHITE, BLUE, 0.07, WHITE, lettered("P", 0.5)),  # parking
    SignFace(8, 0.5, WHITE, RED, 0.08, WHITE, ((-0.66, -0.14, 0.66, 0.14),)),  # stop
    SignFace(3, 0.0, RED, WHITE, 0.32, BLACK, EXCLAMATION),
)  # fmt: skip


@cache
def sign(kind: int) -> Solid:
    """A traffic sign at the origin; it looks towards -x. kind: any number; there are seven."""
    face = SIGN_FACES[kind % len(SIGN_FACES)]
    radius = 0.44 if face.corners == 3 else 0.34
    inside, behind = (0.0, 0.0, MIDDLE_METRES), (-0.3, 0.0, MIDDLE_METRES)
    parts = [
        prism(0.035, 0.0, POST_METRES, STEEL_COLOUR, Semantic.POLE, 5),
        facing(_plate(face, radius, -0.04), BACK_COLOUR, Semantic.OTHER, behind),
        facing(_plate(face, radius, -0.05), face.rim, Semantic.OTHER, inside),
    ]
    if face.width > 0.0:
        middle = _plate(face, radius * (1.0 - face.width), -0.06)
        parts.append(facing(middle, face.middle, Semantic.OTHER, inside))
    if face.symbol:
        left, low, right, high = radius * np.array(face.symbol).T
        # (It looks towards -x, and y lies to the right of who looks along x.)
        strokes = np.empty((len(left), 4, 3))
        strokes[..., 0] = -0.07
        strokes[..., 1] = np.stack((left, right, right, left), axis=1)
        strokes[..., 2] = MIDDLE_METRES + np.stack((low, low, high, high), axis=1)
        parts.append(facing(strokes, face.ink, Semantic.OTHER, inside))
    return join(parts)


def _plate(face: SignFace, radius: float, x: float) -> Float[Array, "n 3 3"]:
    """The plate as triangles around its middle, upright at an x."""
    turn = (np.arange(face.corners + 1) + face.turn) * (2.0 * np.pi / face.corners)
    high = MIDDLE_METRES + radius * np.cos(turn)
    rim = np.stack((0.0 * turn + x, radius * np.sin(turn), high), axis=1)
    centre = np.broadcast_to(np.array([x, 0.0, MIDDLE_METRES]), rim[:-1].shape)
    return np.stack((centre, rim[:-1], rim[1:]), axis=1)
