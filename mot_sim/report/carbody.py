"""A schematic car inside its cuboid: faces with their colours, in fractions of the car's size."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.report.colours import GLASS, HEADLIGHT, SILL, TAILLIGHT, TYRE, Colour

VAN_HEIGHT = 2.0  # metres; cars from this height on have a van's cabin
WAIST = 0.56  # height of the windows' lower edge; vans: see `_cabin`


@dataclass(frozen=True, eq=False)
class Face:
    """A flat convex piece of the car's skin.

    corners: along (rear -.5, front .5), to the right (-.5 .. .5), up (0 .. 1). normal: its
    normal in these coordinates, away from the car. colour: None for the car's own paint.
    """

    corners: Float[Array, "n 3"]
    normal: Float[Array, "3"]
    colour: Colour | None = None

    @classmethod
    def of(
        cls,
        corners: Float[Array, "n 3"],
        outward: tuple[float, float, float],
        colour: Colour | None = None,
    ) -> "Face":
        """The face whose normal is on the side of `outward`."""
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[1])
        return cls(corners, normal if normal @ outward > 0.0 else -normal, colour)


@cache
def car_faces(is_van: bool) -> tuple[Face, ...]:
    """All faces, so ordered that later ones cover earlier ones (for a camera above the waist)."""
    waist = 0.50 if is_van else WAIST
    body = _hull((-0.5, 0.5), (-0.5, 0.5), (0.5, 0.5), (0.0, waist), None)
    sill = _hull((-0.5, 0.5), (-0.5, 0.5), (0.5, 0.5), (0.0, 0.13), SILL)[:4]
    cabin = _cabin(is_van, waist)
    return (*body, *sill, *_wheels(is_van), *_lights(), *cabin)


def _cabin(is_van: bool, waist: float) -> list[Face]:
    """The windows and the roof; a van's sides are of sheet metal but for the front doors."""
    if is_van:
        faces = _hull((-0.5, 0.42), (-0.49, 0.24), (0.5, 0.46), (waist, 1.0), None)
        front, _, right, left, _ = faces
        windows = [Face(front.corners, front.normal, GLASS)]
        for side in (right, left):
            lower, upper = side.corners[:2], side.corners[3:1:-1]
            quarter = np.array([0.06, 0.66])  # from the front end of the side
            a, b = (lower[0] + share * (lower[1] - lower[0]) for share in (0.02, 0.30))
            c, d = (upper[0] + share * (upper[1] - upper[0]) for share in (0.30, 0.04))
            pane = np.stack((a, b, b + quarter[1] * (c - b), a + quarter[1] * (d - a)))
            windows.append(Face(pane, side.normal, GLASS))
        return faces + windows
    faces = _hull((-0.44, 0.27), (-0.32, 0.10), (0.5, 0.40), (waist, 1.0), GLASS)
    roof = faces.pop()
    return [*faces, Face(roof.corners, roof.normal)]


def _hull(
    foot: tuple[float, float],
    top: tuple[float, float],
    halves: tuple[float, float],
    heights: tuple[float, float],
    colour: Colour | None,
) -> list[Face]:
    """Front, rear, right, left and top of a frustum with rectangles as foot and top.

    foot, top: where each begins and ends along the car; halves: half their widths.
    """
    low, high = heights
    rear, front = foot
    top_rear, top_front = top
    foot_half, top_half = halves

    def side(half: float, half_top: float) -> Float[Array, "4 3"]:
        return np.array(
            [(front, half, low), (rear, half, low),
             (top_rear, half_top, high), (top_front, half_top, high)]
        )  # fmt: skip

    right, left = side(foot_half, top_half), side(-foot_half, -top_half)
    quads = (
        (np.stack((right[0], left[0], left[3], right[3])), (1.0, 0.0, 0.35)),
        (np.stack((right[1], left[1], left[2], right[2])), (-1.0, 0.0, 0.25)),
        (right, (0.0, 1.0, 0.0)),
        (left, (0.0, -1.0, 0.0)),
        (np.stack((right[3], right[2], left[2], left[3])), (0.0, 0.0, 1.0)),
    )
    return [Face.of(corners, outward, colour) for corners, outward in quads]


def _wheels(is_van: bool) -> list[Face]:
    """Two discs on either side."""
    turn = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    along, up = (0.062, 0.145) if is_van else (0.075, 0.215)
    discs = []
    for half in (-0.5, 0.5):
        for axle in (-0.31, 0.31):
            for share, colour in ((1.0, TYRE), (0.55, (120, 124, 128))):
                rim = np.stack(
                    (axle + share * along * np.cos(turn), np.full(16, half),
                     up + share * up * np.sin(turn)), axis=1,
                )  # fmt: skip
                discs.append(Face.of(rim, (0.0, half, 0.0), colour))
    return discs


def _lights() -> list[Face]:
    """Two lamps in front, two behind."""
    lamps = []
    for end, colour in ((0.5, HEADLIGHT), (-0.5, TAILLIGHT)):
        for inner, outer in ((-0.30, -0.46), (0.30, 0.46)):
            corners = np.array(
                [(end, inner, 0.34), (end, outer, 0.34), (end, outer, 0.46), (end, inner, 0.46)]
            )
            lamps.append(Face.of(corners, (end, 0.0, 0.0), colour))
    return lamps
