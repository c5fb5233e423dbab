"""The things beside the roads in pieces that are drawn together, and the shadows they cast."""

from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Literal

import cv2
import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.simulation.renderers import NO_INSTANCE, Mesh, MeshInstances
from mot_sim.simulation.renderers.triangles import NEAR_METRES, sphere_in_view
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scenery.culling import (
    HOUSE_OVERHANG_METRES,
    Spheres,
    boxes_of_things,
    may_be_seen,
)
from mot_sim.simulation.scenery.patches import Patches
from mot_sim.simulation.scenery.placing import Item, Knobs, place
from mot_sim.simulation.scenery.props import DETAIL_LEVELS
from mot_sim.simulation.scenery.solids import join
from mot_sim.simulation.scenery.terrain import Terrain
from mot_sim.simulation.traffic.roads import Roads
from tracker.errors import BadConfig
from tracker.geometry import homogeneous, invert
from tracker.types import Camera

PIECE_METRES = 30.0  # metres: what stands in one square of this size is one mesh
MAX_DISTANCE_METRES = 180.0  # metres; what is farther is not drawn
DETAIL_METRES = (30.0, 75.0)  # metres: from there on pieces are drawn with less detail
MAX_MESHES = 160  # meshes: 60 MB at most
CASTING_KINDS = ("house", "hedge", "wall", "lamp", "sign")  # beside what has leaves
# What hides some sky from the ground around it, and how far compared with a house.
CLOSING_KINDS = {"house": 1.0, "hedge": 0.5, "wall": 0.5, "bush": 0.4, "tree": 0.25}
# How far out from what stands there, metres, and how much of the light is lost, 255 = all.
FEET_LAYERS = ((1.4, 26), (0.7, 64), (0.25, 104))
CROWN_SHADE = 0.8  # of the sun that a crown keeps from the cars beneath it
CROWN_METRES = 4.0  # metres that trees reach out beyond their feet
R_world_piece = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


Part = Literal["piece", "low things", "house"]  # what is one mesh


@dataclass(frozen=True, eq=False)
class Scenery:
    """Pieces on the ground of the world, each around its own origin; meshes are made when
    needed."""

    pieces: tuple[tuple[Item, ...], ...]
    """The things of each piece: those whose bases lie in one square of 30 m."""
    origins: Float[Array, "n 2"]
    """x, y in world of each piece's origin, metres."""
    radii: Float[Array, " n"]
    """How far each piece reaches from its origin, metres."""
    made: dict[tuple[Part, int, int], Mesh] = field(default_factory=dict)
    """Meshes made so far, by what of the scenery, its number and level of detail; the oldest are
    dropped."""

    @classmethod
    def around(cls, roads: Roads, seed: int, knobs: Knobs | None = None) -> "Scenery":
        """What stands beside roads; nothing of the ground is painted for it.

        The same roads, seed and knobs give the same one again as long as it is remembered.
        """
        return _around(roads, seed, knobs or Knobs())

    @property
    def items(self) -> tuple[Item, ...]:
        """All things, square by square."""
        return tuple(item for piece in self.pieces for item in piece)

    @classmethod
    def of(cls, items: list[Item]) -> "Scenery":
        """All items, put together by squares."""
        squares: dict[tuple[int, int], list[Item]] = {}
        middles = np.array([item.base.mean(axis=0) for item in items]).reshape(-1, 2)
        places = np.floor(middles / PIECE_METRES).astype(int).tolist()
        for item, (column, row) in zip(items, places, strict=True):
            squares.setdefault((column, row), []).append(item)
        origins = (np.array(sorted(squares)).reshape(-1, 2) + 0.5) * PIECE_METRES
        pieces = tuple(tuple(squares[square]) for square in sorted(squares))
        reach = [
            float(np.hypot(*(np.concatenate([item.base for item in piece]) - origin).T).max())
            for piece, origin in zip(pieces, origins, strict=True)
        ]
        return cls(pieces, origins, np.array(reach).reshape(-1) + CROWN_METRES)

    def mesh(self, row: int, detail: int) -> Mesh:
        """The mesh of a piece."""
        return self._mesh("piece", row, detail)

    def _mesh(self, part: Part, number: int, detail: int) -> Mesh:
        """The mesh of a piece, of all but houses in it, or of a house by its row in `houses`."""
        key = (part, number, detail)
        if key not in self.made:
            if len(self.made) >= MAX_MESHES:
                self.made.pop(next(iter(self.made)))
            row = self.house_pieces[number] if part == "house" else number
            items = self.pieces[row] if part == "piece" else self._low_things[row]
            chosen = (self.houses[number],) if part == "house" else items
            self.made[key] = join([item.make(detail) for item in chosen]).mesh(self.origins[row])
        return self.made[key]

    @cached_property
    def _low_things(self) -> list[list[Item]]:
        return [[item for item in piece if item.kind != "house"] for piece in self.pieces]

    @cached_property
    def houses(self) -> tuple[Item, ...]:
        """The houses, piece by piece."""
        return tuple(item for item in self.items if item.kind == "house")

    @cached_property
    def house_pieces(self) -> Int[Array, " h"]:
        """The piece of each house."""
        counts = [sum(item.kind == "house" for item in piece) for piece in self.pieces]
        return np.repeat(np.arange(len(self.pieces)), counts)

    @cached_property
    def house_boxes(self) -> Float[Array, "h 8 3"]:
        """Corners in world of a box around each house."""
        return boxes_of_things([(house,) for house in self.houses], HOUSE_OVERHANG_METRES)

    @cached_property
    def boxes(self) -> Float[Array, "n 8 3"]:
        """Corners in world of a box around each piece."""
        return boxes_of_things(self.pieces)

    def seen_from(
        self,
        ego: Float[Array, "3"],
        camera: Camera,
        near: float = NEAR_METRES,
        behind: Spheres | None = None,
    ) -> MeshInstances:
        """What of it the camera of an ego pose (x, y, heading) may see; all ids: NO_INSTANCE.

        behind: only what may hide one of these. Houses stand far from the road, hide few cars, and
        take long to make: then each is judged by itself.
        """
        T_cam_world = invert(Rig(camera).T_world_cam(checked(ego)))
        apart = self.origins - ego[:2]
        ahead = apart @ np.array([np.cos(ego[2]), np.sin(ego[2])])
        close = (np.hypot(*apart.T) - self.radii < MAX_DISTANCE_METRES) & (
            ahead + self.radii > near
        )
        rows = np.flatnonzero(close)
        rows = rows[may_be_seen(self.boxes[rows], T_cam_world, camera, near, behind)]
        rows = rows[np.argsort(ahead[rows], kind="stable")]  # near first: less is drawn over
        if not len(rows):
            return MeshInstances.empty()
        parts: list[tuple[Part, int]]
        if behind is None:
            parts = [("piece", row) for row in rows.tolist()]
        else:
            alone = np.flatnonzero(np.isin(self.house_pieces, rows))
            boxes = self.house_boxes[alone]
            alone = alone[may_be_seen(boxes, T_cam_world, camera, near, behind)]
            parts = [("low things", row) for row in rows.tolist()]
            parts += [("house", number) for number in alone.tolist()]
            rows = np.concatenate((rows, self.house_pieces[alone]))
        T_world_piece = np.tile(homogeneous(R_world_piece, np.zeros(3)), (len(rows), 1, 1))
        T_world_piece[:, :2, 3] = self.origins[rows]
        far = np.hypot(*apart[rows].T) - 0.5 * PIECE_METRES
        details = np.searchsorted(DETAIL_METRES, far).tolist()
        meshes = [self._mesh(*part, detail) for part, detail in zip(parts, details, strict=True)]
        instances = MeshInstances(
            tuple(meshes), T_cam_world @ T_world_piece, np.full(len(rows), NO_INSTANCE)
        )
        seen = np.flatnonzero(sphere_in_view(instances, camera, near))
        return MeshInstances(
            tuple(meshes[row] for row in seen), instances.T_cam_object[seen], instances.ids[seen]
        )


@lru_cache(maxsize=4)
def _around(roads: Roads, seed: int, knobs: Knobs) -> Scenery:
    return Scenery.of(place(Terrain.of(roads), seed, knobs, roads.plots))


def checked(ego: Float[Array, "3"]) -> Float[Array, "3"]:
    """The ego pose, if it is finite."""
    if not np.isfinite(ego).all():
        raise BadConfig(f"the ego pose (x, y, heading) is not finite: {ego.tolist()}")
    return ego


def shadows_of(
    items: tuple[Item, ...], towards: Float[Array, "3"], shade: float
) -> tuple[Patches, Patches, Patches]:
    """Where the sun's light does not reach the ground, by solid things, by leaves, and by crowns.

    towards: to the sun, z down. shade: how much of the light is taken, 0 to 1; a crown lets some
    of it through, a leaf none.
    """
    solid: list[Float[Array, "_ 2"]] = []
    leaves: list[Float[Array, "_ 2"]] = []
    crowns: list[Float[Array, "_ 2"]] = []
    if shade > 0.0:
        slope = towards[:2] / towards[2]  # metres aside for each of height, away from the sun
        for item in items:
            if item.leafy:
                corners = item.make(1).corners @ _fall(slope)
                leaves += list(corners)
                crowns.append(_hull(corners.reshape(-1, 2)))
            elif item.kind in CASTING_KINDS:
                corners = item.make(DETAIL_LEVELS - 1).corners.reshape(-1, 3) @ _fall(slope)
                solid.append(_hull(corners))
    whole, part = ((round(255.0 * each),) for each in (shade, CROWN_SHADE * shade))
    return tuple(  # type: ignore[return-value]  # three of them
        Patches(tuple(corners), (value,) * len(corners))
        for corners, value in ((solid, whole), (leaves, whole), (crowns, part))
    )


def _hull(points: Float[Array, "n 2"]) -> Float[Array, "k 2"]:
    return cv2.convexHull(points.astype(np.float32))[:, 0].astype(np.float64)


def feet_of(items: tuple[Item, ...]) -> Patches:
    """The ground around things that stand on it, darker towards them: they hide some sky."""
    outlines, values = [], []
    standing = [item for item in items if item.kind in CLOSING_KINDS]
    for reach, dark in FEET_LAYERS:
        for item in standing:
            middle = item.base.mean(axis=0)
            away = item.base - middle
            length = np.maximum(np.hypot(*away.T), 1e-6)[:, None]
            outlines.append(middle + away * (1.0 + reach * CLOSING_KINDS[item.kind] / length))
            values.append((dark,))
    return Patches(tuple(outlines), tuple(values))


def _fall(slope: Float[Array, "2"]) -> Float[Array, "3 2"]:
    """From x, y, height to where the light through that point meets the ground."""
    return np.array([[1.0, 0.0], [0.0, 1.0], [slope[0], slope[1]]])
