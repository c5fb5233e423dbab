"""The deformable fleet: shape coefficients -> mesh, keypoints, size; paints, look-alikes, files."""

from mot_sim.simulation.cars.carshape import CarShape
from mot_sim.simulation.cars.design import BODIES
from mot_sim.simulation.cars.files import export_car, load_car
from mot_sim.simulation.cars.fleet import Cars, Fleet, load_fleet, look_alikes
from mot_sim.simulation.cars.paint import PAINTS, paint_colour
from mot_sim.simulation.cars.topology import PARTS, Topology, topology
from mot_sim.simulation.cars.vehicles import Cast, Casting, Models

__all__ = [
    "BODIES",
    "PAINTS",
    "PARTS",
    "CarShape",
    "Cars",
    "Cast",
    "Casting",
    "Fleet",
    "Models",
    "Topology",
    "export_car",
    "load_car",
    "load_fleet",
    "look_alikes",
    "paint_colour",
    "topology",
]
