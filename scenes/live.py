"""What the scenes of live traffic share: a road, how much drives on it, and its paint."""

from mot_sim.simulation.cars import Models, VehicleSampler
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.traffic import Traffic
from mot_sim.simulation.traffic.highway import HighwayTraffic
from mot_sim.simulation.traffic.highway.paint import roads_of
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS


def live_scene(
    name: str,
    cars: int,
    arrivals: float,
    frames: int,
    alike: float,
    parked: float = 0.0,
    vans: int = 0,
    *,
    road: str | None = None,
    route: str = "any",
    wander: float = 0.0,
    bumps: float = 0.0,
    models: int = 24,
) -> Scene:
    """A scene on a road of `mot_sim.simulation.traffic.highway`, without crashes.

    road: by default the one of the scene's name. route: of our car, by name, where the road has
    such. wander, bumps: see `Demand`. models: shapes that the cars are drawn from.
    """
    road, seconds = road or name, frames * STEP_SECONDS

    def traffic(given: Models) -> Traffic:
        amounts = road, cars, arrivals, parked, vans
        return HighwayTraffic(
            *amounts,
            given.size,
            given.van_size,
            route=route,
            wander=wander,
            bumps=bumps,
            clean_seconds=seconds,
        )

    traffic(VehicleSampler(models=1).models_of(0))  # refuses wrong knobs at once
    sampler = VehicleSampler(models=models, alike=alike)
    return Scene(name, traffic, frames, roads_of(road), vehicle_sampler=sampler)
