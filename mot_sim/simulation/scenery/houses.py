"""Houses: walls in storeys, windows with frames, doors, roofs."""

import itertools
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.random_numbers import named_stream
from mot_sim.simulation.renderers import Material, Semantic
from mot_sim.simulation.scenery.solids import Colour, Solid, box, facing, join, shaded

WALL_COLOURS: tuple[Colour, ...] = (
    (206, 198, 178), (188, 172, 148), (172, 120, 96), (214, 208, 198), (158, 150, 138),
    (196, 178, 128), (148, 104, 84), (222, 214, 190), (232, 230, 224), (170, 162, 150),
    (206, 176, 140), (164, 172, 160), (186, 142, 122), (134, 88, 70), (214, 196, 150),
    (176, 182, 188), (150, 118, 96),
)  # fmt: skip
ROOF_COLOURS: tuple[Colour, ...] = ((128, 68, 52), (96, 60, 52), (74, 74, 78), (110, 84, 66))
FRAME_COLOURS: tuple[Colour, ...] = (
    (224, 222, 214), (224, 222, 214), (206, 200, 186), (92, 70, 52), (62, 66, 68), (58, 84, 66),
)  # fmt: skip
WALL_MATERIALS = (Material.PLASTER, Material.PLASTER, Material.PLASTER, Material.BLOCKS)
BRICK_REDNESS = 30  # grey levels of red over green, from which on a wall is of bricks
SHOP_SHARE = 0.4  # of the houses have a shop in their lowest storey
PANE_COLOUR = (76, 82, 88)
PLINTH_COLOUR = (112, 108, 102)
DOOR_COLOURS: tuple[Colour, ...] = ((84, 56, 38), (44, 62, 52), (70, 30, 28), (52, 54, 60))
STOREY_METRES = 2.9  # height
WINDOW_WIDTHS, WINDOW_HEIGHTS = (0.9, 1.05, 1.05, 1.25, 1.6), (1.2, 1.4, 1.4, 1.6)  # metres
WINDOW_PITCHES = (1.9, 3.0)  # from one to the next, in widths
PAIR_GAP_METRES = 0.35  # between two windows that stand together
ATTIC_HEIGHT_METRES = 0.95  # of the windows of a low upper storey
SHUTTER_COLOURS: tuple[Colour, ...] = ((70, 92, 74), (104, 66, 46), (150, 148, 140), (62, 74, 92))
SILL_COLOUR = (168, 164, 156)
FOOT_SHARE = 0.93  # of the light at the lowest storey, where the street hides some sky
LIT_SHARE = 0.35  # of the windows have a light behind them at night


class WindowStyle(NamedTuple):
    """How the windows of a house look; metres."""

    width: float
    """Of a pane."""
    height: float
    """Of a pane."""
    pitch: float
    """From one to the next, or from one pair to the next."""
    is_paired: bool
    """Whether they stand in twos."""
    is_low_above: bool
    """Whether those of the uppermost storey are low."""
    blind_share: float
    """Share of the places beside the house that are wall."""
    bars: int
    """0: one pane; 1: a bar in the middle; 2: two rows of panes as well."""
    frame: Colour
    """Colour of frames and bars."""
    shutters: Colour | None
    """Colour of open shutters; None: there are none."""
    has_sills: bool
    """Whether a sill lies beneath each."""

    @classmethod
    def of(cls, seed: int, number: int, frame: Colour) -> "WindowStyle":
        """The style of a house by its number."""
        rng = named_stream(seed, f"window style of house {number}")
        width, height = float(rng.choice(WINDOW_WIDTHS)), float(rng.choice(WINDOW_HEIGHTS))
        pitch, is_paired = width * float(rng.uniform(*WINDOW_PITCHES)), bool(rng.random() < 0.25)
        if is_paired:
            pitch += width + PAIR_GAP_METRES
        shutters = SHUTTER_COLOURS[int(rng.integers(len(SHUTTER_COLOURS)))]
        has_shutters = not is_paired and rng.random() < 0.3
        return cls(
            width,
            height,
            max(pitch, 2.1 * width if has_shutters else 0.0),
            is_paired,
            bool(rng.random() < 0.3),
            float(rng.uniform(0.1, 0.5)),
            int(rng.integers(3)),
            frame,
            shutters if has_shutters else None,
            bool(rng.random() < 0.5),
        )

    def places(self, length: float) -> Float[Array, " n"]:
        """The middles of windows along a wall, at least one."""
        count = max(int((length - 0.6) / self.pitch), 1)
        middles = (np.arange(count) + 0.5) * (length / count)
        half = 0.5 * (self.width + PAIR_GAP_METRES)
        if not self.is_paired or length < 2.0 * half + self.width + 0.4:
            return middles
        return np.sort(np.concatenate((middles - half, middles + half)))


def house(seed: int, number: int, width: float, depth: float, detail: int) -> Solid:
    """A house of a seed: its front lies along x (0 to width) at y = 0, it reaches back to y > 0.

    detail: 0 = seen from near, 2 = from far.
    """
    rng = named_stream(seed, f"house {number}")
    storeys = int(rng.integers(2, 5))
    high = 0.5 + STOREY_METRES * storeys
    rng.integers(8)  # (what follows keeps its draws: sizes and storeys stay as they are)
    paints = named_stream(seed, f"colours of house {number}")
    wall = WALL_COLOURS[int(paints.integers(len(WALL_COLOURS)))]
    is_brick = wall[0] - wall[1] > BRICK_REDNESS
    made = int(Material.BRICK if is_brick else paints.choice(WALL_MATERIALS))
    gable = int(paints.choice((made, made, Material.BOARDS)))
    frame = FRAME_COLOURS[int(paints.integers(len(FRAME_COLOURS)))]
    style = WindowStyle.of(seed, number, frame)
    shop = int(Material.SHOP) if paints.random() < SHOP_SHARE else 0
    middle = np.array([0.5 * width, 0.5 * depth, 0.5 * high])
    ends = np.array([(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)])
    parts = [_roof(rng, width, depth, high, middle, (wall, gable), detail)]
    for side in range(4):
        start, end = ends[side], ends[(side + 1) % 4]
        own = made + (shop if side == 0 else 0)
        parts.append(_wall(rng, start, end, storeys, wall, middle, detail).made_of(own))
        if side != 2 or detail == 0:  # the back is hardly ever seen
            has_shop, place = side == 0 and shop > 0, (start, end, storeys, middle)
            parts.append(_windows(seed * 4 + side, number, *place, style, has_shop, detail))
    return join(parts)


def _wall(
    rng: np.random.Generator,
    start: Array,
    end: Array,
    storeys: int,
    colour: Colour,
    middle: Array,
    detail: int,
) -> Solid:
    """A wall in panels that differ a little: rain and sun are not the same everywhere."""
    panels = 1 if detail else max(round(float(np.hypot(*(end - start))) / 3.0), 1)
    u = np.linspace(0.0, 1.0, panels + 1)
    h = np.array([0.0, 0.5, *(0.5 + STOREY_METRES * (1 + np.arange(storeys)))])
    if detail:
        h = h[[0, -1]] if detail > 1 else h[[0, 1, -1]]
    line = start + u[:, None] * (end - start)
    quads, tones = [], []
    for low, high in itertools.pairwise(h):
        for a, b in itertools.pairwise(line):
            quads.append([(*a, low), (*b, low), (*b, high), (*a, high)])
            tone = rng.uniform(0.95, 1.04) * (FOOT_SHARE if low <= 0.5 else 1.0)
            tones.append(np.array(PLINTH_COLOUR if high == 0.5 else colour) * tone)
    return facing(np.array(quads), np.array(tones), Semantic.BUILDING, middle)


def _windows(
    seed: int,
    number: int,
    start: Array,
    end: Array,
    storeys: int,
    middle: Array,
    style: WindowStyle,
    has_shop: bool,
    detail: int,
) -> Solid:
    """Frames and panes, a little before the wall; a door in the front."""
    rng, door = named_stream(seed, f"windows {number}"), seed % 4 == 0
    length = float(np.hypot(*(end - start)))
    at = style.places(length)
    lowest = 1 if has_shop else 0  # the shop has panes of its own
    storey, column = (part.ravel() for part in np.mgrid[lowest:storeys, : len(at)])
    along, base = at[column], 0.5 + STOREY_METRES * storey + 0.85
    width, height = (np.full(len(along), side) for side in (style.width, style.height))
    if style.is_low_above:
        height[storey == storeys - 1] = ATTIC_HEIGHT_METRES
    lit, blind = rng.uniform(0.0, 1.0, (2, len(along))) < [[LIT_SHARE], [style.blind_share]]
    shades, entrance = rng.uniform(0.75, 1.5, len(along)), np.zeros(len(along), bool)
    if door and not has_shop:
        entrance[len(at) // 2] = True
        base[entrance], height[entrance], lit[entrance] = 0.1, 2.3, False
    colours = shaded(PANE_COLOUR, shades)
    colours[entrance] = DOOR_COLOURS[int(rng.integers(len(DOOR_COLOURS)))]
    if not door:
        rows = np.flatnonzero(~blind)
        along, base, width, height, lit, colours, entrance = (
            part[rows] for part in (along, base, width, height, lit, colours, entrance)
        )
    ahead = (end - start) / length
    out = np.array([ahead[1], -ahead[0]])
    out *= np.sign(out @ (0.5 * (start + end) - middle[:2]))

    def laid(
        away: float, aside: Array | float, low: Array, wide: Array, high: Array | float
    ) -> Float[Array, "n 4 3"]:
        return _rectangles(start + away * out, ahead, along + aside, low, wide, high)

    panes = laid(0.06, 0.0, base, width, height)
    parts = [
        facing(panes[~lit], colours[~lit], Semantic.BUILDING, middle).made_of(Material.PANE),
        facing(panes[lit], colours[lit], Semantic.LIGHT, middle).made_of(Material.PANE),
    ]
    if detail < 2:
        frames = laid(0.03, 0.0, base - 0.08, width + 0.2, height + 0.16)
        parts.append(facing(frames, style.frame, Semantic.BUILDING, middle))
        if style.shutters is not None:
            beside = [
                laid(0.045, side * width * 0.77, base, 0.44 * width, height) for side in (-1, 1)
            ]
            leaves = np.concatenate([each[~entrance] for each in beside])
            parts.append(
                facing(leaves, style.shutters, Semantic.BUILDING, middle).made_of(Material.BOARDS)
            )
    if detail:
        return join(parts)
    if style.bars > 1:
        upper = laid(0.07, 0.0, base + 0.62 * height, width, 0.38 * height)
        glass = facing(upper[~lit], colours[~lit] * 1.25, Semantic.BUILDING, middle)
        parts.append(glass.made_of(Material.PANE))
    if style.bars > 0:
        bars = laid(0.08, 0.0, base, 0.0 * width + 0.07, height)
        parts.append(facing(bars, style.frame, Semantic.BUILDING, middle))
    if style.has_sills:
        sills = laid(0.1, 0.0, base - 0.1, width + 0.24, 0.07)[~entrance]
        parts.append(facing(sills, SILL_COLOUR, Semantic.BUILDING, middle))
    return join(parts)


def _rectangles(
    start: Array, ahead: Array, along: Array, low: Array, width: Array, height: Array | float
) -> Float[Array, "n 4 3"]:
    """Upright rectangles on a wall, by the middle of their lower edges."""
    found = np.empty((len(along), 4, 3))
    found[:, [0, 3], :2] = (start + (along - 0.5 * width)[:, None] * ahead)[:, None]
    found[:, [1, 2], :2] = (start + (along + 0.5 * width)[:, None] * ahead)[:, None]
    found[:, :2, 2], found[:, 2:, 2] = low[:, None], np.add(low, height)[:, None]
    return found


def _roof(
    rng: np.random.Generator,
    width: float,
    depth: float,
    high: float,
    middle: Array,
    gable: tuple[Colour, int],
    detail: int,
) -> Solid:
    """A gable roof with its ridge along the front, in strips of tiles."""
    colour = ROOF_COLOURS[int(rng.integers(len(ROOF_COLOURS)))]
    over, rise = 0.4, rng.uniform(0.28, 0.42) * depth
    strips, quads = (5, 2, 1)[detail], []
    for side in (0.0, 1.0):
        eave, ridge = (-over if side == 0.0 else depth + over), 0.5 * depth
        y = np.linspace(eave, ridge, strips + 1)
        h = high - 0.15 + (rise + 0.15) * np.linspace(0.0, 1.0, strips + 1)
        x = np.linspace(-over, width + over, (5, 3, 2)[detail])
        for k in range(strips):
            for a, b in itertools.pairwise(x):
                lower, upper = (y[k], h[k]), (y[k + 1], h[k + 1])
                quads.append([(a, *lower), (b, *lower), (b, *upper), (a, *upper)])
    tones = shaded(colour, rng.uniform(0.86, 1.08, len(quads)))
    gables = np.array(
        [[(x, 0.0, high), (x, depth, high), (x, 0.5 * depth, high + rise)] for x in (0.0, width)]
    )
    inside = middle + (0.0, 0.0, 0.4 * high)
    chimney = _chimney(0.3 * width, 0.42 * depth, high + 0.7 * rise)
    tiles = facing(np.array(quads), tones, Semantic.BUILDING, inside).made_of(Material.TILES)
    ends = facing(gables, gable[0], Semantic.BUILDING, inside).made_of(gable[1])
    return join([tiles, ends, chimney])


def _chimney(x: float, y: float, low: float) -> Solid:
    return box(
        (x, y, low), (x + 0.7, y + 0.6, low + 1.5), (120, 84, 70), Semantic.BUILDING
    ).made_of(Material.BRICK)
