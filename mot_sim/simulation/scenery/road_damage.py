"""What years of traffic leave on asphalt: patches, cracks, manhole covers, tracks of wheels."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array
from scipy.spatial import KDTree

from mot_sim.simulation import random_numbers
from mot_sim.simulation.traffic.roads import Roads, ribbon

CELL_METRES = 9.0  # metres: one place for each kind of damage in every cell of this size
TRACK_HALF_METRES = 0.28  # half the width of the ribbon that tyres darken
TRACK_OFFSET_METRES = 0.78  # of those ribbons from the lane's centre
OIL_HALF_METRES = 0.25  # half the width of the oil's ribbon
COVER_RADIUS_METRES = 0.33  # metres: the radius of a manhole cover


@dataclass(frozen=True, eq=False)
class Mark:
    """A convex patch of other brightness."""

    corners: Float[Array, "n 2"]
    """Corners x, y in world, metres."""
    tone: int
    """Brightness, 0 to 255; 128 is the asphalt's own."""


@dataclass(frozen=True, eq=False)
class Crack:
    """An open polyline along which the asphalt is broken."""

    points: Float[Array, "n 2"]
    """Points x, y in world, metres, in order."""


@dataclass(frozen=True, eq=False)
class LaneWays:
    """Which way lanes lead, by the nearest piece of any."""

    middles: KDTree
    """x, y in world of the middles of the lanes' pieces, metres."""
    ways: Float[Array, "n 2"]
    """Unit vectors along each piece."""

    @classmethod
    def of(cls, roads: Roads) -> "LaneWays":
        """Those of all lanes; without lanes everything leads along x."""
        lines = [np.zeros((0, 2)), *(np.asarray(lane.centre)[:, :2] for lane in roads.lanes)]
        steps = np.concatenate([np.diff(line, axis=0) for line in lines])
        middles = np.concatenate([0.5 * (line[1:] + line[:-1]) for line in lines])
        lengths = np.hypot(*steps.T)
        keep = lengths > 0.0
        return cls(KDTree(middles[keep]), steps[keep] / lengths[keep, None])

    def at(self, point: Float[Array, "2"]) -> Float[Array, "2"]:
        """The way at a point x, y in world."""
        if not len(self.ways):
            return np.array([1.0, 0.0])
        return self.ways[self.middles.query(point)[1]]


def tracks_of(roads: Roads) -> list[Mark]:
    """Along each lane, where tyres roll and where oil drips."""
    found = []
    for lane in roads.lanes:
        for aside, half, tone in (
            (-TRACK_OFFSET_METRES, TRACK_HALF_METRES, 121),
            (TRACK_OFFSET_METRES, TRACK_HALF_METRES, 121),
        ):
            quads = ribbon("asphalt", lane.centre, aside - half, aside + half)
            found += [Mark(quad.corners, tone) for quad in quads]
        found += [
            Mark(quad.corners, 117)
            for quad in ribbon("asphalt", lane.centre, -OIL_HALF_METRES, OIL_HALF_METRES)
        ]
    return found


def damage_of(roads: Roads, seed: int, amount: float) -> tuple[list[Mark], list[Crack]]:
    """The damage of all cells with asphalt in them, drawn cell by cell.

    amount: 0 = a new road, 1 = a worn one.
    """
    cells = sorted(
        {
            (column, row)
            for surface in roads.surfaces
            if surface.paint == "asphalt"
            for column in _span(surface.corners[:, 0])
            for row in _span(surface.corners[:, 1])
        }
    )
    ids = np.array([column * 65_536 + row for column, row in cells], dtype=np.int64)
    chance = random_numbers.uniform(seed, "wear", ids, np.zeros_like(ids), 12)
    marks, cracks, ways = [], [], LaneWays.of(roads)
    for cell, number, draw in zip(cells, ids.tolist(), chance, strict=True):
        corner = CELL_METRES * np.array(cell, dtype=float)
        if draw[0] < 0.45 * amount:
            middle = corner + CELL_METRES * draw[1:3]
            marks.append(_patch(middle, ways.at(middle), draw[3:6]))
            outline = marks[-1].corners
            cracks.append(Crack(np.vstack((outline, outline[:1]))))  # its seam
        if draw[6] < 0.75 * amount:
            cracks += _cracks(corner + CELL_METRES * draw[7:9], draw[9], number, seed)
        if draw[10] < 0.10 + 0.05 * amount:
            marks += _cover(corner + CELL_METRES * draw[[2, 11]])
    return marks, cracks


def _span(values: Float[Array, " n"]) -> range:
    return range(
        int(np.floor(values.min() / CELL_METRES)), int(np.floor(values.max() / CELL_METRES)) + 1
    )


def _patch(middle: Float[Array, "2"], way: Float[Array, "2"], draw: Float[Array, "3"]) -> Mark:
    """A rectangle of newer asphalt along a way: fresh and dark, or of paler stones."""
    along, across = 0.6 + 2.6 * draw[0], 0.5 + 1.2 * draw[1]
    corners = np.array([(-along, -across), (along, -across), (along, across), (-along, across)])
    return Mark(
        middle + 0.5 * corners @ np.array([way, (-way[1], way[0])]),
        int(94 + 32 * draw[2] if draw[2] < 0.6 else 134 + 60 * (draw[2] - 0.6)),
    )


def _cracks(start: Float[Array, "2"], turn: float, cell: int, seed: int) -> list[Crack]:
    """A wandering crack and its mostly straight branch."""
    steps = random_numbers.normal(seed, "crack", np.full(22, cell), np.arange(22))[:, 0]
    heading = 2.0 * np.pi * turn + np.cumsum(0.35 * steps)
    ahead = 0.22 * np.stack((np.cos(heading), np.sin(heading)), axis=1)
    points = start + np.cumsum(ahead, axis=0)
    side = points[7] + np.cumsum(ahead[:8] @ np.array([[0.2, 1.0], [-1.0, 0.2]]), axis=0)
    return [Crack(points), Crack(np.vstack((points[7:8], side)))]


def _cover(middle: Float[Array, "2"]) -> list[Mark]:
    """A round iron cover in its frame."""
    turn = np.arange(20) * (2.0 * np.pi / 20)
    circle = np.stack((np.cos(turn), np.sin(turn)), axis=1)
    rings = (
        (COVER_RADIUS_METRES + 0.05, 150),
        (COVER_RADIUS_METRES, 70),
        (COVER_RADIUS_METRES - 0.04, 104),
    )
    bars = [
        Mark(middle + np.array([(-0.2, y), (0.2, y), (0.2, y + 0.03), (-0.2, y + 0.03)]), 78)
        for y in np.arange(-0.2, 0.2, 0.08)
    ]
    return [*(Mark(middle + radius * circle, tone) for radius, tone in rings), *bars]
