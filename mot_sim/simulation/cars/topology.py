"""The one mesh that all cars share: points, faces, parts, where the keypoints are.

Only the left half is built; points on the middle plane are shared, all others have a twin on
the right. A quad a, b, c, d is split along a-c.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.simulation.cars.design import Designs
from mot_sim.simulation.cars.shell import (
    RING,
    SPOKES,
    STATIONS,
    WHEEL_POINTS,
    cap,
    mirror,
    plate,
    shell,
    wheel,
)

PARTS = ("paint", "glass", "trim", "headlight", "taillight", "plate", "tyre", "rim")
WINDSCREEN = (5, 6)  # between these stations and the next
REAR_WINDOW = (12, 13)  # between these stations and the next
SIDE_WINDOWS = (5, 6, 7, 8, 10, 11)
B_PILLAR = 9
FRONT_CAP = STATIONS * len(RING)
REAR_CAP = STATIONS * len(RING) + 6
WHEELS = (REAR_CAP + 6, REAR_CAP + 6 + WHEEL_POINTS)
MIRROR = WHEELS[1] + WHEEL_POINTS
PLATES = (MIRROR + 8, MIRROR + 16)
HALF_POINTS = MIRROR + 24
Triangle = tuple[int, int, int, str]


def at(station: int, name: str) -> int:
    """The number of a point of the shell."""
    return station * len(RING) + RING.index(name)


# The left keypoints as pairs of points: each lies half way between the two (often the same).
# The authors' rows 0..17, and the mirror for the 14-point set.
KEYPOINTS: dict[str, tuple[int, int]] = {
    "rear_wheel": (WHEELS[1] + 3 * SPOKES,) * 2,
    "front_wheel": (WHEELS[0] + 3 * SPOKES,) * 2,
    "front_arch_ahead": (at(2, "s0"),) * 2,
    "front_arch_top_ahead": (at(3, "s0"),) * 2,
    "front_arch_top_behind": (at(5, "s0"),) * 2,
    "front_arch_behind": (at(6, "s0"),) * 2,
    "rear_arch_ahead": (at(12, "s0"),) * 2,
    "rear_arch_top_ahead": (at(13, "s0"),) * 2,
    "rear_arch_top_behind": (at(15, "s0"),) * 2,
    "rear_arch_behind": (at(16, "s0"),) * 2,
    "rear_bumper": (at(18, "s0"),) * 2,
    "taillight": (at(18, "s3"), at(18, "s4")),
    "rear_window_foot": (at(14, "t0"),) * 2,
    "roof_rear": (at(12, "t0"),) * 2,
    "roof_front": (at(7, "t0"),) * 2,
    "windscreen_foot": (at(5, "t0"),) * 2,
    "headlight": (at(0, "s3"), at(0, "s4")),
    "front_bumper": (at(0, "s0"),) * 2,
    "mirror": (MIRROR + 1, MIRROR + 7),
}
# What reaches furthest, and along which axis: the front plate, the roof, the middle of the side.
EXTREMES = ([PLATES[0] + 4, at(9, "t2"), at(9, "s2")], [0, 1, 2])


@dataclass(frozen=True, eq=False)
class Topology:
    """The faces of the whole car, and what they are made of."""

    faces: Int[Array, "f 3"]
    """Rows of the car's points, counter-clockwise from outside."""
    parts: Int[Array, " f"]
    """Index into PARTS of each face."""
    pieces: Int[Array, " f"]
    """Which closed piece each face belongs to: shell, four wheels, two mirrors, two plates."""
    twins: Int[Array, " v"]
    """For every point of the whole car its point of the left half."""
    on_right: Bool[Array, " v"]
    """Whether the point is a mirrored one, on the right."""


@cache
def topology() -> Topology:
    """The mesh of every car of the fleet."""
    shell = _strips() + _end(0, FRONT_CAP, True) + _end(STATIONS - 1, REAR_CAP, False)
    groups = [shell, _wheel(WHEELS[0]), _wheel(WHEELS[1]), _box(MIRROR, range(6))]
    groups += [_box(first, (0, 1, 2, 3, 5)) for first in PLATES]
    # The shell and the plates cross the middle: one piece each, not two.
    left_pieces, right_pieces = (0, 1, 2, 5, 7, 8), (0, 3, 4, 6, 7, 8)
    left = np.array([face[:3] for group in groups for face in group])
    names = np.array([PARTS.index(face[3]) for group in groups for face in group])
    counts = [len(group) for group in groups]
    off_centre = np.setdiff1d(np.arange(HALF_POINTS), _on_middle())
    right_of = np.arange(HALF_POINTS)
    right_of[off_centre] = HALF_POINTS + np.arange(len(off_centre))
    return Topology(
        np.concatenate((left, right_of[left[:, ::-1]])),
        np.concatenate((names, names)),
        np.concatenate((np.repeat(left_pieces, counts), np.repeat(right_pieces, counts))),
        np.concatenate((np.arange(HALF_POINTS), off_centre)),
        np.arange(HALF_POINTS + len(off_centre)) >= HALF_POINTS,
    )


def _on_middle() -> list[int]:
    """The half points on the middle plane."""
    ring = [at(station, name) for station in range(STATIONS) for name in ("b0", "t2")]
    caps = [first + 2 * row + 1 for first in (FRONT_CAP, REAR_CAP) for row in range(3)]
    return ring + caps + [first + corner for first in PLATES for corner in (0, 2, 4, 6)]


def _quad(a: int, b: int, c: int, d: int, part: str) -> list[Triangle]:
    return [(a, b, c, part), (a, c, d, part)]


def _strips() -> list[Triangle]:
    """The shell between its stations."""
    faces = []
    for i in range(STATIONS - 1):
        for low, high in pairwise(RING):
            a, b, c, d = at(i, low), at(i + 1, low), at(i + 1, high), at(i, high)
            faces += _quad(a, b, c, d, _material(i, low))
    return faces


def _material(station: int, low: str) -> str:
    """The part of the strip behind a station, from the ring's point `low` to the next."""
    part = "paint"
    if low in ("b0", "b1"):
        part = "trim"
    elif low == "s3" and station in (0, STATIONS - 2):
        part = "headlight" if station == 0 else "taillight"
    elif low == "g" and station in (*SIDE_WINDOWS, B_PILLAR):
        part = "trim" if station == B_PILLAR else "glass"
    elif low in ("u0", "t1") and station in (*WINDSCREEN, *REAR_WINDOW):
        part = "glass"
    return part


def _end(station: int, inside: int, front: bool) -> list[Triangle]:
    """The front or the rear of the shell, from the corner to the middle."""
    columns = [[at(station, name) for name in ("s0", "s1", "s2", "s3")]]
    for column, (low, _) in enumerate((("b1", "t1"), ("b0", "t2"))):
        columns.append([at(station, low), *(inside + 2 * row + column for row in range(3))])
    faces = []
    for row in range(3):
        dark = "trim" if (row == 0 or (front and row == 2)) else "paint"
        for outer, inner, part in ((0, 1, "paint"), (1, 2, dark)):
            a, b = columns[outer][row], columns[inner][row]
            faces += _quad(a, columns[outer][row + 1], columns[inner][row + 1], b, part)
    lamp, pivot = "headlight" if front else "taillight", columns[1][3]
    top = [columns[0][3], *(at(station, name) for name in ("s4", "g", "t0", "u0", "t1"))]
    faces += [(pivot, p, q, lamp) for p, q in pairwise(top)]
    faces += _quad(pivot, top[-1], at(station, "t2"), columns[2][3], "paint")
    return faces if front else [(c, b, a, part) for a, b, c, part in faces]


def _wheel(first: int) -> list[Triangle]:
    """Tyre and rim of a left wheel."""
    tyre, rim, inside = first, first + SPOKES, first + 2 * SPOKES
    hub, centre = first + 3 * SPOKES, first + 3 * SPOKES + 1
    faces: list[Triangle] = []
    for k in range(SPOKES):
        n = (k + 1) % SPOKES
        faces.append((hub, rim + n, rim + k, "rim"))
        faces += _quad(rim + k, rim + n, tyre + n, tyre + k, "tyre")
        faces += _quad(tyre + k, tyre + n, inside + n, inside + k, "tyre")
        faces.append((centre, inside + k, inside + n, "trim"))
    return faces


def _box(first: int, sides: range | tuple[int, ...]) -> list[Triangle]:
    """Sides of a box whose corners count along, up, left: -x, +x, bottom, top, right, left."""
    quads = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    part = "paint" if len(sides) == 6 else "plate"
    faces: list[Triangle] = []
    for side in sides:
        a, b, c, d = (first + corner for corner in quads[side])
        faces += _quad(a, b, c, d, part)
    return faces


def half_points(designs: Designs) -> Float[Array, "n h 3"]:
    """The left halves of cars: x forward, y down, z left, metres; the wheels stand on y = 0."""
    body = shell(designs)
    front, rear = cap(designs, body, True), cap(designs, body, False)
    count = len(body)
    pieces = (
        body,
        front,
        rear,
        wheel(designs, True),
        wheel(designs, False),
        mirror(designs, body),
        plate(designs, front, True),
        plate(designs, rear, False),
    )
    shapes = [(count, int(np.prod(piece.shape[1:-1])), 3) for piece in pieces]
    points = np.concatenate(
        [piece.reshape(shape) for piece, shape in zip(pieces, shapes, strict=True)], axis=1
    )
    assert points.shape[1] == HALF_POINTS
    return points * np.array([1.0, -1.0, 1.0])


def whole(half: Float[Array, "*n h 3"]) -> Float[Array, "*n v 3"]:
    """Cars, or their changes, from their left halves: the right is the exact mirror image."""
    shared = topology()
    sides = np.where(shared.on_right, -1.0, 1.0)
    points = half[..., shared.twins, :]
    points[..., 2] *= sides
    return points


def half_keypoints(half: Float[Array, "*n h 3"]) -> Float[Array, "*n 19 3"]:
    """The named points of the left side (see KEYPOINTS), in that order."""
    first, second = np.array(list(KEYPOINTS.values())).T
    return 0.5 * (half[..., first, :] + half[..., second, :])


def authors_keypoints(half: Float[Array, "*n h 3"]) -> Float[Array, "*n 38 3"]:
    """All keypoints: the authors' rows 0..17, their mirror images 18..35, and the two mirrors."""
    left = half_keypoints(half)
    right = left * np.array([1.0, 1.0, -1.0])
    return np.concatenate(
        (left[..., :18, :], right[..., :18, :], left[..., 18:, :], right[..., 18:, :]), axis=-2
    )
