"""The deformable fleet: shape coefficients -> mesh, keypoints, size; paints, look-alikes, files."""

from typing import TYPE_CHECKING

from mot_sim.simulation.cars.carshape import PAINTS, CarShape, paint_colour
from mot_sim.simulation.cars.design import BODIES
from mot_sim.simulation.cars.fleet import Cars, Fleet, load_fleet, look_alike_ids
from mot_sim.simulation.cars.topology import PARTS, Topology, topology
from mot_sim.simulation.cars.vehicles import Models, Vehicles, VehicleSampler
from tracker.lazy_names import lazy_names

if TYPE_CHECKING:
    from mot_sim.simulation.cars.files import export_car, load_car
else:  # they need trimesh
    _FILES = "mot_sim.simulation.cars.files"
    __getattr__, __dir__ = lazy_names(__name__, {"export_car": _FILES, "load_car": _FILES})

__all__ = [
    "BODIES",
    "PAINTS",
    "PARTS",
    "CarShape",
    "Cars",
    "Fleet",
    "Models",
    "Topology",
    "VehicleSampler",
    "Vehicles",
    "export_car",
    "load_car",
    "load_fleet",
    "look_alike_ids",
    "paint_colour",
    "topology",
]
