"""The design of a car: two dozen measures, and the ranges that real cars of each body have.

The ranges are rough knowledge of cars sold since the nineties: lengths, widths, heights,
wheelbases, overhangs and tyres as data sheets give them, the rest judged from side views. They
are not fitted to any set of annotated cars.
"""

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

Designs: TypeAlias = Mapping[str, Float[Array, " n"]]  # a column a measure, a row a car
Range: TypeAlias = tuple[float, float]

# What a car is unless its body says otherwise. Metres, or shares of the length (wheelbase,
# overhang), of the height (nose, belt, deck_height) or of the width (the rest of the widths).
COMMON_RANGES: dict[str, Range] = {
    "length": (4.30, 5.00),
    "width": (1.68, 1.90),
    "height": (1.38, 1.52),
    "wheelbase": (0.565, 0.635),
    "overhang": (0.165, 0.215),  # from the nose to the front axle
    "wheel": (0.285, 0.350),  # radius of the tyre
    "arch": (1.08, 1.24),  # radius of the wheel arch over that of the tyre
    "clearance": (0.14, 0.26),  # lower edge of the sill
    "nose": (0.42, 0.56),  # leading edge of the bonnet
    "belt": (0.58, 0.68),  # foot of the windscreen
    "cowl": (0.20, 0.75),  # from the front axle back to the foot of the windscreen
    "screen": (0.50, 1.00),  # run of the windscreen along the car
    "backlight": (0.40, 0.85),  # run of the rear window along the car
    "deck": (0.15, 0.65),  # from the foot of the rear window to the tail
    "deck_height": (0.60, 0.74),  # foot of the rear window
    "tail": (0.00, 0.14),  # from there down to the upper edge of the rear lamps, metres
    "roof_width": (0.62, 0.80),
    "screen_width": (0.76, 0.90),
    "drop_front": (0.05, 0.18),  # from the roof's top down to its front corners
    "drop_rear": (0.05, 0.20),
    "lip_front": (0.15, 0.32),  # lower edge of the bumpers
    "lip_rear": (0.18, 0.42),
    "corner_front": (0.12, 0.45),  # how far the corners stand back from the nose
    "corner_rear": (0.08, 0.32),
    "nose_width": (0.70, 0.94),
    "tail_width": (0.72, 0.95),
    "lamp": (0.10, 0.24),
}
BODIES: dict[str, dict[str, Range]] = {
    "sedan": {},
    "hatchback": {
        "length": (3.40, 4.40), "width": (1.58, 1.82), "height": (1.40, 1.60),
        "wheelbase": (0.58, 0.68), "overhang": (0.170, 0.220), "belt": (0.56, 0.66),
        "cowl": (0.05, 0.55), "backlight": (0.22, 0.65), "deck": (0.08, 0.22),
        "tail_width": (0.78, 0.96), "corner_rear": (0.06, 0.24),
        "corner_front": (0.10, 0.30), "nose_width": (0.76, 0.94),
    },
    "estate": {
        "length": (4.35, 4.95), "height": (1.42, 1.56), "backlight": (0.20, 0.60),
        "deck": (0.08, 0.24), "tail_width": (0.78, 0.96), "corner_rear": (0.06, 0.24),
    },
    "suv": {
        "length": (3.90, 5.00), "width": (1.72, 1.99), "height": (1.58, 1.92),
        "wheel": (0.33, 0.42), "clearance": (0.22, 0.40), "nose": (0.50, 0.64),
        "belt": (0.58, 0.68), "screen": (0.35, 0.85), "backlight": (0.18, 0.50),
        "deck": (0.08, 0.22), "lip_front": (0.22, 0.42), "lip_rear": (0.26, 0.48),
        "nose_width": (0.78, 0.97), "tail_width": (0.80, 0.97), "corner_front": (0.08, 0.35),
        "corner_rear": (0.05, 0.22),
    },
    "coupe": {
        "length": (3.90, 4.80), "width": (1.70, 1.98), "height": (1.12, 1.42),
        "wheel": (0.29, 0.36), "clearance": (0.10, 0.20), "nose": (0.38, 0.58),
        "belt": (0.60, 0.72), "cowl": (0.05, 1.00), "screen": (0.55, 1.10),
        "backlight": (0.40, 1.20), "deck": (0.12, 0.65), "deck_height": (0.62, 0.80),
        "roof_width": (0.54, 0.76), "lip_front": (0.10, 0.24), "lip_rear": (0.14, 0.36),
        "overhang": (0.175, 0.225), "corner_front": (0.10, 0.36), "nose_width": (0.74, 0.94),
    },
    "van": {
        "length": (4.00, 5.40), "width": (1.70, 2.02), "height": (1.65, 2.10),
        "overhang": (0.155, 0.215), "nose": (0.40, 0.56), "belt": (0.50, 0.60),
        "cowl": (-0.40, 0.30), "screen": (0.40, 1.05), "backlight": (0.10, 0.40),
        "deck": (0.08, 0.18), "deck_height": (0.52, 0.64), "roof_width": (0.70, 0.88),
        "screen_width": (0.82, 0.91), "tail_width": (0.82, 0.98), "corner_rear": (0.04, 0.18),
        "lip_rear": (0.22, 0.42),
    },
    "pickup": {
        "length": (4.80, 5.60), "width": (1.74, 2.00), "height": (1.62, 1.90),
        "wheelbase": (0.57, 0.62), "overhang": (0.155, 0.195), "wheel": (0.34, 0.42),
        "clearance": (0.26, 0.42), "nose": (0.52, 0.62), "belt": (0.58, 0.66),
        "screen": (0.40, 0.80), "backlight": (0.10, 0.30), "deck": (1.30, 1.80),
        "deck_height": (0.56, 0.66), "tail": (0.00, 0.06), "lip_front": (0.25, 0.45),
        "lip_rear": (0.35, 0.55), "tail_width": (0.86, 0.98), "corner_rear": (0.03, 0.14),
    },
}  # fmt: skip
# How many of a hundred cars have which body; European streets, with few pickups.
BODY_SHARES: dict[str, float] = {
    "sedan": 0.27, "hatchback": 0.28, "estate": 0.12, "suv": 0.14, "coupe": 0.10, "van": 0.07,
    "pickup": 0.02,
}  # fmt: skip
MIN_ROOF_METRES = 0.5  # metres; steeper windows make room for it


def draw_designs(body: str, count: int, rng: np.random.Generator) -> dict[str, Array]:
    """`count` designs of one body, every measure uniform in its range."""
    ranges = COMMON_RANGES | BODIES[body]
    return {name: rng.uniform(*ranges[name], count) for name in COMMON_RANGES}


def front_axle(designs: Designs) -> Float[Array, " n"]:
    """Where the front axle is along the car, counted from its middle."""
    return designs["length"] * (0.5 - designs["overhang"])


def rear_axle(designs: Designs) -> Float[Array, " n"]:
    """Where the rear axle is along the car, counted from its middle."""
    return front_axle(designs) - designs["wheelbase"] * designs["length"]


def greenhouse(designs: Designs) -> tuple[Array, Array, Array, Array]:
    """Foot and top of the windscreen, top and foot of the rear window: where along the car."""
    cowl = front_axle(designs) - designs["cowl"]
    foot = -0.5 * designs["length"] + designs["corner_rear"] + designs["deck"]
    free = cowl - foot - designs["screen"] - designs["backlight"]
    short = np.maximum(MIN_ROOF_METRES - free, 0.0)
    runs = designs["screen"] + designs["backlight"]
    front_run = designs["screen"] * (1.0 - short / runs)
    rear_run = designs["backlight"] * (1.0 - short / runs)
    return cowl, cowl - front_run, foot + rear_run, foot
