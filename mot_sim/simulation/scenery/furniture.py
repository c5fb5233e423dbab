"""What stands at the roadside: lamp posts, signs, guard rails, garden walls."""

import itertools

import numpy as np

from mot_sim.simulation.renderers import Semantic
from mot_sim.simulation.scenery.solids import Colour, Solid, box, facing, join, prism, shaded

STEEL: Colour = (128, 132, 134)
LAMP_HEIGHT = 6.5
ENAMEL: tuple[tuple[Colour, Colour, int], ...] = (  # rim, middle, corners
    ((176, 28, 32), (232, 232, 226), 12),
    ((24, 74, 150), (24, 74, 150), 12),
    ((176, 28, 32), (232, 232, 226), 3),
    ((226, 226, 220), (24, 74, 150), 4),
    ((226, 226, 220), (214, 178, 40), 4),
)


def lamp_post() -> Solid:
    """A lamp post at the origin; its arm reaches towards -y."""
    post = prism(0.09, 0.0, LAMP_HEIGHT, STEEL, Semantic.POLE, 6, 0.05)
    arm = box((-0.04, -1.5, LAMP_HEIGHT - 0.08), (0.04, 0.0, LAMP_HEIGHT), STEEL, Semantic.POLE)
    head = box(
        (-0.13, -1.9, LAMP_HEIGHT - 0.1), (0.13, -1.2, LAMP_HEIGHT + 0.05), STEEL, Semantic.POLE
    )
    glass = np.array(
        [[(-0.11, -1.85, 0.0), (0.11, -1.85, 0.0), (0.11, -1.25, 0.0), (-0.11, -1.25, 0.0)]]
    )
    glass[..., 2] = LAMP_HEIGHT - 0.11
    above = (0.0, -1.5, LAMP_HEIGHT)
    return join([post, arm, head, facing(glass, (238, 236, 220), Semantic.LIGHT, above)])


def sign(kind: int) -> Solid:
    """A traffic sign at the origin; it looks towards -x."""
    rim, middle, corners = ENAMEL[kind % len(ENAMEL)]
    pole = prism(0.035, 0.0, 2.75, STEEL, Semantic.POLE, 5)
    front = [_disc(corners, r, x) for r, x in ((0.36, -0.05), (0.27, -0.06))]
    back = _disc(corners, 0.36, -0.04)
    inside, behind = (0.0, 0.0, 2.4), (-0.3, 0.0, 2.4)
    plates = [
        facing(front[0], rim, Semantic.OTHER, inside),
        facing(front[1], middle, Semantic.OTHER, inside),
        facing(back, (120, 122, 124), Semantic.OTHER, behind),
    ]
    symbol = np.array(
        [[(-0.07, -0.05, 2.28), (-0.07, 0.05, 2.28), (-0.07, 0.05, 2.53), (-0.07, -0.05, 2.53)]]
    )
    return join([pole, *plates, facing(symbol, (30, 30, 32), Semantic.OTHER, inside)])


def _disc(corners: int, radius: float, x: float) -> np.ndarray:
    """A regular polygon as triangles around its middle, upright at an x."""
    turn = (np.arange(corners + 1) + 0.5 * (corners == 4)) * (2.0 * np.pi / corners)
    rim = np.stack((0.0 * turn + x, radius * np.sin(turn), 2.4 + radius * np.cos(turn)), axis=1)
    centre = np.broadcast_to(np.array([x, 0.0, 2.4]), rim[:-1].shape)
    return np.stack((centre, rim[:-1], rim[1:]), axis=1)


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
    return join([facing(stones, colours, Semantic.WALL, middle), top])
