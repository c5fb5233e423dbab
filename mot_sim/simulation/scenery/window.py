"""Windows on the ground around the camera, one a level of detail; tiles are painted once."""

from collections import OrderedDict
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers.surroundings import Colour, Cover, Level, Road, Texture
from mot_sim.simulation.renderers.triangles import clip_polygon
from mot_sim.simulation.scenery.ground import (
    COVER_TEXEL_METRES,
    GRASS_COLOUR,
    LEVEL_COUNT,
    TEXEL_METRES,
    TILE_TEXELS,
    Ground,
)
from tracker.kernels import Kernel
from tracker.types import Camera

MARK_TILES = Kernel("mot_sim.simulation.kernels.backdrop", "mark_tiles")

WINDOW_TILES = 6  # tiles along a window's sides: 38.4 m on the finest level, 614 m on the coarsest
STEP_TILES = 2  # by which windows move, but for the coarsest one, which reaches as far as is drawn
# Metres ahead that the finest level is painted for, each coarser one twice as far: from there on
# KITTI's camera finds the next one sharp enough. And how far the coarsest one is painted.
FINEST_REACH_METRES = 12.5
MAX_REACH_METRES = 450.0
AHEAD_SHARE = 0.3  # of a window's side, from the camera to its middle
COVER_TILES = 3  # along the sides of the picture of shadows on cars: 192 m
MAX_COVERS = 48  # tiles of that picture, of 66 kB each
MAX_TILES = 320  # tiles, of 0.26 MB each: 84 MB
AROUND_COLOUR: Colour = (95, 105, 62)
MEADOW_RGBA = np.array((*GRASS_COLOUR, 0), np.uint8).view(np.uint32)[0]


@dataclass(eq=False)
class SceneryWindow:
    """The tiles of one level around a place; those in sight are filled."""

    origin: tuple[int, int]
    """Column and row of its first tile, counted in tiles from the world's origin."""
    pixels: UInt8[Array, "s s 4"]
    """RGBA picture of all its tiles; row = y, column = x; alpha is 255 on what cars drive on."""
    filled: Bool[Array, "a a"]
    """Which tiles are painted; the others show a meadow. Row = y, column = x."""

    @classmethod
    def at(cls, origin: tuple[int, int], before: "SceneryWindow | None" = None) -> "SceneryWindow":
        """A new one with the tiles that another one has already.

        origin: column and row of its first tile.
        """
        window = cls(
            origin,
            np.empty((WINDOW_TILES * TILE_TEXELS, WINDOW_TILES * TILE_TEXELS, 4), np.uint8),
            np.zeros((WINDOW_TILES, WINDOW_TILES), bool),
        )
        u, v = (0, 0) if before is None else np.subtract(origin, before.origin).tolist()
        if before is None or max(abs(u), abs(v)) >= WINDOW_TILES:
            window.clear(slice(None), slice(None))
            return window
        rows, columns = _overlap(v), _overlap(u)
        window.filled[rows[0], columns[0]] = before.filled[rows[1], columns[1]]
        (to_rows, of_rows), (to_columns, of_columns) = (
            map(_texels, one) for one in (rows, columns)
        )
        window.pixels[to_rows, to_columns] = before.pixels[of_rows, of_columns]
        window.clear(_texels(_beside(v)), slice(None))
        window.clear(to_rows, _texels(_beside(u)))
        return window

    def clear(self, rows: slice, columns: slice) -> None:
        """Show a meadow there."""
        self.pixels.view(np.uint32)[rows, columns] = MEADOW_RGBA


def _overlap(shift: int) -> tuple[slice, slice]:
    """The tiles that two windows share, along one axis: in the new one, and in the old one."""
    count = WINDOW_TILES - abs(shift)
    new, old = max(-shift, 0), max(shift, 0)
    return slice(new, new + count), slice(old, old + count)


def _beside(shift: int) -> slice:
    """The tiles of a new window that the old one has not."""
    return slice(WINDOW_TILES - shift, WINDOW_TILES) if shift >= 0 else slice(0, -shift)


def _texels(tiles: slice) -> slice:
    return slice(tiles.start * TILE_TEXELS, tiles.stop * TILE_TEXELS)


@dataclass(eq=False)
class Windows:
    """The road around a moving camera. What it shows depends on the place alone, not on the way."""

    ground: Ground
    """What tiles are painted from."""
    tiles: OrderedDict[tuple[int, int, int], UInt8[Array, "t t 4"]] = field(
        default_factory=OrderedDict
    )
    """The tiles painted last, by level, column and row; at most 320."""
    now: dict[int, SceneryWindow] = field(default_factory=dict)
    """The window around the camera, by level of detail."""
    covers: OrderedDict[tuple[int, int], UInt8[Array, "t t"]] = field(default_factory=OrderedDict)
    """The tiles of the picture of shadows made last, by column and row; at most 48."""
    joined: dict[tuple[int, int], UInt8[Array, "s s"]] = field(default_factory=dict)
    """The picture of shadows around the camera, by the column and row of its first tile."""

    def road(
        self, ego: Float[Array, "3"], T_world_road: Float[Array, "4 4"], camera: Camera
    ) -> Road:
        """The road plane as it is painted around an ego pose."""
        levels = [self._level(number, ego, T_world_road, camera) for number in range(LEVEL_COUNT)]
        coarsest = levels[-1]
        return Road(coarsest.texture, coarsest.A_texture_road, AROUND_COLOUR, tuple(levels[:-1]))

    def cover(self, ego: Float[Array, "3"], T_world_road: Float[Array, "4 4"]) -> Cover:
        """The static shadows around an ego pose, for the cars in them."""
        side = TILE_TEXELS * COVER_TEXEL_METRES
        ahead = np.array([np.cos(ego[2]), np.sin(ego[2])])
        middle = ego[:2] + AHEAD_SHARE * COVER_TILES * side * ahead
        column, row = np.floor(middle / side - 0.5 * COVER_TILES + 0.5).astype(int).tolist()
        if (column, row) not in self.joined:
            span = range(COVER_TILES)
            tiles = [[self._cover_tile(column + u, row + v) for u in span] for v in span]
            self.joined.clear()
            self.joined[column, row] = np.block(tiles)
        texel = COVER_TEXEL_METRES
        A_cover_world = np.array(
            [
                [1.0 / texel, 0.0, -column * TILE_TEXELS - 0.5],
                [0.0, 1.0 / texel, -row * TILE_TEXELS - 0.5],
                [0.0, 0.0, 1.0],
            ]
        )
        A_world_road = T_world_road[np.ix_((0, 1, 3), (0, 2, 3))]
        return Cover(self.joined[column, row], A_cover_world @ A_world_road)

    def _cover_tile(self, column: int, row: int) -> UInt8[Array, "t t"]:
        """A tile of the picture of shadows, from the store where it is there."""
        key = (column, row)
        if key in self.covers:
            self.covers.move_to_end(key)
            return self.covers[key]
        tile = self.covers[key] = self.ground.cover_tile(column, row)
        if len(self.covers) > MAX_COVERS:
            self.covers.popitem(last=False)
        return tile

    def _level(
        self, number: int, ego: Float[Array, "3"], T_world_road: Float[Array, "4 4"], camera: Camera
    ) -> Level:
        texel = TEXEL_METRES * 2**number
        side = TILE_TEXELS * texel
        ahead = np.array([np.cos(ego[2]), np.sin(ego[2])])
        middle = ego[:2] + AHEAD_SHARE * WINDOW_TILES * side * ahead
        is_last = number == LEVEL_COUNT - 1
        step = 1 if is_last else STEP_TILES
        first = (middle / side - 0.5 * WINDOW_TILES) / step
        column, row = (step * np.floor(first + 0.5).astype(int)).tolist()
        window = self.now.get(number)
        if window is None or window.origin != (column, row):
            window = self.now[number] = SceneryWindow.at((column, row), window)
        reach = np.inf if is_last else FINEST_REACH_METRES * 2.0**number
        seen = footprint(camera, MAX_REACH_METRES if is_last else reach + 1.0)
        needed = _needed(seen, (column, row), side, T_world_road)
        for v, u in np.argwhere(needed & ~window.filled).tolist():
            tile = self._tile(number, column + u, row + v)
            window.pixels[
                v * TILE_TEXELS : (v + 1) * TILE_TEXELS, u * TILE_TEXELS : (u + 1) * TILE_TEXELS
            ] = tile
        window.filled |= needed
        A_texture_world = np.array(
            [
                [1.0 / texel, 0.0, -column * TILE_TEXELS - 0.5],
                [0.0, 1.0 / texel, -row * TILE_TEXELS - 0.5],
                [0.0, 0.0, 1.0],
            ]
        )
        A_world_road = T_world_road[np.ix_((0, 1, 3), (0, 2, 3))]
        return Level(Texture.of_rgba(window.pixels), A_texture_world @ A_world_road, reach)

    def _tile(self, number: int, column: int, row: int) -> UInt8[Array, "t t 4"]:
        """A tile, from the store where it is there."""
        key = (number, column, row)
        if key in self.tiles:
            self.tiles.move_to_end(key)
            return self.tiles[key]
        tile = self.tiles[key] = self.ground.tile(number, column, row)
        if len(self.tiles) > MAX_TILES:
            self.tiles.popitem(last=False)
        return tile


def _needed(
    seen: Float[Array, "n 2"],
    origin: tuple[int, int],
    side: float,
    T_world_road: Float[Array, "4 4"],
) -> Bool[Array, "a a"]:
    """Which tiles of a window lie in what the camera sees of the road."""
    if len(seen) < 3:
        return np.zeros((WINDOW_TILES, WINDOW_TILES), bool)
    outline = seen @ T_world_road[:2, [0, 2]].T + T_world_road[:2, 3]
    outline = outline / side - origin
    touched = np.empty(WINDOW_TILES * WINDOW_TILES, bool)
    MARK_TILES(outline, WINDOW_TILES, touched)
    return touched.reshape(WINDOW_TILES, WINDOW_TILES)


@lru_cache(maxsize=32)
def footprint(camera: Camera, reach: float) -> Float[Array, "n 2"]:
    """The convex part of the road, (x, z), that a camera sees up to a depth; a little more."""
    width, height = camera.image_size
    edges = np.array([(-2, -2), (width + 1, -2), (width + 1, height + 1), (-2, height + 1)], float)
    rays = camera.rays_road(edges)
    below = clip_polygon(rays, rays[:, 1], camera.height / (3.0 * reach))
    if len(below) < 3:
        return np.zeros((0, 2))
    points = below[:, [0, 2]] * (camera.height / below[:, 1:2])
    axis = camera.T_cam_road[2]
    depth = points[:, 0] * axis[0] + points[:, 1] * axis[2] + axis[3]
    return clip_polygon(points, reach - depth)
