"""The painted ground of highway-env's layouts."""

import cv2
import numpy as np
import pytest

from mot_sim.simulation.traffic.highway import ROADS
from mot_sim.simulation.traffic.highway.paint import painted, roads_of
from mot_sim.simulation.traffic.roads import PAINTS, ribbon
from tracker.errors import UnknownName


@pytest.mark.parametrize("name", sorted(ROADS))
def test_every_road_has_asphalt_under_all_its_lanes(name: str) -> None:
    roads = roads_of(name)
    assert {surface.paint for surface in roads.surfaces} <= set(PAINTS)
    asphalt = [s.corners.astype(np.float32) for s in roads.surfaces if s.paint == "asphalt"]
    assert len(roads.lanes) == len(ROADS[name]().network.lanes_dict())
    for lane in roads.lanes:
        assert lane.width == 3.5
        for point in lane.centre[:: max(len(lane.centre) // 5, 1)].tolist():
            assert any(cv2.pointPolygonTest(one, point, True) > -1e-3 for one in asphalt)


def test_lanes_meet_where_their_nodes_do() -> None:
    lanes = roads_of("intersection").lanes
    for lane in lanes:
        for after in (other for other in lanes if other.begins == lane.ends):
            assert np.allclose(lane.centre[-1], after.centre[0], atol=1e-6)


@pytest.mark.parametrize(("name", "count"), [("intersection", 4), ("highway", 0), ("street", 0)])
def test_stop_lines_stand_before_crossings_only(name: str, count: int) -> None:
    wide = [
        s
        for s in roads_of(name).surfaces
        if s.paint == "line" and np.isclose(np.hypot(*(s.corners[1] - s.corners[2])), 0.4)
    ]
    assert len(wide) == count


def test_streets_have_kerbs_and_motorways_have_none() -> None:
    paints = {name: {s.paint for s in painted(ROADS[name]()).surfaces} for name in ROADS}
    assert "kerb" in paints["street"]
    assert "kerb" not in paints["highway"]


def test_a_ribbon_lies_to_the_right_of_its_line() -> None:
    (quad,) = ribbon("line", np.array([(0.0, 0.0), (10.0, 0.0)]), 1.0, 2.0)
    assert quad.corners.min(axis=0).tolist() == [0.0, 1.0]
    assert quad.corners.max(axis=0).tolist() == [10.0, 2.0]


def test_an_unknown_road_is_refused_with_its_neighbour() -> None:
    with pytest.raises(UnknownName, match=r"unknown road 'hihgway'.*Did you mean 'highway'"):
        roads_of("hihgway")
