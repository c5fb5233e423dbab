"""A four-way intersection, a T-junction, a roundabout: one lane each way, rows of parked cars."""

from collections.abc import Iterable
from math import pi

import numpy as np
from highway_env.road.road import RoadNetwork

from mot_sim.simulation.traffic.highway.layout import (
    DASHED,
    LANE_WIDTH,
    SOLID,
    Kerb,
    Layout,
    Path,
    Segment,
    Start,
    circular_lane,
    crossing_segments,
    straight_lane,
    turned,
)

ARMS = range(4)
OFFSET = 0.5 * LANE_WIDTH  # of a lane's centre from the middle of the road
ARM = 130.0  # metres from the centre to where cars come and go: farther than KITTI labels
LIMIT = 11.0  # m/s on the arms
EGO_ARM = 2  # so that the ego car begins towards +x

STOP = 10.0  # metres from the centre to the stop lines: right turns of 8.25 m, left of 11.75 m
TURN_RIGHT, TURN_LEFT = 5.0, 6.8  # m/s: 3 to 3.9 m/s2 sideways, 33 degrees a second

RING = 18.0  # radius of the roundabout's lane
ENTRY = 14.0  # radius of the bends into and out of it
RING_LIMIT = 6.5


def _arms(
    network: RoadNetwork, inner: float, arms: Iterable[int] = ARMS
) -> tuple[tuple[Segment, ...], tuple[Kerb, ...]]:
    """Lanes in and out on the arms, that end `inner` metres from the centre, and their kerbs."""
    segments: list[Segment] = []
    kerbs = []
    for arm in arms:
        angle = 0.5 * pi * arm
        far, near = turned(angle, ARM, -OFFSET), turned(angle, inner, -OFFSET)
        network.add_lane(
            f"from{arm}", f"line{arm}", straight_lane(far, near, LIMIT, (DASHED, SOLID))
        )
        near, far = turned(angle, inner, OFFSET), turned(angle, ARM, OFFSET)
        network.add_lane(f"leave{arm}", f"to{arm}", straight_lane(near, far, LIMIT, (SOLID, SOLID)))
        segments += [(f"from{arm}", f"line{arm}"), (f"leave{arm}", f"to{arm}")]
        start, length = inner + 14.0, 70.0
        inward = turned(angle, start + length, -LANE_WIDTH)
        kerbs.append(Kerb((inward[0], inward[1]), angle + pi, length))
        outward = turned(angle, start, LANE_WIDTH)
        kerbs.append(Kerb((outward[0], outward[1]), angle, length))
    return tuple(segments), tuple(kerbs)


def intersection_layout(arms: Iterable[int] = ARMS, begin: float = 60.0) -> Layout:
    """Arms that cross; whoever comes first goes first, with all that do not cross it.

    begin: metres along its arm at which the ego car stands at time 0.
    """
    arms = tuple(arms)
    network = RoadNetwork()
    segments, kerbs = _arms(network, STOP, arms)
    paths: list[Path] = []
    for arm in arms:
        angle = 0.5 * pi * arm
        start = turned(angle, STOP, -OFFSET)
        aside = turned(angle, 0.0, -1.0)  # to the right of who drives in
        right, left = STOP - OFFSET, STOP + OFFSET
        straight = (arm + 2) % 4
        lanes = {
            straight: straight_lane(start, turned(angle, -STOP, -OFFSET), LIMIT),
            (arm + 3) % 4: circular_lane(
                start + right * aside, right, angle + 0.5 * pi, 0.5 * pi, TURN_RIGHT
            ),
            (arm + 1) % 4: circular_lane(
                start - left * aside, left, angle - 0.5 * pi, -0.5 * pi, TURN_LEFT
            ),
        }
        for target, lane in lanes.items():
            if target not in arms:
                continue
            across = (f"line{arm}", f"leave{target}")
            network.add_lane(*across, lane)
            paths.append(((f"from{arm}", f"line{arm}"), across, (f"leave{target}", f"to{target}")))
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
    side = OFFSET + ENTRY
    inner = float(np.sqrt((RING + ENTRY) ** 2 - side**2))
    touch = float(np.arctan2(side, inner))  # from an arm's axis to where its bends meet the ring
    segments, kerbs = _arms(network, inner)
    bend = 0.5 * pi - touch
    for arm in ARMS:
        angle = 0.5 * pi * arm
        into = turned(angle, inner, -side)
        network.add_lane(
            f"line{arm}", f"in{arm}", circular_lane(into, ENTRY, angle + 0.5 * pi, bend, RING_LIMIT)
        )
        out = turned(angle, inner, side)
        network.add_lane(
            f"out{arm}", f"leave{arm}",
            circular_lane(out, ENTRY, angle - 0.5 * pi - bend, bend, RING_LIMIT),
        )  # fmt: skip
        ring = circular_lane(np.zeros(2), RING, angle + touch, -2.0 * touch, RING_LIMIT)
        network.add_lane(f"out{arm}", f"in{arm}", ring)
        rest = circular_lane(np.zeros(2), RING, angle - touch, 2.0 * touch - 0.5 * pi, RING_LIMIT)
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
    """In at an arm and out at the so many-th exit."""
    path: list[Segment] = [(f"from{arm}", f"line{arm}"), (f"line{arm}", f"in{arm}")]
    here = arm
    for number in range(exits):
        after = (here + 3) % 4
        path.append((f"in{here}", f"out{after}"))
        if number < exits - 1:
            path.append((f"out{after}", f"in{after}"))
        here = after
    return (*path, (f"out{here}", f"leave{here}"), (f"leave{here}", f"to{here}"))
