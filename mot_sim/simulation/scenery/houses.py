"""Houses: walls in storeys, windows with frames, doors, roofs."""

import itertools

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
PANE_COLOUR = (52, 62, 72)
PLINTH_COLOUR = (112, 108, 102)
DOOR_COLOURS: tuple[Colour, ...] = ((84, 56, 38), (44, 62, 52), (70, 30, 28), (52, 54, 60))
STOREY_METRES = 2.9  # height
WINDOW_METRES = (1.05, 1.4)  # width and height
FOOT_SHARE = 0.93  # of the light at the lowest storey, where the street hides some sky
LIT_SHARE = 0.35  # of the windows have a light behind them at night


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
    shop = int(Material.SHOP) if paints.random() < SHOP_SHARE else 0
    middle = np.array([0.5 * width, 0.5 * depth, 0.5 * high])
    ends = np.array([(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)])
    parts = [_roof(rng, width, depth, high, middle, (wall, gable), detail)]
    for side in range(4):
        start, end = ends[side], ends[(side + 1) % 4]
        own = made + (shop if side == 0 else 0)
        parts.append(_wall(rng, start, end, storeys, wall, middle, detail).made_of(own))
        if side != 2 or detail == 0:  # the back is hardly ever seen
            place = start, end, storeys, middle
            parts.append(_windows(seed * 4 + side, number, *place, frame, detail))
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
    frame: Colour,
    detail: int,
) -> Solid:
    """Frames and panes, a little before the wall; a door in the front."""
    rng, door = named_stream(seed, f"windows {number}"), seed % 4 == 0
    length = float(np.hypot(*(end - start)))
    count = max(int(length / 2.5), 1)
    at = (np.arange(count) + 0.5) * (length / count)
    low = np.array([0.5 + STOREY_METRES * storey + 0.85 for storey in range(storeys)])
    along, base = np.tile(at, storeys), np.repeat(low, count)
    width, height = (np.full(len(along), side) for side in WINDOW_METRES)
    lit = rng.uniform(0.0, 1.0, len(along)) < LIT_SHARE
    if door:
        base[count // 2], height[count // 2], lit[count // 2] = 0.1, 2.3, False
    ahead = (end - start) / length
    out = np.array([ahead[1], -ahead[0]])
    out *= np.sign(out @ (0.5 * (start + end) - middle[:2]))
    frames = _rectangles(start + 0.03 * out, ahead, along, base - 0.08, width + 0.2, height + 0.16)
    panes = _rectangles(start + 0.06 * out, ahead, along, base, width, height)
    colours = shaded(PANE_COLOUR, rng.uniform(0.75, 1.5, len(along)))
    if door:
        colours[count // 2] = DOOR_COLOURS[int(rng.integers(len(DOOR_COLOURS)))]
    bars = _rectangles(start + 0.08 * out, ahead, along, base, 0.07 + 0.0 * width, height)
    upper = _rectangles(
        start + 0.07 * out, ahead, along, base + 0.62 * height, width, 0.38 * height
    )
    parts = [
        facing(panes[~lit], colours[~lit], Semantic.BUILDING, middle).made_of(Material.PANE),
        facing(panes[lit], colours[lit], Semantic.LIGHT, middle).made_of(Material.PANE),
    ]
    if detail < 2:
        parts.append(facing(frames, frame, Semantic.BUILDING, middle))
    if detail:
        return join(parts)
    parts += [
        facing(upper[~lit], colours[~lit] * 1.25, Semantic.BUILDING, middle).made_of(Material.PANE),
        facing(bars, frame, Semantic.BUILDING, middle),
    ]
    return join(parts)


def _rectangles(
    start: Array, ahead: Array, along: Array, low: Array, width: Array, height: Array
) -> Float[Array, "n 4 3"]:
    """Upright rectangles on a wall, by the middle of their lower edges."""
    found = np.empty((len(along), 4, 3))
    found[:, [0, 3], :2] = (start + (along - 0.5 * width)[:, None] * ahead)[:, None]
    found[:, [1, 2], :2] = (start + (along + 0.5 * width)[:, None] * ahead)[:, None]
    found[:, :2, 2], found[:, 2:, 2] = low[:, None], (low + height)[:, None]
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
