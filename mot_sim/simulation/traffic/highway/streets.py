"""Streets that bend: lanes and rows of parked cars beside a middle line of lines and arcs."""

from collections.abc import Iterator, Sequence

import numpy as np
from highway_env.road.lane import AbstractLane
from highway_env.road.road import RoadNetwork
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.traffic.highway.layout import (
    DASHED,
    LANE_OFFSET_METRES,
    LANE_WIDTH_METRES,
    NONE,
    SOLID,
    STREET_SPEED,
    Kerb,
    Layout,
    Path,
    Segment,
    Start,
    circular_lane,
    straight_lane,
)

BEND_ACCELERATION = 2.2  # m/s2 sideways at the speed limit of a bend
# The bent street: metres straight on, then degrees to the right and the radius in metres of a
# bend. Our car passes two or three of them in 20 s, at 6 to 11 m/s and 8 to 20 degrees a second.
BENDS = (
    (78.0, -32.0, 50.0), (34.0, 82.0, 19.0), (52.0, -28.0, 60.0), (46.0, -74.0, 20.0),
    (58.0, 38.0, 45.0), (70.0, 0.0, 1.0),
)  # fmt: skip
EGO_START_METRES = 30.0
KERB_ENDS_METRES = (20.0, 4.0)  # without parked cars at an end of the street, and before a bend
MIN_KERB_METRES = 13.0

Pieces = Float[Array, "m 6"]  # as `Route.pieces`


def bent_street_layout() -> Layout:
    """One lane each way, 500 m with five bends, two of them corners; cars parked on both sides."""
    network = RoadNetwork()
    ours = _middle_line()
    paths: list[Path] = []
    straight: list[Segment] = []
    kerbs: list[Kerb] = []
    for pieces, start, end, left in (
        (ours, "west", "east", DASHED),
        (turned_back(ours), "east-end", "west-end", NONE),
    ):
        way = add_way(network, pieces, (start, end), (start, end), STREET_SPEED, left)
        paths.append(way)
        straight += [one for one, piece in zip(way, pieces, strict=True) if not piece[4]]
        kerbs += _kerbs(pieces)
    ego = Start((paths[0],), EGO_START_METRES)
    return Layout(network, tuple(paths), ego, tuple(straight), kerbs=tuple(kerbs))


def add_way(
    network: RoadNetwork,
    pieces: Pieces,
    places: tuple[str, str],
    nodes: tuple[str, str],
    limit: float,
    left: int,
) -> tuple[Segment, ...]:
    """Add the lanes to the right of a middle line, one after the other; their segments.

    places: what the nodes between are named after. nodes: where the first lane begins and the last
    ends. limit: m/s. left: what is painted there.
    """
    count, segments = len(pieces), []
    for number, piece in enumerate(pieces):
        begins = nodes[0] if number == 0 else f"{places[0]}-{places[1]} {number}"
        ends = nodes[1] if number == count - 1 else f"{places[0]}-{places[1]} {number + 1}"
        segments.append((begins, ends))
        network.add_lane(begins, ends, _lane(piece, limit, (left, SOLID)))
    return tuple(segments)


def kerb_beside(piece: Float[Array, "6"], begin: float, end: float, share: float = 1.0) -> Kerb:
    """The kerb to the right of a straight piece of a middle line, from and to metres along it."""
    _, x, y, heading, _, _ = piece.tolist()
    ahead = np.array([np.cos(heading), np.sin(heading)])
    start = np.array([x, y]) + LANE_WIDTH_METRES * np.array([-ahead[1], ahead[0]]) + begin * ahead
    return Kerb((float(start[0]), float(start[1])), heading, end - begin, share)


def turned_back(pieces: Pieces) -> Pieces:
    """The same middle line, driven from its end."""
    start, x, y, heading, curvature, length = pieces.T
    along, turn = length, curvature * length
    chord = along * np.sinc(turn / (2.0 * np.pi))
    x, y = x + chord * np.cos(heading + 0.5 * turn), y + chord * np.sin(heading + 0.5 * turn)
    total = start[-1] + length[-1]
    back = np.column_stack(
        (total - start - length, x, y, heading + turn + np.pi, -curvature, length)
    )
    return back[::-1]


def _middle_line(bends: Sequence[tuple[float, float, float]] = BENDS) -> Pieces:
    """The lines and arcs of the bent street, from the origin along +x."""
    rows: list[tuple[float, ...]] = []
    start = x = y = heading = 0.0
    for straight, degrees, radius in bends:
        turn = float(np.radians(degrees))
        for length, curvature in ((straight, 0.0), (radius * abs(turn), np.sign(turn) / radius)):
            if not length:
                continue
            rows.append((start, x, y, heading, curvature, length))
            half = 0.5 * curvature * length
            chord = length * float(np.sinc(half / np.pi))
            x, y = x + chord * np.cos(heading + half), y + chord * np.sin(heading + half)
            start, heading = start + length, heading + 2.0 * half
    return np.array(rows)


def _kerbs(pieces: Pieces) -> Iterator[Kerb]:
    """Rows of parking places to the right of all straight pieces that have room."""
    for number, piece in enumerate(pieces):
        begin = KERB_ENDS_METRES[number > 0]
        end = float(piece[5]) - KERB_ENDS_METRES[number < len(pieces) - 1]
        if not piece[4] and end - begin >= MIN_KERB_METRES:
            yield kerb_beside(piece, begin, end)


def _lane(piece: Float[Array, "6"], limit: float, lines: tuple[int, int]) -> AbstractLane:
    """The lane to the right of a piece of a middle line."""
    _, x, y, heading, curvature, length = piece.tolist()
    ahead = np.array([np.cos(heading), np.sin(heading)])
    right = np.array([-ahead[1], ahead[0]])
    start = np.array([x, y]) + LANE_OFFSET_METRES * right
    if not curvature:
        return straight_lane(start, start + length * ahead, limit, lines)
    radius = 1.0 / curvature - LANE_OFFSET_METRES  # signed: > 0 bends to the right
    slow = min(limit, float(np.sqrt(BEND_ACCELERATION * abs(radius))))
    first = heading - np.sign(radius) * 0.5 * np.pi
    return circular_lane(
        start + radius * right, abs(radius), first, curvature * length, slow, lines
    )
