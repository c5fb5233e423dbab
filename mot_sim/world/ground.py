"""The ground from above, tile by tile: every tile is a function of roads, seed and place."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float32, UInt8
from numpy import ndarray as Array

from mot_sim.traffic.roads import PAINTS, Roads
from mot_sim.world.grain import TEXEL, TILE, Grain, grain_of
from mot_sim.world.patches import Patches
from mot_sim.world.wear import damage_of, tracks_of

FINER = 2  # patches are filled on a grid so many times finer, then averaged: smooth edges
CHANNELS = {paint: channel for channel, paint in enumerate(("asphalt", "pavement", "kerb", "line"))}
assert set(CHANNELS) == set(PAINTS)
ASPHALT, PAVEMENT, KERB, LINE = (104, 104, 106), (158, 154, 147), (178, 176, 170), (228, 228, 222)
GRASS, DRY = np.array([86, 101, 56], np.float32), np.array([124, 116, 78], np.float32)
A_COLOUR = np.array((ASPHALT, PAVEMENT, KERB, LINE), np.float32).T  # from shares to RGB
A_GRASS = np.stack((GRASS, DRY - GRASS), axis=1)
SLAB = 0.5  # metres
CRACKED = 2  # cracks are drawn up to this level of detail: they are finer than coarser texels


@dataclass(frozen=True, eq=False)
class Ground:
    """What tiles are painted from.

    tracks, marks: how bright the asphalt is there. cracks: polylines. wear: of the paint, 0 to 1.
    shadows: of things that stand still, and how dark each.
    """

    surfaces: Patches
    tracks: Patches
    marks: Patches
    cracks: Patches
    shadows: Patches
    grain: Grain
    wear: float

    @classmethod
    def of(cls, roads: Roads, seed: int, wear: float, shadows: Patches) -> "Ground":
        """The ground of roads."""
        values = [tuple(255 * (np.arange(4) == CHANNELS[s.paint])) for s in roads.surfaces]
        surfaces = Patches(
            tuple(s.corners for s in roads.surfaces),
            tuple(tuple(int(one) for one in value) for value in values),
        )
        tracks = tracks_of(roads)
        marks, cracks = damage_of(roads, seed, wear)
        return cls(
            surfaces,
            Patches(tuple(t.corners for t in tracks), tuple((t.tone,) for t in tracks)),
            Patches(tuple(m.corners for m in marks), tuple((m.tone,) for m in marks)),
            Patches(tuple(c.points for c in cracks), ()),
            shadows,
            grain_of(seed),
            wear,
        )

    def tile(self, level: int, column: int, row: int) -> UInt8[Array, "t t 4"]:
        """A tile's picture; alpha is 255 on what cars drive on."""
        texel = TEXEL * 2**level
        low = TILE * texel * np.array([column, row], dtype=float)
        weights = self._weights(low, texel)
        share = [one.astype(np.float32) * np.float32(1.0 / 255.0) for one in cv2.split(weights)]
        slow = self.grain.slow_at(level, column, row)
        stones = self.grain.at("stones", level, column, row)
        bare = 1.0 - (share[0] + share[1] + share[2] + share[3])
        if share[3].any():
            worn = (stones + 0.9 * slow + (1.6 * self.wear - 2.6)) * 0.8
            lost = share[3] * np.clip(worn, 0.0, 0.85)
            share[3], share[0] = share[3] - lost, share[0] + lost
        if share[0].any():
            share[0] *= self._tone(level, low, texel) * (1.0 + 0.085 * stones + 0.05 * slow)
        if share[1].any():
            share[1] *= self._slabs(level, column, row) * (1.0 + 0.05 * stones + 0.04 * slow)
        share[2] *= 1.0 + 0.05 * stones
        share[3] *= 1.0 + 0.05 * stones
        colour = cv2.transform(cv2.merge(share), A_COLOUR)
        if bare.max() > 0.0:
            colour += self._grass(level, column, row, slow, bare)
        light = self._light(low, texel)
        if light is not None:
            colour = cv2.multiply(colour, cv2.merge((light, light, light)))
        alpha = np.maximum(weights[..., 0], weights[..., 3])
        return cv2.merge((*cv2.split(cv2.convertScaleAbs(np.maximum(colour, 0.0))), alpha))

    def _weights(self, low: Array, texel: float) -> UInt8[Array, "t t 4"]:
        """How much asphalt, pavement, kerb and line is in each texel."""
        if not len(self.surfaces.within(low, low + TILE * texel)):
            return np.zeros((TILE, TILE, 4), np.uint8)
        size = FINER * TILE
        weights = self.surfaces.fill(np.zeros((size, size, 4), np.uint8), low, texel / FINER)
        return cv2.resize(weights, (TILE, TILE), interpolation=cv2.INTER_AREA)

    def _grass(
        self,
        level: int,
        column: int,
        row: int,
        slow: Float32[Array, "t t"],
        bare: Float32[Array, "t t"],
    ) -> Float32[Array, "t t 3"]:
        dry = np.clip(0.3 + 0.35 * slow, 0.0, 1.0)
        blades = bare * (1.0 + 0.16 * self.grain.at("blades", level, column, row))
        return cv2.transform(cv2.merge((blades, blades * dry)), A_GRASS)

    def _tone(self, level: int, low: Array, texel: float) -> Float32[Array, "t t"]:
        """How bright the asphalt is: tracks of wheels, patches, covers, cracks; 1 = its own."""
        tone = np.full((TILE, TILE), 128, np.uint8)
        self.tracks.fill(tone, low, texel)
        soft = round(0.2 / texel)
        if soft > 1:
            tone = np.asarray(cv2.blur(tone, (soft, soft)))
        if level <= CRACKED + 1:
            self.marks.fill(tone, low, texel)
        if level <= CRACKED:
            found = self.cracks.within(low, low + TILE * texel).tolist()
            points = [(self.cracks.corners[row] - low) / texel - 0.5 for row in found]
            lines = [np.round(one * 16.0).astype(np.int32) for one in points]
            cv2.polylines(tone, lines, False, (62 + 22 * level,), 1, cv2.LINE_AA, 4)
        return tone * np.float32(1.0 / 128.0)

    def _slabs(self, level: int, column: int, row: int) -> Float32[Array, "t t"]:
        """How bright slabs of the pavement are, and the dark joints between them."""
        side = SLAB / (TEXEL * 2**level)  # texels
        if side < 4.0:
            return np.ones((TILE, TILE), np.float32)
        u, v = column * TILE + np.arange(TILE), row * TILE + np.arange(TILE)
        slow = self.grain.slow
        rows, columns = (v // side).astype(int) * 37, (u // side).astype(int) * 53
        own = slow[np.ix_(rows % len(slow), columns % len(slow))]
        tone = (1.0 + 0.05 * own).astype(np.float32)
        joint = 0.72 if level == 0 else 1.0 - 0.28 / 2**level
        tone[v % side < 1.0] *= joint
        tone[:, u % side < 1.0] *= joint
        return tone

    def _light(self, low: Array, texel: float) -> Float32[Array, "t t"] | None:
        """What the shadows of trees and houses leave of the light; None where there are none."""
        if not len(self.shadows.within(low, low + TILE * texel)):
            return None
        margin = 8  # around, so that the blur knows of what lies beside the tile
        wide = np.zeros((TILE + 2 * margin, TILE + 2 * margin), np.uint8)
        self.shadows.fill(wide, low - margin * texel, texel)
        soft = max(2 * round(0.15 / texel / 2) + 1, 1)
        shade = cv2.blur(wide, (soft, soft))[margin:-margin, margin:-margin]
        return np.float32(1.0) - shade * np.float32(1.0 / 255.0)
