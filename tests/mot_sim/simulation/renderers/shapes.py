"""Simple closed meshes, places for them, and a camera that hides no mistake."""

from functools import cache

import numpy as np

from mot_sim.simulation.renderers import Mesh, MeshInstances, Semantic, View
from mot_sim.simulation.rig import Rig
from tracker.geometry import homogeneous, rotation_y
from tracker.types import Camera

KITTI = Rig.kitti().camera
# Off-centre principal point, fx != fy, a tilted camera: whatever could be mixed up differs.
CROOKED = Camera.mounted(
    np.array([[90.0, 0.0, 40.0], [0.0, 130.0, 71.0], [0.0, 0.0, 1.0]]), (123, 97), 1.4, -0.05, 0.06
)
PAINTS = ((196, 201, 206), (238, 238, 234), (150, 44, 44), (46, 74, 118), (112, 138, 164))
QUADS = [(0, 1, 2, 3), (7, 6, 5, 4), (4, 5, 1, 0), (6, 7, 3, 2), (5, 6, 2, 1), (7, 4, 0, 3)]


def painted(vertices, faces, colour=(150, 60, 40), semantic=Semantic.CAR) -> Mesh:
    """A mesh of one colour, its faces turned outwards (for shapes around their middle)."""
    vertices, faces = np.asarray(vertices, float), np.array(faces, np.int64)
    a, b, c = vertices[faces].swapaxes(0, 1)
    outwards = (np.cross(b - a, c - a) * ((a + b + c) / 3 - vertices.mean(axis=0))).sum(axis=1)
    faces[outwards < 0] = faces[outwards < 0][:, ::-1]
    colours = np.tile(np.array(colour, np.uint8), (len(faces), 1))
    return Mesh(vertices, faces, colours, np.full(len(faces), semantic, np.uint8))


def hexahedron(low, high, colour=(150, 60, 40)) -> Mesh:
    """Eight corners: four of the bottom, four of the roof, (x, z) each; a box, or a wedge."""
    (bottom, height), (roof, top) = low, high
    vertices = [(x, height, z) for x, z in bottom] + [(x, top, z) for x, z in roof]
    faces = [(q[i], q[j], q[k]) for q in QUADS for i, j, k in ((0, 1, 2), (0, 2, 3))]
    return painted(vertices, faces, colour)


def box(length=4.0, height=1.5, width=1.8, colour=(150, 60, 40)) -> Mesh:
    """A box that stands on the road."""
    half = [(sx * length / 2, sz * width / 2) for sx, sz in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    return hexahedron((half, 0.0), (half, -height), colour)


def wedge(colour=(60, 120, 70)) -> Mesh:
    """A box whose roof is short and lies behind."""
    bottom = [(2.0, 0.9), (-2.0, 0.9), (-2.0, -0.9), (2.0, -0.9)]
    roof = [(0.2, 0.7), (-1.8, 0.7), (-1.8, -0.7), (0.2, -0.7)]
    return hexahedron((bottom, 0.0), (roof, -1.5), colour)


@cache
def lump(colour=(120, 130, 150), rings=16, around=33) -> Mesh:
    """A smooth body of 990 faces, about as large as a car: dark windows, tyres below."""
    polar = np.linspace(0.0, np.pi, rings + 1)[:, None]
    turn = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)[None]

    def full(values):
        return np.sign(values) * np.abs(values) ** 0.45

    up = full(np.cos(polar)) * np.ones_like(turn)
    narrower = np.where(up > 0.1, 1.0 - 0.35 * up, 1.0)
    x = 2.0 * full(np.sin(polar) * np.cos(turn)) * narrower - 0.2 * np.maximum(up, 0.0)
    z = 0.85 * full(np.sin(polar) * np.sin(turn)) * np.where(up > 0.1, 1.0 - 0.2 * up, 1.0)
    vertices = np.stack((x, -0.75 - 0.75 * up, z), axis=-1).reshape(-1, 3)
    faces = []
    for ring in range(rings):
        for step in range(around):
            a, b = ring * around + step, ring * around + (step + 1) % around
            faces += [(a, b, a + around)] if ring else []
            faces += [(b, b + around, a + around)] if ring < rings - 1 else []
    mesh = painted(vertices, faces, colour)
    height = -0.5 * (mesh.corners[..., 1].min(axis=1) + mesh.corners[..., 1].max(axis=1))
    glass, tyre = (height > 0.95) & (height < 1.42), height < 0.12
    colours, semantics = mesh.colours.copy(), mesh.semantics.copy()
    colours[glass], semantics[glass] = (44, 54, 64), Semantic.GLASS
    colours[tyre], semantics[tyre] = (26, 26, 28), Semantic.TYRE
    return Mesh(mesh.vertices, mesh.faces, colours, semantics)


def at(camera: Camera, x: float, z: float, yaw: float = 0.5, y: float = 0.0) -> np.ndarray:
    """T_cam_object of an object at a point of the road frame."""
    return camera.T_cam_road @ homogeneous(rotation_y(yaw), np.array([x, y, z]))


def view_of(camera: Camera, *objects, **rest) -> View:
    """A view of (mesh, T_cam_object) pairs; their ids are 0, 1, ..."""
    meshes = tuple(mesh for mesh, _ in objects)
    places = np.array([place for _, place in objects]).reshape(-1, 4, 4)
    return View(camera, MeshInstances(meshes, places, np.arange(len(meshes))), **rest)


def street(camera: Camera = KITTI, cars: int = 20, seed: int = 0) -> View:
    """Cars of 990 faces in four lanes, from 7 m to 60 m before the camera."""
    rng = np.random.default_rng(seed)
    lanes, yaws = (-5.4, -1.8, 1.8, 5.4), (np.pi / 2, np.pi / 2, -np.pi / 2, -np.pi / 2)
    objects = []
    for car in range(cars):
        lane = (car + 2) % 4
        z = 8.0 + 10.5 * (car // 4) + (3.0, 9.0, 7.0, 1.0)[lane] + rng.uniform(-1.0, 1.0)
        x, yaw = lanes[lane] + rng.uniform(-0.3, 0.3), yaws[lane] + rng.uniform(-0.05, 0.05)
        objects.append((lump(PAINTS[car % len(PAINTS)]), at(camera, x, z, yaw)))
    return view_of(camera, *objects)
