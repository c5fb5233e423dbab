"""What stands beside roads one by one: lamp posts, wires, rails, walls, trees, bushes, hedges."""

import itertools
from collections.abc import Callable
from functools import cache, lru_cache
from itertools import pairwise

import numpy as np

from mot_sim.simulation.random_numbers import named_stream
from mot_sim.simulation.renderers import Material, Semantic, cross
from mot_sim.simulation.scenery.signs import STEEL_COLOUR, sign
from mot_sim.simulation.scenery.solids import Colour, Solid, box, facing, join, prism, shaded

LAMP_HEIGHT_METRES = 6.5
WIRE_HEIGHT_METRES, WIRE_SAG = 6.3, 0.02  # where it is fixed; how far it hangs, of its length
WIRE_WIDTHS = (0.024, 0.05)  # by detail, metres: about a pixel
WIRE_EDGES = ((-0.5, -0.3), (0.5, -0.3), (0.0, 0.6))  # aside and up, in widths
WIRE_COLOUR: Colour = (70, 72, 74)
LEAF_COLOURS: tuple[Colour, ...] = ((65, 90, 39), (82, 102, 47), (55, 82, 42), (96, 108, 53))
BARK_COLOUR: Colour = (84, 72, 58)
LEAF = Semantic.VEGETATION
TREE_KINDS = 6  # trees that differ; each place takes one, turned and scaled
# From near to far: tufts of a tree and a bush, and how large they are.
TREE_TUFTS = ((240, 0.5), (64, 0.85), (16, 1.5))
BUSH_TUFTS = ((50, 0.34), (18, 0.5), (6, 0.8))
DETAIL_LEVELS = 3  # by how near a thing is seen from: 0 = near
BUSH_KINDS = 4  # that differ
Make = Callable[[int, int], Solid]  # the number-th of a kind, at a detail


def lamp_post() -> Solid:
    """A lamp post at the origin; its arm reaches towards -y."""
    post = prism(0.09, 0.0, LAMP_HEIGHT_METRES, STEEL_COLOUR, Semantic.POLE, 6, 0.05)
    arm = box(
        (-0.04, -1.5, LAMP_HEIGHT_METRES - 0.08),
        (0.04, 0.0, LAMP_HEIGHT_METRES),
        STEEL_COLOUR,
        Semantic.POLE,
    )
    head = box(
        (-0.13, -1.9, LAMP_HEIGHT_METRES - 0.1),
        (0.13, -1.2, LAMP_HEIGHT_METRES + 0.05),
        STEEL_COLOUR,
        Semantic.POLE,
    )
    glass = np.array(
        [[(-0.11, -1.85, 0.0), (0.11, -1.85, 0.0), (0.11, -1.25, 0.0), (-0.11, -1.25, 0.0)]]
    )
    glass[..., 2] = LAMP_HEIGHT_METRES - 0.11
    above = (0.0, -1.5, LAMP_HEIGHT_METRES)
    return join([post, arm, head, facing(glass, (238, 236, 220), Semantic.LIGHT, above)])


def wire(start: np.ndarray, end: np.ndarray, detail: int) -> Solid:
    """A wire from the top of one lamp post to the next, x, y each; none is seen from far."""
    if detail >= len(WIRE_WIDTHS):
        return join([])
    share = np.linspace(0.0, 1.0, (9, 5)[detail])
    sag = WIRE_SAG * float(np.hypot(*(end - start)))
    high = WIRE_HEIGHT_METRES - 4.0 * sag * share * (1.0 - share)
    span = end - start
    line = np.column_stack((start + share[:, None] * span, high))
    aside = np.append(np.array([-span[1], span[0]]) / np.hypot(*span), 0.0)
    width = WIRE_WIDTHS[detail]
    edges = [line + width * (a * aside + (0.0, 0.0, up)) for a, up in WIRE_EDGES]
    sides = [
        facing(
            np.stack((one[:-1], one[1:], other[1:], other[:-1]), axis=1),
            WIRE_COLOUR,
            Semantic.POLE,
            0.5 * (line[:-1] + line[1:]),
        )
        for one, other in pairwise([*edges, edges[0]])
    ]
    return join(sides)


def rail(length: float, detail: int) -> Solid:
    """A guard rail along x from 0, on posts; detail: 0 = seen from near, 2 = from far."""
    posts = [
        box((x, -0.04, 0.0), (x + 0.1, 0.04, 0.6), (104, 106, 108), Semantic.POLE)
        for x in np.arange(0.5, length, 4.0).tolist()
    ]
    beams = [
        box((0.0, -0.09, low), (length, 0.09, low + 0.13), colour, Semantic.WALL)
        for low, colour in ((0.42, (150, 153, 155)), (0.58, (172, 175, 177)))
    ]
    return join(beams if detail == 2 else [*posts, *beams])


def garden_wall(length: float, tones: np.ndarray, detail: int) -> Solid:
    """A low wall of stones along x from 0, 1 m high; tones: of its stones, taken in turn."""
    wide = max(round(length / (0.8, 2.0, 10.0)[detail]), 1)
    x = np.linspace(0.0, length, wide + 1)
    quads = []
    for y in (-0.14, 0.14):
        for low in (0.0, 0.34, 0.68):
            quads += [
                [(a, y, low), (b, y, low), (b, y, low + 0.34), (a, y, low + 0.34)]
                for a, b in itertools.pairwise(x)
            ]
    stones = np.array(quads)
    colours = shaded((146, 132, 118), np.resize(tones, len(stones)))
    middle = (0.5 * length, 0.0, 0.5)
    top = box((-0.05, -0.18, 1.0), (length + 0.05, 0.18, 1.1), (168, 162, 152), Semantic.WALL)
    return join([facing(stones, colours, Semantic.WALL, middle).made_of(Material.BLOCKS), top])


@lru_cache(maxsize=128)
def tree(seed: int, kind: int, detail: int) -> Solid:
    """A tree about 7 m high around the origin; detail: 0 = seen from near."""
    rng = named_stream(seed, f"tree {kind}")
    green = LEAF_COLOURS[kind % len(LEAF_COLOURS)]
    wide, high, start = rng.uniform(1.7, 2.3), rng.uniform(2.3, 3.0), rng.uniform(1.7, 2.3)
    middle = np.array([0.0, 0.0, start + high])
    radii = np.array([wide, wide, high])
    trunk = prism(0.17, 0.0, start + 0.7 * high, BARK_COLOUR, LEAF, 5 - detail, 0.09)
    trunk = trunk.made_of(Material.BARK)
    core = _blob(middle, radii * 0.74, shaded(green, 1.2 * rng.uniform(0.62, 0.75, 20)))
    return join([trunk, core, _tufts(rng, middle, radii, green, *TREE_TUFTS[detail])])


@lru_cache(maxsize=128)
def bush(seed: int, kind: int, detail: int) -> Solid:
    """A bush about 1.4 m high around the origin."""
    rng = named_stream(seed, f"bush {kind}")
    green, middle, radii = (
        LEAF_COLOURS[(kind + 1) % 4],
        np.array([0.0, 0.0, 0.6]),
        np.array([0.8] * 3),
    )
    core = _blob(middle, radii * 0.8, shaded(green, rng.uniform(0.6, 0.75, 20)))
    return join([core, _tufts(rng, middle, radii, green, *BUSH_TUFTS[detail])])


def hedge(length: float, seed: int, number: int, detail: int) -> Solid:
    """A hedge along x from 0, 1.3 m high, 0.7 m thick."""
    rng = named_stream(seed, f"hedge {number}")
    green = LEAF_COLOURS[number % len(LEAF_COLOURS)]
    # Its surface is broken into many small faces of unlike greens.
    steps = max(round(length / (0.4, 1.2, 4.0)[detail]), 1)
    x = np.linspace(0.0, length, steps + 1) + np.r_[0.0, rng.uniform(-0.1, 0.1, steps - 1), 0.0]
    rough = rng.uniform(-0.07, 0.07, (4, 3, steps + 1))
    heights = (0.0, 0.65, 1.2)
    quads = []
    for side in (-1.0, 1.0):
        row = int(side > 0.0)
        rim = [
            np.stack((x, side * (0.3 + rough[row, k]), h + (k > 0) * rough[2 + row, k]), axis=1)
            for k, h in enumerate(heights)
        ]
        quads += [np.stack((a[:-1], a[1:], b[1:], b[:-1]), axis=1) for a, b in pairwise(rim)]
        quads.append(rim[-1])
    top = np.stack((quads[2][:-1], quads[2][1:], quads[5][1:], quads[5][:-1]), axis=1)
    walls = np.concatenate((*quads[0:2], *quads[3:5], top))
    ends = np.array(
        [[(e, -0.3, 0), (e, 0.3, 0), (e, 0.3, 1.2), (e, -0.3, 1.2)] for e in (0, length)]
    )
    solid = np.concatenate((walls, ends))
    inside = solid.mean(axis=1)
    inside[:, 1:] = 0.0, 0.6
    inside[-2:, 0] = 0.5 * length
    colours = shaded(green, rng.uniform(0.7, 1.15, len(solid)))
    return facing(solid, colours, LEAF, inside).made_of(Material.LEAF)


def _tufts(
    rng: np.random.Generator,
    middle: np.ndarray,
    radii: np.ndarray,
    green: Colour,
    count: int,
    size: float,
) -> Solid:
    """Triangles scattered over an ellipsoid, dark below and light above."""
    out = rng.standard_normal((count, 3))
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    centres = middle + out * radii * rng.uniform(0.72, 0.98, (count, 1))
    side = cross(out, rng.standard_normal((count, 3)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = cross(out, side) + rng.uniform(-0.5, 0.5, (count, 1)) * out
    reach = size * rng.uniform(0.6, 1.25, (count, 1))
    shapes = [centres + reach * (np.cos(t) * side + np.sin(t) * up) for t in (0.3, 2.2, 4.4)]
    light = 0.92 + 0.22 * out[:, 2] + rng.uniform(-0.24, 0.24, count)
    colours = shaded(green, light) + rng.uniform(-6, 10, (count, 1)) * (1.0, 0.6, 0.1)
    return facing(np.stack(shapes, axis=1), colours, LEAF, middle).made_of(Material.TUFT)


def _blob(middle: np.ndarray, radii: np.ndarray, colours: np.ndarray) -> Solid:
    """An ellipsoid of 20 faces: an icosahedron."""
    points, faces = _icosahedron()
    solid = facing(middle + points[faces] / 1.902 * radii, colours, LEAF, middle)
    return solid.made_of(Material.LEAF)


@cache
def _icosahedron() -> tuple[np.ndarray, np.ndarray]:
    """Its corners, and the rows of those of each face."""
    g = 0.5 * (1.0 + 5.0**0.5)
    points = np.array([(0, s, t * g) for s in (-1, 1) for t in (-1, 1)], float)
    points = np.concatenate((points, points[:, [2, 0, 1]], points[:, [1, 2, 0]]))
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    near = np.isclose(apart, 2.0)
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if near[a, b] and near[b, c] and near[a, c]
    ]
    return points, np.array(faces)


_lamp_post = lru_cache(lamp_post)


def makers(seed: int) -> dict[str, tuple[Make, float, bool]]:
    """For each kind: what makes it, half the width of its foot, whether it has leaves."""
    return {
        "tree": (lambda number, detail: tree(seed, number * 7 % TREE_KINDS, detail), 0.3, True),
        "bush": (lambda number, detail: bush(seed, number * 3 % BUSH_KINDS, detail), 0.6, True),
        "lamp": (lambda number, detail: _lamp_post(), 0.12, False),
        "sign": (
            lambda number, detail: sign(number * 3 + number // 5),
            0.12,
            False,
        ),
    }
