"""How light falls on a car: which corners are smooth, and how much of the sky each point sees."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.cars.carshape import CarShape
from mot_sim.simulation.cars.coarse import coarse_levels
from mot_sim.simulation.cars.shell import SPOKES
from mot_sim.simulation.cars.topology import PARTS, PLATES, WHEELS, topology
from mot_sim.simulation.renderers.view import Pattern, Skin

SHIPPED_OPENNESS = Path(__file__).with_name("openness.npz")
CREASE_COSINE = 0.62  # faces that are turned less than this against each other are one surface
DOWNWARD = 0.7  # of a face's normal: nobody sees it, so it does not count for its points
RAYS = 192  # from each point
LIFT_METRES = 0.02  # by which rays begin above the surface
ROAD_LIGHT = 0.55  # of the sky's, from the road
CLEARANCE_METRES = 0.2  # beneath a car: the road there is as dark as that lets it be
PLATE_PARTS = PARTS.index("plate")
WHEEL_PARTS = (PARTS.index("tyre"), PARTS.index("rim"))


@dataclass(frozen=True, eq=False)
class Neighbours:
    """For each corner of each face of a mesh, the faces around it that it may be smooth with."""

    others: Int[Array, " p"]
    """Faces, corner by corner."""
    own: Int[Array, " p"]
    """The face whose corner it is."""
    starts: Int[Array, " c"]
    """Where those of each corner begin; three corners a face."""

    @classmethod
    def of(cls, faces: Int[Array, "f 3"], groups: Int[Array, " f"]) -> "Neighbours":
        """The faces of the same group around each corner, itself among them."""
        order = np.argsort(faces.ravel(), kind="stable")
        vertices, at = faces.ravel()[order], order // 3
        first = np.searchsorted(vertices, faces.ravel(), "left")
        last = np.searchsorted(vertices, faces.ravel(), "right")
        counts = last - first
        corner = np.repeat(np.arange(faces.size), counts)
        step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        others, own = at[first[corner] + step], corner // 3
        keep = groups[others] == groups[own]
        starts = np.searchsorted(corner[keep], np.arange(faces.size))
        return cls(others[keep], own[keep], starts)

    def smooth(self, across: Float[Array, "f 3"]) -> Float[Array, "f 3 3"]:
        """Unit normals at the corners; across: the faces' normals, twice their areas long."""
        length = np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
        unit = across / length
        alike = (unit[self.others] * unit[self.own]).sum(axis=1) > CREASE_COSINE
        summed = np.add.reduceat(across[self.others] * alike[:, None], self.starts, axis=0)
        size = np.linalg.norm(summed, axis=1, keepdims=True)
        own = np.repeat(unit, 3, axis=0)
        return np.where(size > 1e-12, summed / np.maximum(size, 1e-12), own).reshape(-1, 3, 3)


@cache
def smooth_neighbours(level: float) -> Neighbours:
    """Those of the whole mesh (0), or of the coarser one that begins at a distance, metres."""
    shared = topology()
    groups = shared.parts * (1 + shared.pieces.max()) + shared.pieces
    if level == 0.0:
        return Neighbours.of(shared.faces, groups)
    coarse = coarse_levels()[level]
    return Neighbours.of(coarse.faces, groups[coarse.origins])


@cache
def vertex_openness() -> UInt8[Array, " v"]:
    """Share of the light around that each point of the shared mesh gets, 255 = all."""
    with np.load(SHIPPED_OPENNESS, allow_pickle=False) as file:
        found: UInt8[Array, " v"] = file["openness"]
    return found


def skin_of(shape: CarShape, distance: float = 0.0) -> Skin | None:
    """The skin of a car's whole mesh, or of the coarser level that begins at a distance, metres.

    None for a car of another mesh.
    """
    if shape.coefficients is None:
        return None
    assert len(topology().twins) == len(shape.vertices)
    share = vertex_openness() / 255.0
    share = share * np.sqrt(share)  # grey levels rise faster than light
    faces, parts = shape.faces, shape.parts
    if distance:
        level = coarse_levels()[distance]
        faces, parts = level.faces, parts[level.origins]
    a, b, c = shape.vertices[faces].swapaxes(0, 1)
    normals = smooth_neighbours(distance).smooth(np.cross(b - a, c - a))
    patterns = np.full(len(faces), int(Pattern.PLAIN))
    patterns[np.isin(parts, WHEEL_PARTS)] = Pattern.WHEEL
    patterns[parts == PLATE_PARTS] = Pattern.PLATE
    return Skin(normals, share[faces], patterns, marks_of(shape.vertices))


def marks_of(vertices: Float[Array, "v 3"]) -> Float[Array, "8"]:
    """Where a car's wheels and plates are; see `Skin.marks`."""
    hubs = [vertices[first + 3 * SPOKES] for first in WHEELS]
    beside = vertices[WHEELS[0] + SPOKES // 4]
    plates = [vertices[first : first + 8] for first in PLATES]
    middle = [0.5 * (plate[:, 1].min() + plate[:, 1].max()) for plate in plates]
    high, half = float(np.ptp(plates[0][:, 1])), float(np.abs(plates[0][:, 2]).max())
    along = abs(float(beside[0] - hubs[0][0]))
    return np.array([hubs[0][0], hubs[1][0], along, -hubs[0][1], *middle, half, high])


def openness_of(
    vertices: Float[Array, "v 3"], faces: Int[Array, "f 3"], size: Float[Array, "3"]
) -> Float[Array, " v"]:
    """How much of the light of sky and road each point of a car gets, 0 to 1, beside its own body.

    size: length, height, width of the car, metres; the road beneath it is dark.
    """
    a, b, c = vertices[faces].swapaxes(0, 1)
    across = np.cross(b - a, c - a)
    counts = (across[:, 1] < DOWNWARD * np.linalg.norm(across, axis=1)).astype(float)
    normals = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(normals, faces[:, corner], across * (counts + 1e-6)[:, None])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    number = np.arange(RAYS) + 0.5  # evenly over the half sphere, most where it counts most
    up, turn = np.sqrt(1.0 - number / RAYS), number * (np.pi * (3.0 - 5.0**0.5))
    level = np.sqrt(1.0 - up**2)
    found = np.empty(len(vertices))
    for vertex, normal in enumerate(normals):
        side = np.cross(normal, (1.0, 0.0, 0.0) if abs(normal[0]) < 0.8 else (0.0, 1.0, 0.0))
        side /= np.linalg.norm(side)
        other = np.cross(normal, side)
        rays = (
            level[:, None] * (np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * other)
            + up[:, None] * normal
        )
        start = vertices[vertex] + LIFT_METRES * normal
        free = ~_hit(start, rays, (a, b, c))
        road, dark = _road_light(start, rays, size)
        whole = np.where(rays[:, 1] > 0.0, ROAD_LIGHT, 1.0).sum()
        found[vertex] = (np.where(rays[:, 1] > 0.0, road * (1.0 - dark), 1.0) * free).sum() / whole
    return found


def _hit(
    start: Float[Array, "3"], rays: Float[Array, "r 3"], corners: tuple[Array, Array, Array]
) -> Bool[Array, " r"]:
    """Whether rays from a point meet any triangle (Moeller and Trumbore)."""
    a, b, c = corners
    one, two, apart = b - a, c - a, start - a
    cross = np.cross(rays[:, None], two[None])
    volume = (cross * one).sum(axis=2)
    safe = np.where(np.abs(volume) > 1e-12, volume, np.inf)
    u = (cross * apart).sum(axis=2) / safe
    turned = np.cross(apart, one)
    v = rays @ turned.T / safe
    far = (two * turned).sum(axis=1) / safe
    found: Bool[Array, " r"] = ((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (far > 1e-6)).any(axis=1)
    return found


def _road_light(
    start: Float[Array, "3"], rays: Float[Array, "r 3"], size: Float[Array, "3"]
) -> tuple[float, Float[Array, " r"]]:
    """The road's light, and how dark the car makes it where each ray that goes down meets it."""
    far = np.where(rays[:, 1] > 1e-6, -start[1] / np.where(rays[:, 1] > 1e-6, rays[:, 1], 1.0), 0.0)
    place = start[[0, 2]] + np.maximum(far, 0.0)[:, None] * rays[:, [0, 2]]
    out = np.abs(place) - 0.5 * size[[0, 2]]
    outside = np.hypot(*np.maximum(out, 0.0).T)
    inside = np.maximum(-out.max(axis=1), 0.0)
    dark = 0.5 * (1.0 - outside / np.hypot(outside, size[1]))
    return ROAD_LIGHT, dark + 0.5 * inside / np.hypot(inside, CLEARANCE_METRES)
