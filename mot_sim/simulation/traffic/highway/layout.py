"""What a road is made of: lanes on highway-env's network, ways through it, rules, kerbs."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from highway_env.road.lane import AbstractLane, CircularLane, LineType, StraightLane
from highway_env.road.road import RoadNetwork
from jaxtyping import Float
from numpy import ndarray as Array

LANE_WIDTH = 3.5
NONE, DASHED, SOLID = LineType.NONE, LineType.STRIPED, LineType.CONTINUOUS_LINE
Segment = tuple[str, str]  # the nodes that parallel lanes lead from and to
Point = tuple[float, float] | Float[Array, "2"]
Path = tuple[Segment, ...]  # a way through the network


@dataclass(frozen=True, eq=False)
class Kerb:
    """The right edge of a road, where cars may park: first point, heading, length."""

    start: tuple[float, float]
    heading: float
    length: float


@dataclass(frozen=True, eq=False)
class Start:
    """Where the ego car begins: one of these ways, so many metres along its first lane."""

    paths: tuple[Path, ...]
    distance: float
    lane: int = 0


@dataclass(frozen=True, eq=False)
class Layout:
    """A road: its lanes, the ways through it, who yields, where cars may park or begin.

    paths: from every entry. crossings: for a segment behind a stop line, those that may not be
    used at the same time (first come, first served). merges: segments behind a give-way line;
    they yield to whoever passes their end. fillable: segments on which cars stand at time 0.
    reach: metres around the ego's start within which they stand.
    """

    network: RoadNetwork
    paths: tuple[Path, ...]
    ego: Start
    fillable: tuple[Segment, ...]
    crossings: Mapping[Segment, frozenset[Segment]] = field(default_factory=dict)
    merges: frozenset[Segment] = frozenset()
    kerbs: tuple[Kerb, ...] = ()
    reach: float = 1e9


def straight_lane(
    start: Point, end: Point, limit: float,
    lines: tuple[int, int] = (SOLID, SOLID), forbidden: bool = False,
) -> AbstractLane:  # fmt: skip
    """A straight lane; lines: what is painted on its left and right."""
    return StraightLane(
        start, end, LANE_WIDTH, line_types=lines, forbidden=forbidden, speed_limit=limit
    )


def circular_lane(
    centre: Float[Array, "2"], radius: float, first: float, turn: float, limit: float
) -> AbstractLane:
    """A lane along a circle from phase `first` (radians); turn > 0 bends to the right."""
    return CircularLane(
        centre, radius, first, first + turn, clockwise=turn > 0.0, width=LANE_WIDTH,
        line_types=[NONE, NONE], speed_limit=limit,
    )  # fmt: skip


def turned(angle: float, along: float, right: float) -> Float[Array, "2"]:
    """The point so far along a direction and to the right of it."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * along - s * right, s * along + c * right])


def crossing_segments(
    network: RoadNetwork, segments: tuple[Segment, ...], clearance: float = 2.8
) -> dict[Segment, frozenset[Segment]]:
    """For every segment those that come nearer to it than `clearance`; not from the same line."""
    points = {}
    for one in segments:
        lane = network.get_lane((*one, 0))
        along = np.linspace(0.0, lane.length, 25)
        points[one] = np.array([lane.position(s, 0.0) for s in along])
    found: dict[Segment, frozenset[Segment]] = {}
    for one in segments:
        near = [
            other
            for other in segments
            if other[0] != one[0]
            and np.hypot(*(points[one][:, None] - points[other][None]).T).min() < clearance
        ]
        found[one] = frozenset(near)
    return found
