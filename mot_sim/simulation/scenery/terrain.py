"""How far from the road every place is, and lines at a distance along it."""

from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import cv2
import numpy as np
from jaxtyping import Float, Float32, Int32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.scenery.patches import Patches, fill_fixed, fixed_points
from mot_sim.simulation.traffic.roads import Roads

CELL_METRES = 0.5  # metres
MARGIN_METRES = 70.0  # metres around the roads
Lines = dict[float, list[tuple[Array, Array]]]


@dataclass(frozen=True, eq=False)
class Terrain:
    """A grid over the roads and what lies beside them; row = y, column = x, cells of half a
    metre."""

    low: Float[Array, "2"]
    """x, y in world of the first cell's outer corner, metres."""
    distance: Float32[Array, "h w"]
    """Metres to the nearest asphalt."""
    paved: UInt8[Array, "h w"]
    """255 on pavements, kerbs and asphalt, else 0."""
    taken: UInt8[Array, "h w"]
    """255 where something stands already, else 0; the only thing here that changes."""
    known_lines: Lines = field(default_factory=dict)
    """What `lines` gave before, by distance."""

    @classmethod
    def of(cls, roads: Roads) -> "Terrain":
        """The terrain of roads, on which nothing stands; what follows from the roads is kept."""
        surveyed = _survey(roads)
        return replace(surveyed, taken=np.zeros_like(surveyed.paved))

    @classmethod
    def survey(cls, roads: Roads) -> "Terrain":
        """The terrain of roads, made anew."""
        corners = [surface.corners for surface in roads.surfaces] or [np.zeros((1, 2))]
        points = np.concatenate(corners)
        low = np.floor(points.min(axis=0) - MARGIN_METRES)
        size = np.ceil((points.max(axis=0) + MARGIN_METRES - low) / CELL_METRES).astype(int)
        driven = np.zeros((size[1], size[0]), np.uint8)
        paved = driven.copy()
        for image, kinds in (
            (driven, ("asphalt", "line")),
            (paved, ("pavement", "kerb", "asphalt")),
        ):
            chosen = tuple(s.corners for s in roads.surfaces if s.paint in kinds)
            Patches(chosen, ((255,),) * len(chosen)).fill(image, low, CELL_METRES)
        free = np.where(driven > 0, 0, 255).astype(np.uint8)
        distance = cv2.distanceTransform(free, cv2.DIST_L2, 5) * np.float32(CELL_METRES)
        if not driven.any():
            distance = np.full(driven.shape, MARGIN_METRES, np.float32)
        return cls(low, distance, paved, np.zeros_like(driven))

    def cells(self, points: Float[Array, "n 2"]) -> tuple[Array, Array]:
        """Rows and columns of the cells of points; the nearest ones for points outside."""
        index = np.floor((points - self.low) / CELL_METRES).astype(int)
        height, width = self.distance.shape
        return index[:, 1].clip(0, height - 1), index[:, 0].clip(0, width - 1)

    def settle(
        self,
        outlines: Float[Array, "n k 2"],
        distance: float,
        spare: float = 0.0,
        takes: bool = True,
    ) -> list[int]:
        """Rows of the convex outlines that find room, in turn; each that does takes its own.

        An outline finds room that keeps off everything and that far from the asphalt, metres, also
        when it is grown by `spare` metres. takes: or stands there without taking room.
        """
        if not len(outlines):
            return []
        low, high = outlines.min(axis=1), outlines.max(axis=1)
        inside = ((low > self.low + 1.0) & (high < self._high - 1.0)).all(axis=1)
        grown = self._sites(outlines, spare)
        own = self._sites(outlines, 0.0) if spare > 0.0 else grown
        settled, least = [], float(np.float32(distance))  # as exact as the grid
        for row in np.flatnonzero(inside).tolist():
            mask, window = filled(*grown[row])
            # (The function finds nothing, and says 0, under an empty mask.)
            if not mask.any() or cv2.minMaxLoc(self.distance[window], mask)[0] < least:
                continue
            if cv2.bitwise_and(self.taken[window], mask).any():
                continue
            if takes:
                mask, window = filled(*own[row]) if spare > 0.0 else (mask, window)
                self.taken[window] |= mask
            settled.append(row)
        return settled

    @cached_property
    def _high(self) -> Float[Array, "2"]:
        return self.low + CELL_METRES * np.array(self.distance.shape[::-1])

    def _sites(
        self, outlines: Float[Array, "n k 2"], spare: float
    ) -> list[tuple[list[int], Int32[Array, "k 2"]]]:
        """For each outline, grown by `spare` metres, the first and last column and row of a window
        of the grid that holds it, and its corners in there; see `fill_fixed`."""
        if spare > 0.0:
            middle = outlines.sum(axis=1, keepdims=True) / outlines.shape[1]
            away = outlines - middle
            reach = np.maximum(np.hypot(away[..., 0], away[..., 1]), 1e-6)[..., None]
            outlines = middle + away * (1.0 + spare / reach)
        index = np.floor((outlines - self.low) / CELL_METRES)
        low = np.maximum(index.min(axis=1), 0.0)
        high = np.minimum(index.max(axis=1), self.distance.shape[::-1] - np.ones(2))
        corner = self.low + CELL_METRES * low
        fixed = fixed_points((outlines - corner[:, None]) / CELL_METRES - 0.5)
        windows = np.concatenate((low, high), axis=1).astype(int).tolist()
        return list(zip(windows, fixed, strict=True))

    def lines(self, distance: float) -> list[tuple[Float[Array, "n 2"], Float[Array, "n 2"]]]:
        """Points a metre apart, so far from the asphalt, and the directions away from it."""
        if distance not in self.known_lines:
            self.known_lines[distance] = self._lines(distance)
        return self.known_lines[distance]

    def _lines(self, distance: float) -> list[tuple[Float[Array, "n 2"], Float[Array, "n 2"]]]:
        near = (self.distance <= distance).astype(np.uint8)
        outlines, _ = cv2.findContours(near, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        found = []
        for outline in sorted(outlines, key=lambda one: tuple(one[:, 0].min(axis=0).tolist())):
            cells = outline[:, 0].astype(float)
            steps = np.hypot(*np.diff(cells, axis=0, append=cells[:1]).T) * CELL_METRES
            along = np.concatenate(([0.0], np.cumsum(steps)))
            if along[-1] < 8.0:
                continue
            smooth = _smoothed(cells)
            at = np.arange(0.0, along[-1] - 0.5)
            points = np.stack(
                [np.interp(at, along[:-1], smooth[:, axis]) for axis in (0, 1)], axis=1
            )
            points = self.low + CELL_METRES * (points + 0.5)
            found.append((points, self.away(points)))
        return found

    def away(self, points: Float[Array, "n 2"]) -> Float[Array, "n 2"]:
        """The unit directions away from the nearest asphalt."""
        rows, columns = self.cells(points)
        across, along = self._slopes
        out = np.stack((across[rows, columns], along[rows, columns]), axis=1).astype(float)
        length = np.hypot(*out.T)[:, None]
        return np.where(length > 1e-6, out / np.maximum(length, 1e-6), (1.0, 0.0))

    @cached_property
    def _slopes(self) -> tuple[Float32[Array, "h w"], Float32[Array, "h w"]]:
        """How the distance grows along x and y, evened out over two metres."""
        even = cv2.blur(self.distance, (5, 5))
        return cv2.Sobel(even, cv2.CV_32F, 1, 0), cv2.Sobel(even, cv2.CV_32F, 0, 1)


_survey = lru_cache(maxsize=4)(Terrain.survey)


def filled(
    window: list[int], corners: Int32[Array, "k 2"]
) -> tuple[UInt8[Array, "a b"], tuple[slice, slice]]:
    """The cells that an outline covers in a window of the grid, 255 or 0, and the window."""
    left, top, right, bottom = window
    mask = np.zeros((bottom + 1 - top, right + 1 - left), np.uint8)
    fill_fixed(mask, corners)
    return mask, (slice(top, bottom + 1), slice(left, right + 1))


def _smoothed(cells: Float[Array, "n 2"]) -> Float[Array, "n 2"]:
    """A closed line of cells without its stairs."""
    reach = 4
    kernel = np.ones(2 * reach + 1) / (2 * reach + 1)
    wide = np.concatenate((cells[-reach:], cells, cells[:reach]))
    return np.stack([np.convolve(wide[:, axis], kernel, "valid") for axis in (0, 1)], axis=1)
