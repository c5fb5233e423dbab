"""A highway, a merge onto one, and a two-way street with parked rows."""

from math import pi

from highway_env.road.road import RoadNetwork

from mot_sim.simulation.traffic.highway.layout import (
    DASHED,
    LANE_WIDTH,
    NONE,
    SOLID,
    Kerb,
    Layout,
    Path,
    Segment,
    Start,
    straight_lane,
)

FAST, STREET = 24.0, 12.0  # m/s
LANES = 3
LENGTH = 3000.0
STREET_LENGTH = 500.0
# The merge: x of the ramp's end, of the acceleration lane's end, and of the road's end.
RAMP_END, MERGE_END, MERGE_LENGTH = 200.0, 420.0, 2000.0
RAMP_FAST = 19.0


def _add_parallel(
    network: RoadNetwork, segment: Segment, x: tuple[float, float], lanes: int, closing: int = 0
) -> None:
    """Lanes side by side along x, the leftmost at y = 0; the last `closing` may not be entered."""
    for lane in range(lanes):
        y = lane * LANE_WIDTH
        marks = (SOLID if lane == 0 else DASHED, SOLID if lane == lanes - 1 else NONE)
        closes = lane >= lanes - closing
        network.add_lane(*segment, straight_lane((x[0], y), (x[1], y), FAST, marks, closes))


def highway_layout() -> Layout:
    """Three lanes, one way, 3 km."""
    network = RoadNetwork()
    segment = ("west", "east")
    _add_parallel(network, segment, (0.0, LENGTH), LANES)
    paths: tuple[Path, ...] = ((segment,),)
    return Layout(network, paths, Start(paths, 180.0, lane=1), (segment,), reach=180.0)


def merge_layout() -> Layout:
    """Two lanes and a ramp whose lane ends: its cars have to change to the left in time."""
    network = RoadNetwork()
    before, beside, after = ("west", "gore"), ("gore", "taper"), ("taper", "east")
    ramp = ("ramp", "gore")
    _add_parallel(network, before, (0.0, RAMP_END), 2)
    _add_parallel(network, beside, (RAMP_END, MERGE_END), 3, closing=1)
    _add_parallel(network, after, (MERGE_END, MERGE_LENGTH), 2)
    # The ramp comes in at 6 degrees and meets the outer lane's line at its beginning.
    start = (RAMP_END - 180.0, 2.0 * LANE_WIDTH + 19.0)
    network.add_lane(*ramp, straight_lane(start, (RAMP_END, 2.0 * LANE_WIDTH), RAMP_FAST))
    paths = ((before, beside, after), (ramp, beside, after))
    ego = Start((paths[0],), 60.0, lane=1)
    return Layout(network, paths, ego, (before, beside, after, ramp), reach=200.0)


def street_layout() -> Layout:
    """One lane each way, 500 m, cars parked on both sides."""
    network = RoadNetwork()
    right = 0.5 * LANE_WIDTH
    network.add_lane(
        "west", "east", straight_lane((0.0, right), (STREET_LENGTH, right), STREET, (DASHED, SOLID))
    )
    network.add_lane(
        "east-end",
        "west-end",
        straight_lane((STREET_LENGTH, -right), (0.0, -right), STREET, (NONE, SOLID)),
    )
    ours, theirs = ("west", "east"), ("east-end", "west-end")
    kerbs = (
        Kerb((30.0, LANE_WIDTH), 0.0, STREET_LENGTH - 60.0),
        Kerb((STREET_LENGTH - 30.0, -LANE_WIDTH), pi, STREET_LENGTH - 60.0),
    )
    return Layout(
        network, ((ours,), (theirs,)), Start(((ours,),), 40.0), (ours, theirs), kerbs=kerbs
    )
