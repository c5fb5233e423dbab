"""Colours of pictures, RGB: a stable one for every track id, and those of the marks."""

from colorsys import hsv_to_rgb
from functools import cache

Colour = tuple[int, int, int]

GOLDEN_RATIO = 0.6180339887498949
# Hues that follow one another by the golden ratio are far apart; brightness varies as well, so
# that ids can be told apart by people who do not see red or green.
SATURATION_VALUES = ((0.85, 1.0), (0.55, 1.0), (1.0, 0.8))  # saturation, value

GRASS_COLOUR = (126, 148, 96)
PAINT_COLOURS: dict[str, Colour] = {
    "pavement": (172, 168, 160),
    "kerb": (205, 202, 195),
    "asphalt": (84, 87, 93),
    "line": (236, 236, 230),
}
PANEL_COLOUR = (24, 27, 32)
TEXT_COLOUR = (232, 234, 236)
FAINT_COLOUR = (140, 148, 158)
DETECTION_COLOUR = (196, 200, 204)
EGO_COLOUR = (96, 178, 255)
TRUE_COLOUR = (250, 250, 250)
NEUTRAL_COLOUR = (150, 150, 150)
WRONG_COLOUR = (255, 48, 40)
SWITCH_COLOUR = (255, 216, 0)
SKY_COLOUR = (176, 196, 214)
GROUND_COLOUR = (126, 132, 122)
ROAD_LINE_COLOUR = (96, 98, 102)


@cache
def colour_of_id(track_id: int) -> Colour:
    """The colour of an identity; always the same."""
    saturation, value = SATURATION_VALUES[track_id % len(SATURATION_VALUES)]
    rgb = hsv_to_rgb((0.58 + track_id * GOLDEN_RATIO) % 1.0, saturation, value)
    red, green, blue = (round(255 * part) for part in rgb)
    return red, green, blue


def ink_on(colour: Colour) -> Colour:
    """Black or white, whichever is read better on the colour."""
    red, green, blue = colour
    return (0, 0, 0) if 0.299 * red + 0.587 * green + 0.114 * blue > 140 else (255, 255, 255)


def mix(a: Colour, b: Colour, share: float) -> Colour:
    """A colour between a (share 0) and b (share 1)."""
    red, green, blue = (
        round(first + share * (second - first)) for first, second in zip(a, b, strict=True)
    )
    return red, green, blue
