"""The shared mesh with fewer faces, for cars far away: half-edge collapses by quadric error.

Garland and Heckbert, Surface simplification using quadric error metrics, SIGGRAPH 1997, with two
departures: a vertex is moved onto a neighbour, so that every car of the fleet can use the same
coarser faces over its own vertices, and the error is summed over the mean car of every body.
"""

from dataclasses import dataclass
from functools import cache
from heapq import heapify, heappop, heappush
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

SHIPPED_COARSE = Path(__file__).with_name("coarse.npz")
# Faces of each level, and from what distance in metres on it stands in for the whole mesh: from
# there on no edge of its box is off by a pixel of KITTI's camera (a test).
LEVEL_DISTANCES: dict[int, float] = {640: 25.0, 320: 60.0}
EDGE_WEIGHT = 4.0  # how much more a border between two materials weighs than a face
MIN_TURN_COSINE = 0.2  # cosine: no face may turn further when a vertex moves


@dataclass(frozen=True, eq=False)
class Coarse:
    """A coarser mesh over the same vertices."""

    faces: Int[Array, "c 3"]
    """Rows of the vertices."""
    origins: Int[Array, " c"]
    """For each face the row of the whole mesh's face that it was."""


@cache
def coarse_levels() -> dict[float, Coarse]:
    """The shipped levels by the distance they begin at, near to far."""
    with np.load(SHIPPED_COARSE, allow_pickle=False) as file:
        return {
            distance: Coarse(file[f"faces{count}"], file[f"origins{count}"])
            for count, distance in LEVEL_DISTANCES.items()
        }


def simplify(
    shapes: Float[Array, "m v 3"],
    faces: Int[Array, "f 3"],
    materials: Int[Array, " f"],
    locked: Bool[Array, " v"],
    target: int,
) -> Coarse:
    """At most about `target` faces for all of some shapes with the same faces.

    locked: vertices that stay. Fewer collapses happen where no more are allowed.
    """
    mesh = _Mesh(shapes, faces, materials)
    heap = [(mesh.cost(i, j), i, j) for i in range(len(locked)) for j in mesh.near(i)]
    heap = [entry for entry in heap if not locked[entry[1]]]
    heapify(heap)
    left = len(faces)
    while heap and left > target:
        cost, i, j = heappop(heap)
        if i in mesh.gone or j in mesh.gone or cost < mesh.cost(i, j) - 1e-15:
            continue
        if mesh.may_collapse(i, j):
            left -= mesh.collapse(i, j)
            for k in mesh.near(j):
                for a, b in ((j, k), (k, j)):
                    if not locked[a]:
                        heappush(heap, (mesh.cost(a, b), a, b))
    origins = np.array(sorted(mesh.alive), dtype=np.int64)
    return Coarse(mesh.faces[origins], origins)


class _Mesh:
    """Faces that change, their neighbours, and the quadrics of the vertices."""

    def __init__(
        self, shapes: Float[Array, "m v 3"], faces: Int[Array, "f 3"], materials: Int[Array, " f"]
    ) -> None:
        self.shapes, self.faces = shapes, faces.copy()
        self.alive, self.gone = set(range(len(faces))), set[int]()
        self.around: list[set[int]] = [set() for _ in range(shapes.shape[1])]
        for face, corners in enumerate(faces.tolist()):
            for corner in corners:
                self.around[corner].add(face)
        self.quadrics = _quadrics(shapes, faces, materials)

    def near(self, i: int) -> set[int]:
        """The vertices next to one."""
        return {int(k) for face in self.around[i] for k in self.faces[face]} - {i}

    def cost(self, i: int, j: int) -> float:
        """What it costs to move i onto j: squared distances to the planes of both, times areas."""
        point = np.append(self.shapes[:, j], np.ones((len(self.shapes), 1)), axis=1)
        both = self.quadrics[:, i] + self.quadrics[:, j]
        return float(np.einsum("mi,mij,mj->", point, both, point))

    def may_collapse(self, i: int, j: int) -> bool:
        """Whether the surface stays closed, and no face turns over in any shape."""
        if len(self.near(i) & self.near(j)) != 2:
            return False
        moved = np.array([face for face in self.around[i] if face not in self.around[j]])
        if not len(moved):
            return False
        before = self.faces[moved]
        after = np.where(before == i, j, before)
        old, new = (_normals(self.shapes, corners) for corners in (before, after))
        sizes = np.linalg.norm(old, axis=2) * np.linalg.norm(new, axis=2)
        return bool(((old * new).sum(axis=2) > MIN_TURN_COSINE * sizes).all())

    def collapse(self, i: int, j: int) -> int:
        """Move i onto j; gives how many faces vanish."""
        vanish = self.around[i] & self.around[j]
        for face in vanish:
            for corner in self.faces[face].tolist():
                self.around[corner].discard(face)
            self.alive.discard(face)
        for face in self.around[i]:
            self.faces[face][self.faces[face] == i] = j
            self.around[j].add(face)
        self.around[i] = set()
        self.gone.add(i)
        self.quadrics[:, j] += self.quadrics[:, i]
        return len(vanish)


def _normals(shapes: Float[Array, "m v 3"], faces: Int[Array, "f 3"]) -> Float[Array, "m f 3"]:
    """Normals of faces, twice their areas long."""
    a, b, c = (shapes[:, faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def _quadrics(
    shapes: Float[Array, "m v 3"], faces: Int[Array, "f 3"], materials: Int[Array, " f"]
) -> Float[Array, "m v 4 4"]:
    """Of each vertex: the planes of its faces, and across the borders of materials, by area."""
    normals = _normals(shapes, faces)
    area = np.linalg.norm(normals, axis=2)
    unit = normals / np.maximum(area, 1e-12)[..., None]
    found = np.zeros((*shapes.shape[:2], 4, 4))

    def add(rows: Int[Array, " e"], normal: Array, point: Array, weight: Array) -> None:
        plane = np.append(normal, -(normal * point).sum(axis=2)[..., None], axis=2)
        each = weight[..., None, None] * plane[..., :, None] * plane[..., None, :]
        for shape in range(len(shapes)):
            np.add.at(found[shape], rows, each[shape])

    for k in range(3):
        add(faces[:, k], unit, shapes[:, faces[:, 0]], 0.5 * area)
    sides = {
        (int(face[k]), int(face[k - 2])): row for row, face in enumerate(faces) for k in range(3)
    }
    border = [
        (a, b, row)
        for (a, b), row in sides.items()
        if (b, a) in sides and materials[sides[b, a]] != materials[row]
    ]
    if border:
        a, b, row = np.array(border).T
        along = shapes[:, b] - shapes[:, a]
        across = np.cross(along, unit[:, row])
        length = np.linalg.norm(along, axis=2)
        across /= np.maximum(np.linalg.norm(across, axis=2), 1e-12)[..., None]
        for ends in (a, b):
            add(ends, across, shapes[:, a], EDGE_WEIGHT * length**2)
    return found
