"""Things keep off the road and off one another."""

import numpy as np
import pytest

from mot_sim.simulation.renderers import cross
from mot_sim.simulation.scenery.terrain import Terrain
from mot_sim.simulation.traffic.roads import Roads, Surface

ROAD = Roads((Surface("asphalt", np.array([(0.0, 0), (100, 0), (100, 6), (0, 6)])),))
SQUARE = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])


def at(*places: tuple[float, float]) -> np.ndarray:
    return np.array([SQUARE + place for place in places]).reshape(-1, 4, 2)


def test_who_comes_first_takes_the_room_and_others_find_none() -> None:
    terrain = Terrain.of(ROAD)
    places = at((20.0, 12.0), (21.0, 13.0), (30.0, 2.0), (40.0, 12.0), (1e3, 1e3))
    assert terrain.settle(places, 3.0) == [0, 3]
    assert terrain.settle(places, 3.0) == []
    assert terrain.settle(at((22.5, 12.0)), 3.0, spare=1.5) == []
    assert terrain.settle(at((22.5, 12.0)), 3.0, takes=False) == [0]
    assert terrain.settle(at((22.5, 12.0)), 3.0) == [0]


def test_distance_from_the_asphalt_is_kept_and_nothing_is_no_outline() -> None:
    terrain = Terrain.of(ROAD)
    assert terrain.settle(at((20.0, 8.0)), 3.0) == []
    assert terrain.settle(at((20.0, 8.0)), 1.0) == [0]
    assert terrain.settle(at(), 1.0) == []


def test_the_terrain_of_the_same_roads_is_free_again() -> None:
    first, again = Terrain.of(ROAD), Terrain.of(ROAD)
    assert first.settle(at((20.0, 12.0)), 3.0) == [0]
    assert not again.taken.any()
    assert first.lines(4.0) is again.lines(4.0)


@pytest.mark.parametrize("count", [0, 1, 7])
def test_cross_gives_the_bits_of_numpy(count: int) -> None:
    a, b = np.random.default_rng(count).standard_normal((2, count, 3))
    assert np.array_equal(cross(a, b), np.cross(a, b))
