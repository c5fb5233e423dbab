"""What the scenes of live traffic share: a road, how much drives on it, and its paint."""

from mot_sim.simulation.cars import Models, VehicleSampler
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.traffic import Traffic
from mot_sim.simulation.traffic.highway import HighwayTraffic
from mot_sim.simulation.traffic.highway.paint import roads_of
from mot_sim.simulation.traffic.traffic_state import STEP


def live_scene(
    name: str,
    road: str,
    *,
    cars: int,
    arrivals: float,
    frames: int,
    parked: float = 0.0,
    vans: int = 0,
    alike: float = 0.0,
    models: int = 24,
) -> Scene:
    """A scene on a road of `mot_sim.simulation.traffic.highway`; nobody crashes in it."""
    sampler = VehicleSampler(models=models, alike=alike)

    def traffic(models: Models) -> Traffic:
        return HighwayTraffic(
            road,
            cars=cars,
            arrivals=arrivals,
            parked=parked,
            vans=vans,
            sizes=models.size,
            van_size=models.van_size,
            clean_seconds=frames * STEP,
        )

    traffic(VehicleSampler(models=1).models_of(0))  # refuses wrong knobs at once
    return Scene(name, traffic, frames, roads_of(road), vehicle_sampler=sampler)
