"""What stands before the camera: the cars of a state, each with its mesh in its place."""

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.cars import PARTS, CarShape
from mot_sim.simulation.cars.coarse import LEVEL_DISTANCES, coarse_levels
from mot_sim.simulation.cars.finish import skin_of
from mot_sim.simulation.cars.vehicles import Vehicles
from mot_sim.simulation.renderers import Mesh, MeshInstances, Semantic
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.traffic.traffic_state import TrafficState
from tracker.types import Cuboids

# What each of PARTS is to the semantic image.
PART_SEMANTICS = {
    "paint": Semantic.CAR, "glass": Semantic.GLASS, "trim": Semantic.TRIM,
    "headlight": Semantic.LIGHT, "taillight": Semantic.LIGHT, "plate": Semantic.PLATE,
    "tyre": Semantic.TYRE, "rim": Semantic.TYRE,
}  # fmt: skip
SEMANTICS = np.array([PART_SEMANTICS[part] for part in PARTS], np.uint8)
DISTANCES = (0.0, *LEVEL_DISTANCES.values())  # metres: where each level of a car begins


@dataclass(frozen=True, eq=False)
class SceneMeshes:
    """The cars of a run and the camera that looks at them."""

    vehicles: Vehicles
    """Who the cars are."""
    rig: Rig
    """The camera on the ego car."""
    parked: frozenset[int] = frozenset()
    """Ids of cars that nobody sits in: their lamps are off."""
    made: dict[tuple[int, int], Mesh] = field(default_factory=dict)
    """Meshes made so far, by row of the vehicles and level."""

    def mesh(self, row: int, level: int = 0) -> Mesh:
        """The coloured mesh of a row of `vehicles`: the whole one (0) or a coarser level."""
        if (row, level) not in self.made:
            shape, distance = self.vehicles.shapes[row], DISTANCES[level]
            painted = mesh_of(shape, str(self.vehicles.paints[row]))
            mesh = painted if level == 0 else coarser(painted, distance)
            self.made[row, level] = finished(mesh, shape, distance)
        return self.made[row, level]

    def instances(self, state: TrafficState, scenery: MeshInstances | None = None) -> MeshInstances:
        """The cars of a state, their ids as instances, then the scenery.

        The farther a car is, the fewer faces it has; see `mot_sim.simulation.cars.coarse`.
        """
        cuboids = self.rig.cuboids(state)
        distance = np.hypot(cuboids.base[:, 0], cuboids.base[:, 2])
        levels = np.searchsorted(list(coarse_levels()), distance, side="right").tolist()
        rows = self.vehicles.rows(state.ids).tolist()
        meshes = tuple(self.mesh(row, level) for row, level in zip(rows, levels, strict=True))
        Ts = Ts_cam_object(cuboids, self.rig)
        unlit = tuple(number for number in state.ids.tolist() if number in self.parked)
        cars = MeshInstances(meshes, Ts, state.ids, unlit)
        return cars if scenery is None else cars.beside(scenery)


def mesh_of(shape: CarShape, paint: str) -> Mesh:
    """A car as the renderers take it."""
    return Mesh(shape.vertices, shape.faces, shape.colours(paint), semantics_of(shape))


def coarser(mesh: Mesh, distance: float) -> Mesh:
    """A car's mesh with the faces of the level that begins at a distance, metres."""
    level = coarse_levels()[distance]
    colours, semantics = mesh.colours[level.origins], mesh.semantics[level.origins]
    return Mesh(mesh.vertices, level.faces, colours, semantics)


def finished(mesh: Mesh, shape: CarShape, distance: float = 0.0) -> Mesh:
    """The mesh of a car with the skin that takes light smoothly; distance: of its level."""
    return replace(mesh, make_skin=partial(skin_of, shape, distance))


def semantics_of(shape: CarShape) -> UInt8[Array, " f"]:
    """A `Semantic` of each face."""
    return SEMANTICS[shape.parts]


def Ts_cam_object(cuboids: Cuboids, rig: Rig) -> Float[Array, "n 4 4"]:
    """From the object frames of cuboids (origin in the middle of the bottom face) to the camera."""
    c, s = np.cos(cuboids.yaw), np.sin(cuboids.yaw)
    Ts_road_object = np.zeros((len(cuboids), 4, 4))
    Ts_road_object[:, 0, 0], Ts_road_object[:, 0, 2] = c, s
    Ts_road_object[:, 2, 0], Ts_road_object[:, 2, 2] = -s, c
    Ts_road_object[:, 1, 1] = Ts_road_object[:, 3, 3] = 1.0
    Ts_road_object[:, :3, 3] = cuboids.base
    return rig.camera.T_cam_road @ Ts_road_object


__all__ = [
    "SceneMeshes",
    "Ts_cam_object",
    "coarser",
    "finished",
    "mesh_of",
    "semantics_of",
]
