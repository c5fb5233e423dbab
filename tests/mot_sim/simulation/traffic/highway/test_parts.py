"""highway-env is loaded in part, and whole for whoever wants it so."""

from tests.mot_sim.test_imports import HEAVY, modules_after

PARTS = "from mot_sim.simulation.traffic.highway import layout\n"
WHOLE = f"""{PARTS}
import highway_env, gymnasium
assert highway_env.road.lane.StraightLane is layout.StraightLane
assert "highway-v0" in gymnasium.registry
"""


def test_our_traffic_loads_neither_its_environments_nor_what_they_need() -> None:
    loaded = modules_after(PARTS)
    assert loaded.isdisjoint({*HEAVY, "gymnasium", "filterpy"} - {"highway_env"})


def test_whoever_imports_it_afterwards_has_all_of_it() -> None:
    assert "pandas" in modules_after(WHOLE)
