"""A town: junctions, the curved streets between them, gates at its edge, and ways through it."""

import heapq
from collections.abc import Iterator
from dataclasses import dataclass
from math import radians
from types import MappingProxyType

import numpy as np
from highway_env.road.road import RoadNetwork
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.traffic.highway.layout import (
    ARM_SPEED,
    DASHED,
    NONE,
    STOP_LINE_METRES,
    Junction,
    Kerb,
    Layout,
    Path,
    Segment,
    Start,
    crossing_segments,
)
from mot_sim.simulation.traffic.highway.streets import MIN_KERB_METRES, add_way, kerb_beside
from mot_sim.simulation.traffic.scripted import Route

STUB_METRES = 45.0  # of a street that leads straight away from a junction, from its line
GATE_METRES = 120.0  # from the line of a junction to the gate at the edge of the town
BEND_RADIUS_METRES = 45.0  # of the bends of streets, where they have room for it
KERB_METRES = 42.0  # the longest row of parked cars; between two rows nobody parks
KERB_GAP_METRES = 14.0
KERB_SPARE_METRES = 12.0  # from a junction's line to the first parked car
EGO_START_METRES = 30.0  # along the lane behind the gate


@dataclass(frozen=True)
class Street:
    """A street from one arm to another, or to a gate."""

    start: tuple[str, int]
    """Name of a junction, and which of its arms."""
    end: tuple[str, int] | str
    """The same at its other end; or the name of a gate."""
    bend: float = 0.0
    """How far its middle lies to the right of the straight line, metres."""
    parked: float = 1.0
    """Part of the demanded share of parked cars that is found here, 0 to 1."""
    limit: float = ARM_SPEED
    """m/s."""


# A plan without a model: three by three junctions, none of which lies squarely to the next one.
# The first and third arms of a junction have priority, or those two of three that go straight on.
JUNCTIONS = MappingProxyType(
    {
        name: Junction(arms, centre, radians(heading), f"{name} ")
        for name, arms, centre, heading in (
            ("school", (0, 1, 3), (-200.0, -185.0), 12.0),
            ("market", (0, 1, 2), (0.0, -205.0), -9.0),
            ("station", (0, 1, 2), (205.0, -180.0), 15.0),
            ("mill", (0, 1, 2, 3), (-215.0, 10.0), -14.0),
            ("hall", (0, 1, 2, 3), (0.0, 0.0), 10.0),
            ("bridge", (1, 2, 3), (220.0, -5.0), -12.0),
            ("park", (0, 1, 3), (-190.0, 200.0), 17.0),
            ("church", (0, 2, 3), (15.0, 190.0), -11.0),
            ("harbour", (0, 2, 3), (205.0, 205.0), 18.0),
        )
    }
)
STREETS = (
    Street(("school", 0), ("market", 2), 14.0, 0.7),
    Street(("market", 0), ("station", 2), -16.0, 0.6),
    Street(("mill", 0), ("hall", 2), 12.0, 0.5, 12.5),
    Street(("hall", 0), ("bridge", 2), -14.0, 0.6, 12.5),
    Street(("park", 0), ("church", 2), 18.0, 1.0, 9.0),
    Street(("church", 0), ("harbour", 2), -12.0, 0.8),
    Street(("school", 1), ("mill", 3), -14.0, 1.0, 9.0),
    Street(("mill", 1), ("park", 3), 16.0, 0.7),
    Street(("market", 1), ("hall", 3), 13.0, 1.0, 9.0),
    Street(("hall", 1), ("church", 3), -15.0, 0.9, 9.0),
    Street(("station", 1), ("bridge", 3), 12.0, 0.5),
    Street(("bridge", 1), ("harbour", 3), -14.0, 0.7),
    Street(("school", 3), "north", 0.0, 0.5),
    Street(("station", 0), "hill", 0.0, 0.5),
    Street(("mill", 2), "west", 0.0, 0.5, 12.5),
    Street(("park", 1), "south", 0.0, 0.5),
    Street(("harbour", 0), "east", 0.0, 0.5),
)
# Ways of several minutes that our car drives, by the places that they lead past.
ROUTES = MappingProxyType(
    {
        "loop": "west mill hall bridge station market school mill park church harbour east",
        "old_town": "west mill school market hall church park mill hall bridge harbour east",
        "shore": "west mill park church hall market station bridge harbour church park south",
        "errands": "west mill hall market school mill park church hall bridge station hill",
    }
)


def town_layout() -> Layout:
    """Nine junctions, twelve streets with bends between them, five gates."""
    return _Town().layout()


class _Town:
    """Puts the network together."""

    def __init__(self) -> None:
        self.network = RoadNetwork()
        self.streets: dict[tuple[str, str], tuple[Segment, ...]] = {}
        self.ends: dict[tuple[str, str], int] = {}  # arm of the first place towards the second
        self.metres: dict[tuple[str, str], float] = {}
        self.fillable: list[Segment] = []
        self.kerbs: list[Kerb] = []
        self.across = {
            name: junction.add_lanes(self.network, _minor_arms(junction))
            for name, junction in JUNCTIONS.items()
        }
        for street in STREETS:
            self._add(street)

    def layout(self) -> Layout:
        """The network with its ways and rules."""
        routes = {name: self.path(places.split()) for name, places in ROUTES.items()}
        gates = sorted({street.end for street in STREETS if isinstance(street.end, str)})
        paths = [
            self.path(self._shortest(one, other))
            for one in gates
            for other in gates
            if one != other
        ]
        paths += routes.values()
        paths += [self.path(places.split()[::-1]) for places in ROUTES.values()]
        used = {segment for path in paths for segment in path}
        crossings: dict[Segment, frozenset[Segment]] = {}
        yields: dict[Segment, frozenset[Segment]] = {}
        for name, junction in JUNCTIONS.items():
            segments = self.across[name]
            here = crossing_segments(self.network, tuple(segments.values()))
            crossings |= here
            yields |= _yields(junction, segments, here)
        return Layout(
            self.network,
            tuple(paths),
            Start(tuple(routes.values()), EGO_START_METRES),
            tuple(segment for segment in self.fillable if segment in used),
            crossings,
            yields,
            kerbs=tuple(self.kerbs),
            routes=routes,
        )

    def path(self, places: list[str]) -> Path:
        """The way past places that are neighbours; the first and the last are gates."""
        found = list(self.streets[places[0], places[1]])
        for before, here, after in zip(places, places[1:], places[2:], strict=False):
            found.append(self.across[here][self.ends[here, before], self.ends[here, after]])
            found += self.streets[here, after]
        return tuple(found)

    def _shortest(self, start: str, end: str) -> list[str]:
        """The places on the shortest way between two gates."""
        heap, done = [(0.0, [start])], set()
        while heap:
            metres, places = heapq.heappop(heap)
            here = places[-1]
            if here == end:
                return places
            if here in done:
                continue
            done.add(here)
            for one, other in self.streets:
                if one == here and other not in done:
                    heapq.heappush(heap, (metres + self.metres[one, other], [*places, other]))
        raise AssertionError(f"no way from {start} to {end}")

    def _add(self, street: Street) -> None:
        """The lanes of a street in both directions, and its kerbs."""
        (one, arm), end = street.start, street.end
        other = end if isinstance(end, str) else end[0]
        points = _middle_line(street)
        self.ends[one, other] = arm
        first = JUNCTIONS[one].node("leave", arm), JUNCTIONS[one].node("line", arm)
        last = f"{end} out", f"{end} in"
        if not isinstance(end, str):
            self.ends[other, one] = end[1]
            last = JUNCTIONS[other].node("line", end[1]), JUNCTIONS[other].node("leave", end[1])
        self._add_way((one, other), (first[0], last[0]), points, street, DASHED)
        self._add_way((other, one), (last[1], first[1]), points[::-1], street, NONE)

    def _add_way(
        self,
        places: tuple[str, str],
        nodes: tuple[str, str],
        points: list[tuple[float, float]],
        street: Street,
        left: int,
    ) -> None:
        """The lanes of a street in one direction, one after the other."""
        pieces = Route(points, BEND_RADIUS_METRES).pieces
        segments = add_way(self.network, pieces, places, nodes, street.limit, left)
        last = len(pieces) - 1
        for number, (segment, piece) in enumerate(zip(segments, pieces, strict=True)):
            if not piece[4]:
                self.fillable.append(segment)
                self.kerbs += _rows(piece, street.parked, number == 0, number == last)
        self.streets[places] = segments
        self.metres[places] = float(pieces[:, 5].sum())


def _middle_line(street: Street) -> list[tuple[float, float]]:
    """The corners of a street's middle line, from the line of its first junction."""
    one, arm = JUNCTIONS[street.start[0]], street.start[1]
    near = [one.at(arm, STOP_LINE_METRES + along, 0.0) for along in (0.0, STUB_METRES)]
    if isinstance(street.end, str):
        far = [one.at(arm, STOP_LINE_METRES + GATE_METRES, 0.0)]
        near = near[:1]
    else:
        other, arm = JUNCTIONS[street.end[0]], street.end[1]
        far = [other.at(arm, STOP_LINE_METRES + along, 0.0) for along in (STUB_METRES, 0.0)]
        along = far[0] - near[1]
        aside = np.array([-along[1], along[0]]) / np.hypot(*along)
        near.append(0.5 * (near[1] + far[0]) + street.bend * aside)
    return [(float(x), float(y)) for x, y in (*near, *far)]


def _rows(piece: Float[Array, "6"], share: float, is_first: bool, is_last: bool) -> Iterator[Kerb]:
    """Short rows of parking places to the right of a straight piece."""
    length = float(piece[5])
    begin = KERB_SPARE_METRES if is_first else 0.0
    end = length - (KERB_SPARE_METRES if is_last else 0.0)
    while end - begin >= MIN_KERB_METRES:
        long = min(KERB_METRES, end - begin)
        yield kerb_beside(piece, begin, begin + long, share)
        begin += long + KERB_GAP_METRES


def _minor_arms(junction: Junction) -> set[int]:
    """The arms without priority: of four the second and the fourth, of three the single one."""
    if len(junction.arms) == 4:
        return {1, 3}
    return {arm for arm in junction.arms if (arm + 2) % 4 not in junction.arms}


def _yields(
    junction: Junction,
    segments: dict[tuple[int, int], Segment],
    crossings: dict[Segment, frozenset[Segment]],
) -> dict[Segment, frozenset[Segment]]:
    """Who goes first: the arms with priority; of these, who does not turn left."""
    minor = _minor_arms(junction)
    found = {}
    for (arm, target), segment in segments.items():
        first = {
            other
            for (from_arm, to_arm), other in segments.items()
            if from_arm not in minor
            and from_arm != arm
            and (arm in minor or (target == (arm + 1) % 4 and to_arm != (from_arm + 1) % 4))
        } & crossings[segment]
        if first:
            found[segment] = frozenset(first)
    return found
