"""What a road is made of: lanes on highway-env's network, ways, rules, kerbs; and all roads."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import pi

import numpy as np
from highway_env.road.lane import AbstractLane, CircularLane, LineType, StraightLane
from highway_env.road.road import RoadNetwork
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.traffic.highway.lane_table import LaneTable

LANE_WIDTH_METRES = 3.5
NONE = LineType.NONE
DASHED = LineType.STRIPED
SOLID = LineType.CONTINUOUS_LINE
Segment = tuple[str, str]  # the nodes that parallel lanes lead from and to
Point = tuple[float, float] | Float[Array, "2"]
Path = tuple[Segment, ...]  # a way through the network
HIGHWAY_SPEED = 24.0  # m/s
STREET_SPEED = 12.0  # m/s
HIGHWAY_LANES = 3
HIGHWAY_METRES = 3000.0
STREET_METRES = 500.0
# The merge: x of the ramp's end, of the acceleration lane's end, and of the road's end.
RAMP_END_METRES = 200.0
MERGE_END_METRES = 420.0
MERGE_METRES = 2000.0
RAMP_SPEED = 19.0
ARMS = range(4)
LANE_OFFSET_METRES = 0.5 * LANE_WIDTH_METRES  # of a lane's centre from the middle of the road
ARM_METRES = 130.0  # metres from the centre to where cars come and go: farther than KITTI labels
ARM_SPEED = 11.0  # m/s on the arms
EGO_ARM = 2  # so that the ego car begins towards +x
STOP_LINE_METRES = 10.0  # from the centre: right turns of 8.25 m, left ones of 11.75 m
RIGHT_TURN_SPEED = 5.0  # m/s: 3.0 m/s2 sideways, 33 degrees a second
SLOW_SPEED = 5.5  # m/s straight across a road that has priority
LEFT_TURN_SPEED = 6.8  # m/s: 3.9 m/s2 sideways, 33 degrees a second
RING_RADIUS_METRES = 18.0  # radius of the roundabout's lane
ENTRY_RADIUS_METRES = 14.0  # radius of the bends into and out of it
RING_SPEED = 6.5


@dataclass(frozen=True, eq=False)
class Kerb:
    """The right edge of a road, where cars may park."""

    start: tuple[float, float]
    """First point x, y in world, metres."""
    heading: float
    """Of the line and of the cars parked there, radians from world +x towards +y."""
    length: float
    """Metres."""
    share: float = 1.0
    """Part of the demanded share of parked cars that is found here, 0 to 1."""


@dataclass(frozen=True, eq=False)
class Start:
    """Where the ego car begins."""

    paths: tuple[Path, ...]
    """Ways through the network that it may take, all with the same first segment; one is drawn."""
    distance: float
    """Metres along the first lane."""
    lane: int = 0
    """Number of that lane among the parallel ones, 0 for the leftmost."""


@dataclass(frozen=True, eq=False)
class Layout:
    """A road: its lanes, the ways through it, who yields, where cars may park or begin."""

    network: RoadNetwork
    """highway-env's lanes, in world."""
    paths: tuple[Path, ...]
    """Ways from every entry; cars arrive at the beginning of any of them."""
    ego: Start
    """Where our car begins."""
    fillable: tuple[Segment, ...]
    """Segments on which cars drive at time 0."""
    crossings: Mapping[Segment, frozenset[Segment]] = field(default_factory=dict)
    """For each segment behind a stop line, those that may not be used at the same time (first come,
    first served)."""
    yields: Mapping[Segment, frozenset[Segment]] = field(default_factory=dict)
    """For segments of `crossings` without priority, those of them whose cars go first."""
    merges: frozenset[Segment] = frozenset()
    """Segments behind a give-way line; they yield to whoever passes their end."""
    routes: Mapping[str, Path] = field(default_factory=dict)
    """Ways of `paths` that our car may be given by name."""
    kerbs: tuple[Kerb, ...] = ()
    """Where cars may park."""
    reach: float = 1e9
    """Metres around the ego car's start within which the other cars begin."""

    @cached_property
    def table(self) -> LaneTable:
        """All lanes in arrays."""
        return LaneTable(self.network.lanes_dict())


def straight_lane(
    start: Point,
    end: Point,
    limit: float,
    lines: tuple[int, int] = (SOLID, SOLID),
    forbidden: bool = False,
) -> AbstractLane:
    """A straight lane; lines: what is painted on its left and right."""
    return StraightLane(
        start, end, LANE_WIDTH_METRES, line_types=lines, forbidden=forbidden, speed_limit=limit
    )


def circular_lane(
    centre: Float[Array, "2"],
    radius: float,
    first: float,
    turn: float,
    limit: float,
    lines: tuple[int, int] = (NONE, NONE),
) -> AbstractLane:
    """A lane along a circle from phase `first` (radians); turn > 0 bends to the right."""
    return CircularLane(
        centre,
        radius,
        first,
        first + turn,
        clockwise=turn > 0.0,
        width=LANE_WIDTH_METRES,
        line_types=list(lines),
        speed_limit=limit,
    )


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


def _add_parallel(
    network: RoadNetwork, segment: Segment, x: tuple[float, float], lanes: int, closing: int = 0
) -> None:
    """Lanes side by side along x, the leftmost at y = 0; the last `closing` may not be entered."""
    for lane in range(lanes):
        y = lane * LANE_WIDTH_METRES
        marks = (SOLID if lane == 0 else DASHED, SOLID if lane == lanes - 1 else NONE)
        closes = lane >= lanes - closing
        network.add_lane(
            *segment, straight_lane((x[0], y), (x[1], y), HIGHWAY_SPEED, marks, closes)
        )


def highway_layout() -> Layout:
    """Three lanes, one way, 3 km."""
    network = RoadNetwork()
    segment = ("west", "east")
    _add_parallel(network, segment, (0.0, HIGHWAY_METRES), HIGHWAY_LANES)
    paths: tuple[Path, ...] = ((segment,),)
    return Layout(network, paths, Start(paths, 180.0, lane=1), (segment,), reach=180.0)


def merge_layout() -> Layout:
    """Two lanes and a ramp whose lane ends: its cars have to change to the left in time."""
    network = RoadNetwork()
    before, beside, after = ("west", "gore"), ("gore", "taper"), ("taper", "east")
    ramp = ("ramp", "gore")
    _add_parallel(network, before, (0.0, RAMP_END_METRES), 2)
    _add_parallel(network, beside, (RAMP_END_METRES, MERGE_END_METRES), 3, closing=1)
    _add_parallel(network, after, (MERGE_END_METRES, MERGE_METRES), 2)
    # The ramp comes in at 6 degrees and meets the outer lane's line at its beginning.
    start = (RAMP_END_METRES - 180.0, 2.0 * LANE_WIDTH_METRES + 19.0)
    network.add_lane(
        *ramp, straight_lane(start, (RAMP_END_METRES, 2.0 * LANE_WIDTH_METRES), RAMP_SPEED)
    )
    paths = ((before, beside, after), (ramp, beside, after))
    ego = Start((paths[0],), 60.0, lane=1)
    return Layout(network, paths, ego, (before, beside, after, ramp), reach=200.0)


def street_layout() -> Layout:
    """One lane each way, 500 m, cars parked on both sides."""
    network = RoadNetwork()
    right = 0.5 * LANE_WIDTH_METRES
    network.add_lane(
        "west",
        "east",
        straight_lane((0.0, right), (STREET_METRES, right), STREET_SPEED, (DASHED, SOLID)),
    )
    network.add_lane(
        "east-end",
        "west-end",
        straight_lane((STREET_METRES, -right), (0.0, -right), STREET_SPEED, (NONE, SOLID)),
    )
    ours, theirs = ("west", "east"), ("east-end", "west-end")
    kerbs = (
        Kerb((30.0, LANE_WIDTH_METRES), 0.0, STREET_METRES - 60.0),
        Kerb((STREET_METRES - 30.0, -LANE_WIDTH_METRES), pi, STREET_METRES - 60.0),
    )
    return Layout(
        network, ((ours,), (theirs,)), Start(((ours,),), 40.0), (ours, theirs), kerbs=kerbs
    )


def _arms(
    network: RoadNetwork, inner: float, arms: Iterable[int] = ARMS
) -> tuple[tuple[Segment, ...], tuple[Kerb, ...]]:
    """Lanes in and out on the arms, that end `inner` metres from the centre, and their kerbs."""
    segments: list[Segment] = []
    kerbs = []
    for arm in arms:
        angle = 0.5 * pi * arm
        far, near = (
            turned(angle, ARM_METRES, -LANE_OFFSET_METRES),
            turned(angle, inner, -LANE_OFFSET_METRES),
        )
        network.add_lane(
            f"from{arm}", f"line{arm}", straight_lane(far, near, ARM_SPEED, (DASHED, SOLID))
        )
        near, far = (
            turned(angle, inner, LANE_OFFSET_METRES),
            turned(angle, ARM_METRES, LANE_OFFSET_METRES),
        )
        network.add_lane(
            f"leave{arm}", f"to{arm}", straight_lane(near, far, ARM_SPEED, (SOLID, SOLID))
        )
        segments += [(f"from{arm}", f"line{arm}"), (f"leave{arm}", f"to{arm}")]
        start, length = inner + 14.0, 70.0
        inward = turned(angle, start + length, -LANE_WIDTH_METRES)
        kerbs.append(Kerb((inward[0], inward[1]), angle + pi, length))
        outward = turned(angle, start, LANE_WIDTH_METRES)
        kerbs.append(Kerb((outward[0], outward[1]), angle, length))
    return tuple(segments), tuple(kerbs)


@dataclass(frozen=True, eq=False)
class Junction:
    """Where arms meet at right angles; on each of them a lane leads in and one leads out."""

    arms: tuple[int, ...] = tuple(ARMS)
    """Which arms there are: arm k leads away at `heading` + k quarter turns."""
    centre: Point = (0.0, 0.0)
    """x, y in world, metres."""
    heading: float = 0.0
    """Of arm 0, radians from world +x towards +y."""
    name: str = ""
    """What the names of its nodes begin with."""

    def at(self, arm: int, along: float, right: float) -> Float[Array, "2"]:
        """The point so far out on an arm, and to the right of who leaves on it."""
        return np.asarray(self.centre) + turned(self.heading + 0.5 * pi * arm, along, right)

    def node(self, kind: str, arm: int) -> str:
        """The name of the node of an arm; kind: `line` where to wait, `leave` where to leave."""
        return f"{self.name}{kind}{arm}"

    def add_lanes(
        self, network: RoadNetwork, slow: Collection[int] = ()
    ) -> dict[tuple[int, int], Segment]:
        """Lanes from every arm to every other one, by the numbers of both.

        slow: arms whose cars cross slowly, since others have priority.
        """
        segments = {}
        right, left = STOP_LINE_METRES - LANE_OFFSET_METRES, STOP_LINE_METRES + LANE_OFFSET_METRES
        for arm in self.arms:
            angle = self.heading + 0.5 * pi * arm
            start = self.at(arm, STOP_LINE_METRES, -LANE_OFFSET_METRES)
            end = self.at(arm, -STOP_LINE_METRES, -LANE_OFFSET_METRES)
            aside = turned(angle, 0.0, -1.0)  # to the right of who drives in
            lanes = {
                (arm + 2) % 4: straight_lane(start, end, SLOW_SPEED if arm in slow else ARM_SPEED),
                (arm + 3) % 4: circular_lane(
                    start + right * aside, right, angle + 0.5 * pi, 0.5 * pi, RIGHT_TURN_SPEED
                ),
                (arm + 1) % 4: circular_lane(
                    start - left * aside, left, angle - 0.5 * pi, -0.5 * pi, LEFT_TURN_SPEED
                ),
            }
            for target, lane in lanes.items():
                if target in self.arms:
                    segments[arm, target] = self.node("line", arm), self.node("leave", target)
                    network.add_lane(*segments[arm, target], lane)
        return segments


def intersection_layout(arms: Iterable[int] = ARMS, begin: float = 60.0) -> Layout:
    """Arms that cross; whoever comes first goes first, with all that do not cross it.

    begin: metres along its arm at which the ego car stands at time 0.
    """
    arms = tuple(arms)
    network = RoadNetwork()
    segments, kerbs = _arms(network, STOP_LINE_METRES, arms)
    paths = [
        ((f"from{arm}", f"line{arm}"), across, (f"leave{target}", f"to{target}"))
        for (arm, target), across in Junction(arms).add_lanes(network).items()
    ]
    inner = tuple(path[1] for path in paths)
    return Layout(
        network,
        tuple(paths),
        ego=Start(tuple(path for path in paths if path[0][0] == f"from{EGO_ARM}"), begin),
        fillable=segments,
        crossings=crossing_segments(network, inner),
        kerbs=kerbs,
    )


def t_junction_layout() -> Layout:
    """Our road ends at a cross road: whoever comes from it turns, at 30 degrees a second."""
    return intersection_layout((1, EGO_ARM, 3), begin=85.0)


def roundabout_layout() -> Layout:
    """A ring with one lane and four arms; who enters gives way."""
    network = RoadNetwork()
    side = LANE_OFFSET_METRES + ENTRY_RADIUS_METRES
    inner = float(np.sqrt((RING_RADIUS_METRES + ENTRY_RADIUS_METRES) ** 2 - side**2))
    touch = float(np.arctan2(side, inner))  # from an arm's axis to where its bends meet the ring
    segments, kerbs = _arms(network, inner)
    bend = 0.5 * pi - touch
    for arm in ARMS:
        angle = 0.5 * pi * arm
        into = turned(angle, inner, -side)
        network.add_lane(
            f"line{arm}",
            f"in{arm}",
            circular_lane(into, ENTRY_RADIUS_METRES, angle + 0.5 * pi, bend, RING_SPEED),
        )
        out = turned(angle, inner, side)
        network.add_lane(
            f"out{arm}",
            f"leave{arm}",
            circular_lane(out, ENTRY_RADIUS_METRES, angle - 0.5 * pi - bend, bend, RING_SPEED),
        )
        ring = circular_lane(
            np.zeros(2), RING_RADIUS_METRES, angle + touch, -2.0 * touch, RING_SPEED
        )
        network.add_lane(f"out{arm}", f"in{arm}", ring)
        rest = circular_lane(
            np.zeros(2), RING_RADIUS_METRES, angle - touch, 2.0 * touch - 0.5 * pi, RING_SPEED
        )
        network.add_lane(f"in{arm}", f"out{(arm + 3) % 4}", rest)
    paths = tuple(_around(arm, exits) for arm in ARMS for exits in (1, 2, 3))
    return Layout(
        network,
        paths,
        ego=Start(tuple(path for path in paths if path[0][0] == f"from{EGO_ARM}"), 50.0),
        fillable=segments,
        merges=frozenset((f"line{arm}", f"in{arm}") for arm in ARMS),
        kerbs=kerbs,
    )


def _around(arm: int, exits: int) -> Path:
    """In at an arm and out at the first, second or third exit."""
    path: list[Segment] = [(f"from{arm}", f"line{arm}"), (f"line{arm}", f"in{arm}")]
    here = arm
    for number in range(exits):
        after = (here + 3) % 4
        path.append((f"in{here}", f"out{after}"))
        if number < exits - 1:
            path.append((f"out{after}", f"in{after}"))
        here = after
    return (*path, (f"out{here}", f"leave{here}"), (f"leave{here}", f"to{here}"))
