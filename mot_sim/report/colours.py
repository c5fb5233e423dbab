"""The colours of the report, RGB: a stable one for every id, and those of the schematic world."""

from colorsys import hsv_to_rgb
from functools import cache

Colour = tuple[int, int, int]

GOLDEN_RATIO = 0.6180339887498949
# Hues that follow one another by the golden ratio are far apart; brightness varies as well, so
# that ids can be told apart by people who do not see red or green.
BRIGHTNESS = ((0.85, 1.0), (0.55, 1.0), (1.0, 0.8))  # saturation, value

SKY_TOP, SKY_LOW = (104, 150, 202), (222, 231, 236)
HAZE = (214, 222, 224)
GRASS = (126, 148, 96)
PAINT: dict[str, Colour] = {
    "pavement": (172, 168, 160),
    "kerb": (205, 202, 195),
    "asphalt": (84, 87, 93),
    "line": (236, 236, 230),
}
CAR_PAINTS: tuple[Colour, ...] = (
    (196, 201, 206),  # silver
    (238, 238, 234),  # white
    (150, 44, 44),  # dark red
    (46, 74, 118),  # navy
    (70, 74, 78),  # anthracite
    (184, 164, 128),  # sand
    (58, 104, 92),  # bottle green
    (112, 138, 164),  # grey blue
)
GLASS, TYRE, SILL = (44, 54, 64), (26, 26, 28), (38, 39, 42)
HEADLIGHT, TAILLIGHT = (255, 246, 206), (206, 36, 30)
SHADOW = (58, 61, 66)
PANEL, PANEL_TEXT, PANEL_FAINT = (24, 27, 32), (232, 234, 236), (140, 148, 158)
DETECTION = (196, 200, 204)
EGO = (96, 178, 255)


@cache
def colour_of_id(track_id: int) -> Colour:
    """The colour of an identity; always the same."""
    saturation, value = BRIGHTNESS[track_id % len(BRIGHTNESS)]
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
