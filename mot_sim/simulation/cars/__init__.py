"""The deformable fleet: shape coefficients -> mesh, keypoints, size; paints, look-alikes, files."""

from mot_sim.simulation.cars.carshape import PAINTS, CarShape, paint_colour
from mot_sim.simulation.cars.design import BODIES
from mot_sim.simulation.cars.files import export_car, load_car
from mot_sim.simulation.cars.fleet import Cars, Fleet, load_fleet, look_alike_ids
from mot_sim.simulation.cars.topology import PARTS, Topology, topology
from mot_sim.simulation.cars.vehicles import Models, Vehicles, VehicleSampler

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
