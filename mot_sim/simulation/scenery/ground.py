"""The ground from above, tile by tile: every tile is a function of roads, seed and place."""

from dataclasses import dataclass
from functools import cache, cached_property, lru_cache

import cv2
import numpy as np
from jaxtyping import Float32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.random_numbers import named_stream
from mot_sim.simulation.scenery.patches import Patches
from mot_sim.simulation.scenery.road_damage import damage_of, tracks_of
from mot_sim.simulation.traffic.roads import PAINTS, Roads
from tracker.kernels import Kernel

MIX_TILE = Kernel("mot_sim.simulation.kernels.tiles", "mix_tile")

TEXEL_METRES = 0.025  # metres, of the finest pictures
COVER_TEXEL_METRES = 0.25  # metres, of the picture of shadows that cars are lit by
LEVEL_COUNT = 5  # each one twice as coarse as the one before
PERIOD_TEXELS = 1024  # texels of the finest picture after which the grain repeats: 25.6 m
# A texel of the slow noise is 2^4 of the finest, 0.4 m; it repeats after 409.6 m.
SLOW_SHIFT = 4
TILE_TEXELS = 256  # texels along a tile's sides
SUPERSAMPLING = 2  # patches are filled on a finer grid, then averaged: smooth edges
CHANNELS = {paint: channel for channel, paint in enumerate(("asphalt", "pavement", "kerb", "line"))}
ASPHALT_COLOUR = (126, 122, 117)
PAVEMENT_COLOUR = (158, 154, 147)
KERB_COLOUR = (178, 176, 170)
LINE_COLOUR = (228, 228, 222)
GRASS_COLOUR = np.array([86, 101, 56], np.float32)
DRY_GRASS_COLOUR = np.array([124, 116, 78], np.float32)
SLAB_METRES = 0.5  # metres
SEAL_METRES = 0.04  # metres: the width of the tar in cracks and around patches
FLECK_METRES = 0.15  # metres: the size of the spots of sun beneath leaves
MAX_FEET_LEVEL = 2  # of detail: from afar what stands there hides its own feet
MAX_FLECK_LEVEL = 2  # of detail: on coarser levels they are a part of the mean
MAX_CRACK_LEVEL = 2  # of detail: cracks are finer than the texels of coarser levels
# Of asphalt, pavement, kerb, line, grass and dry grass.
TILE_COLOURS = np.array(
    [ASPHALT_COLOUR, PAVEMENT_COLOUR, KERB_COLOUR, LINE_COLOUR, GRASS_COLOUR, DRY_GRASS_COLOUR],
    np.float32,
)
Place = tuple[int, int, int]  # of a tile: its level, column and row


@dataclass(frozen=True, eq=False)
class Grain:
    """Periodic noise; that of level 0 has unit variance, coarser levels are its means."""

    stones: tuple[Float32[Array, "_ _"], ...]
    """For each level of detail the noise of asphalt, pavement, kerbs and lines."""
    blades: tuple[Float32[Array, "_ _"], ...]
    """For each level of detail the noise of grass."""
    slow: Float32[Array, "s s"]
    """Noise with 0.4 m per texel for all levels: large spots."""

    def at(self, which: str, level: int, column: int, row: int) -> Float32[Array, "t t"]:
        """The noise under a tile."""
        layer: Float32[Array, "_ _"] = getattr(self, which)[level]
        period = max(PERIOD_TEXELS >> level, 1)
        u, v = column * TILE_TEXELS % period, row * TILE_TEXELS % period
        return layer[v : v + TILE_TEXELS, u : u + TILE_TEXELS]

    def slow_at(self, shift: int, column: int, row: int) -> Float32[Array, "n n"]:
        """The slow noise under a tile and beside it; a texel of it is 1 << shift texels wide."""
        count = TILE_TEXELS >> shift
        u, v = ((place * count + np.arange(count + 1)) % len(self.slow) for place in (column, row))
        return self.slow[np.ix_(v, u)]


@lru_cache(maxsize=4)
def grain_of(seed: int) -> Grain:
    """The grain of a seed."""
    rng = named_stream(seed, "grain")
    stones = _rough(rng, PERIOD_TEXELS, 0.35)
    stones += 1.2 * (stones > 2.2) - 0.8 * (stones < -2.3)  # single bright and dark stones
    blades = _rough(rng, PERIOD_TEXELS, 0.75)
    slow = _rough(rng, PERIOD_TEXELS, 1.6)
    return Grain(_pyramid(stones), _pyramid(blades), slow)


def _rough(rng: np.random.Generator, size: int, slope: float) -> Float32[Array, "s s"]:
    """Periodic noise whose amplitude falls with the frequency to the power of -slope."""
    spectrum = np.fft.rfft2(rng.standard_normal((size, size)))
    v, u = np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None]
    frequency = np.maximum(np.hypot(u, v), 2.0 / size)
    noise = np.fft.irfft2(spectrum * frequency**-slope, (size, size))
    noise -= noise.mean()
    return (noise / noise.std()).astype(np.float32)


def _pyramid(noise: Float32[Array, "s s"]) -> tuple[Float32[Array, "_ _"], ...]:
    """The mean of 1, 4, 16, ... texels, repeated until a tile fits at every place."""
    layers = []
    for level in range(LEVEL_COUNT):
        size = PERIOD_TEXELS >> level
        layer = cv2.resize(noise, (size, size), interpolation=cv2.INTER_AREA) if level else noise
        times = -(-(size + TILE_TEXELS) // size)
        layers.append(
            np.tile(layer, (times, times))[: size + TILE_TEXELS, : size + TILE_TEXELS].copy()
        )
    return tuple(layers)


assert set(CHANNELS) == set(PAINTS)


@dataclass(frozen=True, eq=False)
class Ground:
    """What tiles are painted from."""

    surfaces: Patches
    """The painted patches of the roads; each is filled with 255 in the channel of its paint."""
    tracks: Patches
    """Where tyres and oil darken the asphalt; the value is its brightness, 128 = its own."""
    marks: Patches
    """Mended spots and manhole covers; the value is the brightness, 128 = the asphalt's own."""
    cracks: Patches
    """Open polylines along which the asphalt is broken; without values."""
    shadows: Patches
    """Of things that stand still; the value is how dark each is, 255 = black."""
    canopy: Patches
    """The same of leaves, through which some sun comes."""
    crowns: Patches
    """The outlines of that, for cars beneath the leaves."""
    feet: Patches
    """Around what stands on the ground, where less of the sky is seen; values as of shadows."""
    grain: Grain
    """The noise on all paints."""
    wear: float
    """How worn the lines are, 0 (new) to 1; more: larger parts of the lines are lost."""

    @classmethod
    def of(
        cls,
        roads: Roads,
        seed: int,
        wear: float,
        shadows: tuple[Patches, Patches, Patches],
        feet: Patches,
    ) -> "Ground":
        """The ground of roads; shadows and feet: of `scenery.shadows_of` and `feet_of`."""
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
            *shadows,
            feet,
            grain_of(seed),
            wear,
        )

    def tile(self, level: int, column: int, row: int) -> UInt8[Array, "t t 4"]:
        """A tile's picture; alpha is 255 on what cars drive on."""
        texel = TEXEL_METRES * 2**level
        low = TILE_TEXELS * texel * np.array([column, row], dtype=float)
        place = level, column, row
        weights = self._weights(low, texel)
        bits = np.bitwise_or.reduce(weights.view(np.uint32), axis=None)
        is_painted = np.frombuffer(bits.tobytes(), np.uint8) > 0
        asphalt = is_painted[0] or is_painted[3]  # which shows where a line is worn
        rgba = np.empty((TILE_TEXELS, TILE_TEXELS, 4), np.uint8)
        shift = SLOW_SHIFT - level
        MIX_TILE(
            weights.view(np.uint32)[..., 0],
            self._tone(level, low, texel) if asphalt else _plain_tone(),
            self._slabs(*place) if is_painted[1] else _plain_slabs(),
            self._shade(place, low, texel),
            np.ascontiguousarray(self.grain.at("stones", *place)),
            np.ascontiguousarray(self.grain.at("blades", *place)),
            self.grain.slow_at(shift, column, row),
            shift,
            TILE_COLOURS,
            self.wear,
            np.empty((9, TILE_TEXELS + 1), np.float32),
            rgba.view(np.uint32)[..., 0],
        )
        return rgba

    def cover_tile(self, column: int, row: int) -> UInt8[Array, "t t"]:
        """How much of the sun static shadows hide in a tile of COVER_TEXEL_METRES; 255 = all."""
        low = TILE_TEXELS * COVER_TEXEL_METRES * np.array([column, row], dtype=float)
        dark = np.maximum(
            self._filled(self.shadows, low, COVER_TEXEL_METRES),
            self._filled(self.crowns, low, COVER_TEXEL_METRES),
        )
        return cv2.convertScaleAbs(dark, alpha=255.0 / max(self.darkest, 1))

    @cached_property
    def darkest(self) -> int:
        """How dark the darkest shadow is; 255 where there is none."""
        every = (*self.shadows.values, *self.canopy.values)
        return max((value for values in every for value in values), default=255)

    def _weights(self, low: Array, texel: float) -> UInt8[Array, "t t 4"]:
        """How much asphalt, pavement, kerb and line is in each texel."""
        rows = self.surfaces.within(low, low + TILE_TEXELS * texel)
        if not len(rows):
            return np.zeros((TILE_TEXELS, TILE_TEXELS, 4), np.uint8)
        size = SUPERSAMPLING * TILE_TEXELS
        weights = self.surfaces.fill(
            np.zeros((size, size, 4), np.uint8), low, texel / SUPERSAMPLING, rows
        )
        return cv2.resize(weights, (TILE_TEXELS, TILE_TEXELS), interpolation=cv2.INTER_AREA)

    def _tone(self, level: int, low: Array, texel: float) -> UInt8[Array, "t t"]:
        """How bright the asphalt is: tracks of wheels, patches, covers, cracks; 128 = its own."""
        tone = np.full((TILE_TEXELS, TILE_TEXELS), 128, np.uint8)
        self.tracks.fill(tone, low, texel)
        soft = round(0.2 / texel)
        if soft > 1:
            tone = np.asarray(cv2.blur(tone, (soft, soft)))
        if level <= MAX_CRACK_LEVEL + 1:
            self.marks.fill(tone, low, texel)
        if level <= MAX_CRACK_LEVEL:
            found = self.cracks.within(low, low + TILE_TEXELS * texel).tolist()
            points = [(self.cracks.corners[row] - low) / texel - 0.5 for row in found]
            lines = [np.round(one * 16.0).astype(np.int32) for one in points]
            wide = max(round(SEAL_METRES / texel), 1)
            cv2.polylines(tone, lines, False, (74 + 14 * level,), wide, cv2.LINE_AA, 4)
        return tone

    def _slabs(self, level: int, column: int, row: int) -> Float32[Array, "t t"]:
        """How bright slabs of the pavement are, and the dark joints between them."""
        side = SLAB_METRES / (TEXEL_METRES * 2**level)  # texels
        if side < 4.0:
            return _plain_slabs()
        u, v = (
            column * TILE_TEXELS + np.arange(TILE_TEXELS),
            row * TILE_TEXELS + np.arange(TILE_TEXELS),
        )
        slow, (rows, columns) = self.grain.slow, ((one // side).astype(int) for one in (v, u))
        own = slow[np.ix_(
            np.arange(rows[0], rows[-1] + 1) * 37 % len(slow),
            np.arange(columns[0], columns[-1] + 1) * 53 % len(slow),
        )]  # fmt: skip
        tone = (1.0 + 0.05 * own).astype(np.float32)
        tone = tone[rows - rows[0]].take(columns - columns[0], axis=1)
        joint = 0.72 if level == 0 else 1.0 - 0.28 / 2**level
        tone[v % side < 1.0] *= joint
        tone[:, u % side < 1.0] *= joint
        return tone

    def _shade(self, place: Place, low: Array, texel: float) -> UInt8[Array, "t t"]:
        """How much of the light what stands still takes, by its shadows and its feet; 255 = all."""
        dark, leaves = (self._filled(one, low, texel) for one in (self.shadows, self.canopy))
        if place[0] <= MAX_FLECK_LEVEL and leaves.any():
            soft = max(round(FLECK_METRES / texel), 1)
            spots = cv2.blur(self.grain.at("blades", *place), (soft, soft))
            sunny = (2.0 * (spots - 0.2)).clip(0.0, 0.9)
            leaves = (leaves * (1.0 - sunny)).astype(np.uint8)
        dark = np.maximum(dark, leaves)
        feet = self._filled(self.feet, low, texel) if place[0] <= MAX_FEET_LEVEL else dark[:0]
        if feet.any():
            light = cv2.multiply(cv2.bitwise_not(dark), cv2.bitwise_not(feet), scale=1.0 / 255.0)
            dark = cv2.bitwise_not(light)
        return dark

    def _filled(self, patches: Patches, low: Array, texel: float) -> UInt8[Array, "t t"]:
        """Patches in a tile with soft borders."""
        margin = 8  # around, so that the blur knows of what lies beside the tile
        high, around = low + TILE_TEXELS * texel, margin * texel
        rows = patches.within(low - around, high + around)
        boxes = patches.boxes[rows]
        if not ((boxes[:, :2] < high) & (boxes[:, 2:] > low)).all(axis=1).any():
            return np.zeros((TILE_TEXELS, TILE_TEXELS), np.uint8)
        wide = np.zeros((TILE_TEXELS + 2 * margin, TILE_TEXELS + 2 * margin), np.uint8)
        patches.fill(wide, low - around, texel, rows)
        soft = max(2 * round(0.15 / texel / 2) + 1, 1)
        return np.ascontiguousarray(cv2.blur(wide, (soft, soft))[margin:-margin, margin:-margin])


@cache
def _plain_tone() -> UInt8[Array, "t t"]:
    return np.full((TILE_TEXELS, TILE_TEXELS), 128, np.uint8)


@cache
def _plain_slabs() -> Float32[Array, "t t"]:
    return np.ones((TILE_TEXELS, TILE_TEXELS), np.float32)
