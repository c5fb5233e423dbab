"""What the roads of highway-env's lanes are painted with: asphalt, marks, kerbs, pavements."""

from dataclasses import dataclass

import numpy as np
from highway_env.road.lane import AbstractLane
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.traffic.highway.layout import DASHED, NONE, Kerb, Layout, Segment
from mot_sim.simulation.traffic.highway.traffic import ROADS
from mot_sim.simulation.traffic.roads import Lane, Roads, Surface, ribbon, stripe
from tracker.errors import UnknownName

MIN_MOTORWAY_SPEED = 17.0  # m/s: slower roads have kerbs and pavements, not shoulders
STRAIGHT_STEP_METRES = 20.0  # between the points of straight lanes
BENT_STEP_METRES = 1.0  # between the points of bent lanes
BAY_METRES = 2.4  # metres: the width of a parking bay
MARK_INSET_METRES = 0.12  # of marks from the lane's edge
STOP_LINE_METRES = 0.4  # width
GIVE_WAY_DASH_METRES = (0.5, 0.3)  # dash and gap
BEYOND_METRES = 160.0  # metres that roads go on behind the last place with cars


@dataclass(frozen=True)
class Style:
    """What lies beside lanes, and how they are marked."""

    shoulder: float
    """Width of the asphalt beyond a lane, metres."""
    kerb: float
    """Width of the kerb, metres; 0: none."""
    pavement: float
    """Width of the pavement, metres; 0: none."""
    mark: float
    """Width of the lines, metres."""
    dash: tuple[float, float]
    """Length of a dash and of the gap after it, metres."""


TOWN = Style(shoulder=0.0, kerb=0.15, pavement=2.6, mark=0.13, dash=(3.0, 3.0))
MOTORWAY = Style(shoulder=2.5, kerb=0.0, pavement=0.0, mark=0.16, dash=(6.0, 6.0))


def roads_of(name: str) -> Roads:
    """The ground of one of ROADS; UnknownName for another."""
    if name not in ROADS:
        raise UnknownName.of("road", name, ROADS)
    return painted(ROADS[name]())


def painted(layout: Layout) -> Roads:
    """The ground of a layout, and its lane graph. Where lanes end for good, the road goes on."""
    lanes = _lanes(layout)
    fastest = max(lane.speed_limit for _, lane, _ in lanes)
    style = MOTORWAY if fastest > MIN_MOTORWAY_SPEED else TOWN
    half = {id(lane): 0.5 * float(lane.width) for _, lane, _ in lanes}
    surfaces: list[Surface] = []
    bands = (
        ("pavement", style.shoulder + style.kerb + style.pavement),
        ("kerb", style.shoulder + style.kerb),
        ("asphalt", style.shoulder),
    )
    for paint, beyond in bands:
        if paint == "asphalt" or beyond > style.shoulder:
            for _, lane, centre in lanes:
                wide = half[id(lane)] + beyond
                surfaces += ribbon(paint, centre, -wide, wide)
            for kerb in layout.kerbs:
                surfaces += _bay(paint, kerb, beyond)
    for segment, lane, centre in lanes:
        if segment not in layout.crossings:
            surfaces += _marks(lane, centre, style)
    surfaces += _lines_to_wait_at(layout)
    graph = [
        Lane(centre, float(lane.width), *segment) for segment, lane, centre in _lanes(layout, 0.0)
    ]
    return Roads(tuple(surfaces), tuple(graph))


def _lanes(
    layout: Layout, beyond: float = BEYOND_METRES
) -> list[tuple[Segment, AbstractLane, Float[Array, "_ 2"]]]:
    """Every lane with its segment and its centre line, made longer at the ends of the network."""
    lanes = layout.network.lanes_dict().items()
    begins, ends = {index[0] for index, _ in lanes}, {index[1] for index, _ in lanes}
    found = []
    for index, lane in lanes:
        length = float(lane.length)
        bent = lane.heading_at(0.0) != lane.heading_at(0.7 * length)
        first = 0.0 if index[0] in ends else -beyond
        last = length if index[1] in begins else length + beyond
        count = (
            int(np.ceil((last - first) / (BENT_STEP_METRES if bent else STRAIGHT_STEP_METRES))) + 1
        )
        along = np.linspace(first, last, max(count, 2))
        centre = np.array([lane.position(s, 0.0) for s in along], dtype=float)
        found.append(((index[0], index[1]), lane, centre))
    return found


def _bay(paint: str, kerb: Kerb, beyond: float) -> list[Surface]:
    """The parking bay behind a kerb's line; beyond: how far this paint reaches around it."""
    along = np.array([np.cos(kerb.heading), np.sin(kerb.heading)])
    start = np.array(kerb.start) - 0.5 * along - beyond * along
    end = start + (kerb.length + 1.0 + 2.0 * beyond) * along
    return ribbon(paint, np.array([start, end]), -0.05, BAY_METRES + beyond)


def _marks(lane: AbstractLane, centre: Float[Array, "n 2"], style: Style) -> list[Surface]:
    """The lines on the left and right of a lane, just inside it."""
    surfaces: list[Surface] = []
    for side, kind in zip((-1.0, 1.0), lane.line_types, strict=True):
        if kind == NONE:
            continue
        aside = side * (0.5 * float(lane.width) - MARK_INSET_METRES)
        half = 0.5 * style.mark
        if kind == DASHED and lane.heading_at(0.0) == lane.heading_at(float(lane.length)):
            centre_line = _offset(centre, aside)
            surfaces += stripe(
                _pair(centre_line[0]), _pair(centre_line[-1]), style.mark, style.dash
            )
        elif kind == DASHED:
            length = float(lane.length)
            for first in np.arange(0.0, length, sum(style.dash)).tolist():
                last = min(first + style.dash[0], length)
                start, end = lane.position(first, aside), lane.position(last, aside)
                surfaces += stripe(_pair(start), _pair(end), style.mark)
        else:
            surfaces += ribbon("line", centre, aside - half, aside + half)
    return surfaces


def _lines_to_wait_at(layout: Layout) -> list[Surface]:
    """Stop lines before crossings, give-way lines (dashed) before merges and before crossings
    with a road that has priority; none on that road."""
    goes_first = {other[0] for first in layout.yields.values() for other in first}
    stops = {segment[0] for segment in layout.crossings} - goes_first
    yields = {segment[0] for segment in (*layout.merges, *layout.yields)} - goes_first
    surfaces = []
    for index, lane in layout.network.lanes_dict().items():
        if index[1] in stops | yields:
            at, half = float(lane.length) - 0.5, 0.5 * float(lane.width) - MARK_INSET_METRES
            ends = [_pair(lane.position(at, aside)) for aside in (-half, half)]
            dash = GIVE_WAY_DASH_METRES if index[1] in yields else None
            surfaces += stripe(ends[0], ends[1], STOP_LINE_METRES, dash)
    return surfaces


def _offset(centre: Float[Array, "n 2"], aside: float) -> Float[Array, "n 2"]:
    """A straight centre line moved to the right."""
    ahead = (centre[-1] - centre[0]) / np.hypot(*(centre[-1] - centre[0]))
    return centre + aside * np.array([-ahead[1], ahead[0]])


def _pair(point: Float[Array, "2"]) -> tuple[float, float]:
    return float(point[0]), float(point[1])
