"""Trees, bushes and hedges: a dark core with tufts of leaves around it."""

from itertools import pairwise

import numpy as np

from mot_sim.simulation.random_numbers import named_stream
from mot_sim.simulation.renderers import Semantic
from mot_sim.simulation.scenery.solids import Colour, Solid, facing, join, prism, shaded

GREENS: tuple[Colour, ...] = ((62, 86, 36), (78, 98, 44), (52, 78, 40), (92, 104, 50))
BARK: Colour = (84, 72, 58)
LEAF = Semantic.VEGETATION
KINDS = 6  # trees that differ; each place takes one, turned and scaled
# From near to far: tufts of a tree and a bush, and how large they are.
TUFTS = ((240, 0.5), (64, 0.85), (16, 1.5))
BUSH_TUFTS = ((50, 0.34), (18, 0.5), (6, 0.8))


def trees(seed: int, detail: int) -> list[Solid]:
    """Trees about 7 m high around the origin, each another one; detail: 0 = seen from near."""
    return [_tree(seed, kind, detail) for kind in range(KINDS)]


def _tree(seed: int, kind: int, detail: int) -> Solid:
    rng = named_stream(seed, f"tree {kind}")
    green = GREENS[kind % len(GREENS)]
    wide, high, start = rng.uniform(1.7, 2.3), rng.uniform(2.3, 3.0), rng.uniform(1.7, 2.3)
    middle = np.array([0.0, 0.0, start + high])
    radii = np.array([wide, wide, high])
    trunk = prism(0.17, 0.0, start + 0.7 * high, BARK, LEAF, 5 - detail, 0.09)
    core = _blob(middle, radii * 0.74, shaded(green, rng.uniform(0.62, 0.75, 20)))
    return join([trunk, core, _tufts(rng, middle, radii, green, *TUFTS[detail])])


def bush(seed: int, kind: int, detail: int) -> Solid:
    """A bush about 1.4 m high around the origin."""
    rng = named_stream(seed, f"bush {kind}")
    green, middle, radii = GREENS[(kind + 1) % 4], np.array([0.0, 0.0, 0.6]), np.array([0.8] * 3)
    core = _blob(middle, radii * 0.8, shaded(green, rng.uniform(0.6, 0.75, 20)))
    return join([core, _tufts(rng, middle, radii, green, *BUSH_TUFTS[detail])])


def hedge(length: float, seed: int, number: int, detail: int) -> Solid:
    """A hedge along x from 0, 1.3 m high, 0.7 m thick."""
    rng = named_stream(seed, f"hedge {number}")
    green = GREENS[number % len(GREENS)]
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
    return facing(solid, shaded(green, rng.uniform(0.7, 1.15, len(solid))), LEAF, inside)


def _tufts(
    rng: np.random.Generator, middle: np.ndarray, radii: np.ndarray, green: Colour, count: int,
    size: float,
) -> Solid:  # fmt: skip
    """Triangles scattered over an ellipsoid, dark below and light above."""
    out = rng.standard_normal((count, 3))
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    centres = middle + out * radii * rng.uniform(0.72, 0.98, (count, 1))
    side = np.cross(out, rng.standard_normal((count, 3)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(out, side) + rng.uniform(-0.5, 0.5, (count, 1)) * out
    reach = size * rng.uniform(0.6, 1.25, (count, 1))
    shapes = [centres + reach * (np.cos(t) * side + np.sin(t) * up) for t in (0.3, 2.2, 4.4)]
    light = 0.92 + 0.22 * out[:, 2] + rng.uniform(-0.24, 0.24, count)
    colours = shaded(green, light) + rng.uniform(-6, 10, (count, 1)) * (1.0, 0.6, 0.1)
    return facing(np.stack(shapes, axis=1), colours, LEAF, middle)


def _blob(middle: np.ndarray, radii: np.ndarray, colours: np.ndarray) -> Solid:
    """An ellipsoid of 20 faces: an icosahedron."""
    g = 0.5 * (1.0 + 5.0**0.5)
    points = np.array([(0, s, t * g) for s in (-1, 1) for t in (-1, 1)], float)
    points = np.concatenate((points, points[:, [2, 0, 1]], points[:, [1, 2, 0]]))
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    near = np.isclose(apart, 2.0)
    faces = [
        (a, b, c)
        for a in range(12) for b in range(a + 1, 12) for c in range(b + 1, 12)
        if near[a, b] and near[b, c] and near[a, c]
    ]  # fmt: skip
    return facing(middle + points[np.array(faces)] / 1.902 * radii, colours, LEAF, middle)
