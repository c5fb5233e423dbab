"""What cars are painted with, and the colours of what is not painted."""

import numpy as np
from jaxtyping import Float, Int, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.cars.topology import PARTS
from tracker.errors import UnknownName

# RGB, and the share of cars: roughly German streets around 2011, when KITTI was driven.
PAINTS: dict[str, tuple[tuple[int, int, int], float]] = {
    "black": ((24, 24, 27), 0.29),
    "grey": ((98, 101, 105), 0.17),
    "silver": ((176, 179, 182), 0.18),
    "white": ((232, 232, 228), 0.11),
    "blue": ((32, 58, 112), 0.11),
    "red": ((150, 22, 26), 0.07),
    "green": ((36, 74, 52), 0.03),
    "brown": ((88, 66, 52), 0.02),
    "yellow": ((226, 186, 40), 0.02),
}
OTHERS: dict[str, tuple[int, int, int]] = {
    "glass": (40, 48, 56), "trim": (32, 32, 34), "headlight": (228, 232, 236),
    "taillight": (170, 16, 20), "plate": (236, 236, 232), "tyre": (22, 22, 23),
    "rim": (150, 153, 157),
}  # fmt: skip
Paint = str | tuple[int, int, int]


def paint_colour(paint: Paint) -> tuple[int, int, int]:
    """The RGB of a paint; UnknownName unless it is one of PAINTS or a colour itself."""
    if not isinstance(paint, str):
        return paint
    if paint not in PAINTS:
        raise UnknownName.of("colour", paint, PAINTS)
    return PAINTS[paint][0]


def part_colours(parts: Int[Array, " f"], paint: Paint) -> UInt8[Array, "f 3"]:
    """The RGB of faces from their parts."""
    palette = [paint_colour(paint), *(OTHERS[part] for part in PARTS[1:])]
    return np.array(palette, dtype=np.uint8)[parts]


def choose(shares: list[float], draws: Float[Array, " n"]) -> Int[Array, " n"]:
    """Which share each number of [0, 1) falls into; the shares need not sum up to 1."""
    bounds = np.cumsum(shares)
    return np.minimum(np.searchsorted(bounds / bounds[-1], draws, side="right"), len(bounds) - 1)
