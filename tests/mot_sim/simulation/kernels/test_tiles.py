"""Tiles of the ground equal what plain NumPy mixes, within a grey level."""

from functools import cache

import numpy as np
import pytest

from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.scenery import WEATHERS, Neighbourhood
from mot_sim.simulation.scenery import ground as painting
from mot_sim.simulation.scenery.ground import Ground


@cache
def street() -> Ground:
    scene = find_scene("street", frames=2)
    return Neighbourhood.build(scene.roads, 3, WEATHERS["noon"].light).windows.ground


def plain_tile(ground: Ground, place: tuple[int, int, int]) -> np.ndarray:
    """A tile, layer after layer."""
    texel = painting.TEXEL_METRES * 2 ** place[0]
    low = painting.TILE_TEXELS * texel * np.array(place[1:], float)
    weights = ground._weights(low, texel)
    asphalt, pavement, kerb, line = np.moveaxis(weights / 255.0, -1, 0)
    stones, blades = ground.grain.at("stones", *place), ground.grain.at("blades", *place)
    shift, texels = painting.SLOW_SHIFT - place[0], np.arange(painting.TILE_TEXELS)
    coarse = ground.grain.slow_at(shift, *place[1:]).astype(float)
    at = texels / 2**shift, np.arange(len(coarse))
    along = np.stack([np.interp(*at, line) for line in coarse])
    slow = np.stack([np.interp(*at, line) for line in along.T], axis=1)
    lost = line * np.clip(0.8 * (stones + 0.9 * slow + 1.6 * ground.wear - 2.6), 0.0, 0.85)
    line, asphalt = line - lost, asphalt + lost
    tone = ground._tone(place[0], low, texel) / 128.0
    asphalt = asphalt * tone * (1.0 + 0.09 * stones + 0.08 * slow)
    pavement = pavement * ground._slabs(*place) * (1.0 + 0.05 * stones + 0.04 * slow)
    grass = (1.0 + 0.16 * blades) * (1.0 - weights.sum(axis=2, dtype=int).clip(max=255) / 255.0)
    dry = np.clip(0.3 + 0.35 * slow, 0.0, 1.0)
    gritty, colours = 1.0 + 0.05 * stones, painting.TILE_COLOURS.astype(float)
    layers = asphalt, pavement, kerb * gritty, line * gritty, grass * (1.0 - dry), grass * dry
    mixed = sum(layer[..., None] * colour for layer, colour in zip(layers, colours, strict=True))
    light = 1.0 - ground._shade(place, low, texel) / 255.0
    rgb = np.rint(mixed * light[..., None]).clip(max=255.0)
    return np.dstack((rgb, np.maximum(weights[..., 0], weights[..., 3]))).astype(np.uint8)


@pytest.mark.parametrize(
    "place", [(0, 0, 0), (0, 3, -1), (1, 2, 0), (2, 1, -1), (3, 0, 0), (4, -1, 0), (4, 40, 40)]
)
def test_tiles(place: tuple[int, int, int]) -> None:
    """On the road, beside it, far away from it."""
    found, expected = street().tile(*place), plain_tile(street(), place)
    apart = np.abs(found.astype(int) - expected)
    assert apart[..., 3].max() == 0
    assert apart.max() <= 1
    assert (apart > 0).mean() < 0.001
    assert len(np.unique(found[..., :3])) > 20
