"""Where cars stand at time 0, and what is parked beside the road."""

from dataclasses import dataclass

import numpy as np
from highway_env.road.road import LaneIndex
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.traffic.highway.layout import Kerb, Layout
from tracker.errors import BadConfig

SPARE = 5.0  # metres between the bumpers of the longest cars at time 0
PARKING_SPARE = 1.2  # between parked ones
ASIDE = 0.3  # from the kerb's line to a parked car


@dataclass(frozen=True, eq=False)
class Slot:
    """A place for one car at time 0: a lane and the metres along it."""

    lane_index: LaneIndex
    along: float


def slots(layout: Layout, longest: float, seed: int) -> list[Slot]:
    """Places that are free at time 0, in an order drawn by the seed; the ego's is left out."""
    start = layout.ego
    ego_lane = (*start.paths[0][0], start.lane)
    ego = layout.network.get_lane(ego_lane).position(start.distance, 0.0)
    pitch = longest + SPARE
    found = []
    for segment in layout.fillable:
        for number in range(len(layout.network.graph[segment[0]][segment[1]])):
            index = (*segment, number)
            lane = layout.network.get_lane(index)
            # Nobody begins in the last metres before a line, where he could not stop any more.
            room = float(lane.length) - longest - 20.0
            for along in np.arange(longest, room, pitch).tolist():
                place = lane.position(along + 0.5 * SPARE, 0.0)
                if index == ego_lane and abs(along - start.distance) < 2.0 * pitch:
                    continue
                if np.hypot(*(place - ego)) < layout.reach:
                    found.append(Slot(index, along))
    rank = random_numbers.uniform(
        seed, "slot", np.arange(len(found)), np.zeros(len(found), np.int64), 2
    )
    moved = [
        Slot(slot.lane_index, slot.along + 0.8 * SPARE * float(share))
        for slot, share in zip(found, rank[:, 1], strict=True)
    ]
    return [moved[row] for row in np.argsort(rank[:, 0], kind="stable").tolist()]


def choose_slots(layout: Layout, count: int, longest: float, seed: int, name: str) -> list[Slot]:
    """So many places. Raises BadConfig for more than the road holds."""
    free = slots(layout, longest, seed)
    if count > len(free):
        raise BadConfig(
            f"{count} cars on the {name}: it holds {len(free)} of {longest:g} m beside ours at "
            "time 0; ask for fewer, or let more arrive"
        )
    return free[:count]


@dataclass(frozen=True, eq=False)
class Parked:
    """Cars that never move, beside the road."""

    poses: Float[Array, "n 3"]
    size: Float[Array, "n 3"]


def park(
    layout: Layout,
    share: float,
    vans: int,
    sizes: Float[Array, "m 3"],
    van: tuple[float, float, float],
    seed: int,
) -> Parked:
    """Parked cars on a share of all kerb places, and vans on those nearest to the origin.

    The origin is the middle of a junction: there vans hide the most.
    """
    pitch = float(max(sizes[:, 0].max(), van[0])) + PARKING_SPARE
    places = [place for kerb in layout.kerbs for place in _places(kerb, pitch)]
    by_distance = np.argsort([np.hypot(*place[:2]) for place in places], kind="stable")
    if vans > len(places):
        raise BadConfig(f"{vans} parked vans: the kerbs hold {len(places)}")
    count = len(places)
    chance = random_numbers.uniform(seed, "parked", np.arange(count), np.zeros(count, np.int64), 3)
    is_van = np.zeros(count, dtype=bool)
    is_van[by_distance[:vans]] = True
    poses, size = [], []
    for number, (x, y, heading) in enumerate(places):
        if not is_van[number] and chance[number, 0] >= share:
            continue
        one = np.array(van) if is_van[number] else sizes[int(chance[number, 1] * len(sizes))]
        aside = ASIDE + 0.5 * float(one[2])
        along = (float(chance[number, 2]) - 0.5) * 0.6 * PARKING_SPARE
        c, s = np.cos(heading), np.sin(heading)
        poses.append((x + c * along - s * aside, y + s * along + c * aside, heading))
        size.append(one)
    return Parked(np.array(poses).reshape(-1, 3), np.array(size).reshape(-1, 3))


def _places(kerb: Kerb, pitch: float) -> list[tuple[float, float, float]]:
    """Points on the kerb's line before the middles of its places, with the heading."""
    c, s = np.cos(kerb.heading), np.sin(kerb.heading)
    along = np.arange(0.5 * pitch, kerb.length - 0.5 * pitch + 1e-9, pitch).tolist()
    return [(kerb.start[0] + c * a, kerb.start[1] + s * a, kerb.heading) for a in along]
