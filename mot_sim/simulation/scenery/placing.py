"""Where houses, trees, lamps and walls stand: along the roads, seeded, never on them."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.scenery.houses import house
from mot_sim.simulation.scenery.props import Make, garden_wall, hedge, makers, rail, wire
from mot_sim.simulation.scenery.solids import Solid
from mot_sim.simulation.scenery.terrain import Terrain
from mot_sim.simulation.traffic.roads import Plot
from tracker.errors import BadConfig

MAX_DENSITY = 3.0  # times a usual town's density
HOUSE_KINDS = 18  # that differ; streets draw from them
MIN_CLEARANCE_METRES = 1.0  # metres from any thing to the asphalt, on a grid of half a metre
FENCE_METRES = 3.6  # from the asphalt
HOUSE_METRES = 7.5  # from the asphalt
WOOD_METRES = 16.0  # from the asphalt, of the first woods
WIRE_METRES = (12.0, 45.0)  # between lamps that share a wire
WIRED_SHARE, WIRED_LAMPS = 0.5, 6  # of the rows of so many lamps have wires
UNSCALED = (1.0, 1.0)
_hedge_of = lru_cache(maxsize=256)(hedge)
_rail_of = lru_cache(maxsize=64)(rail)


@dataclass(frozen=True)
class Knobs:
    """What a neighbourhood looks like."""

    wear: float = 0.5
    """Wear of asphalt and paint, 0 (new) to 1; more: more cracks and mended spots, paler lines."""
    houses: float = 1.0
    """Density of houses, 0 to 3: 0 = none, 1 = as in a usual town."""
    trees: float = 1.0
    """Density of trees and bushes, 0 to 3: 0 = none, 1 = as in a usual town."""
    furniture: float = 1.0
    """Density of lamps, signs and fences, 0 to 3: 0 = none, 1 = as in a usual town."""

    def __post_init__(self) -> None:
        for name, most in (
            ("wear", 1.0),
            ("houses", MAX_DENSITY),
            ("trees", MAX_DENSITY),
            ("furniture", MAX_DENSITY),
        ):
            value = getattr(self, name)
            if not 0.0 <= value <= most:
                raise BadConfig(f"{name} of a neighbourhood is {value:g}: give 0 to {most:g}")


@dataclass(frozen=True, eq=False)
class Item:
    """A thing at its place beside the road."""

    kind: str
    """What it is: house, tree, bush, lamp, wire, sign, hedge, wall or rail."""
    make: Callable[[int], Solid]
    """Gives the thing in world, by level of detail: 0 (finest) to DETAIL_LEVELS - 1."""
    base: Float[Array, "n 2"]
    """Corners x, y in world, metres, of the convex outline of what stands on the ground."""
    leafy: bool = False
    """Whether light comes through it, so that each of its faces casts its own shadow."""


def place(terrain: Terrain, seed: int, knobs: Knobs, plots: tuple[Plot, ...] = ()) -> list[Item]:
    """All things beside the roads. Roads with pavements lie in a town, others outside.

    plots: where houses stand in any case. Raises BadConfig for one too near to the asphalt.
    """
    is_town = bool(((terrain.paved > 0) & (terrain.distance > 1.0)).any())
    items = [_house_on(plot, terrain, seed, number) for number, plot in enumerate(plots)]
    if is_town:
        items += _houses(terrain, seed, HOUSE_METRES, knobs.houses)
        items += _fences(terrain, seed, knobs.furniture)
        items += _single(terrain, seed, "tree", 4.6, 8.0, 0.62 * knobs.trees)
        items += _single(terrain, seed, "bush", 5.6, 5.0, 0.5 * knobs.trees)
        lamps = _single(terrain, seed, "lamp", 1.3, 26.0, knobs.furniture)
        items += lamps + _wires(lamps, seed)
        items += _single(terrain, seed, "sign", 1.3, 21.0, 0.7 * knobs.furniture)
    else:
        items += _rails(terrain, knobs.furniture)
        items += _single(terrain, seed, "sign", 2.2, 70.0, 0.7 * knobs.furniture)
        items += _single(terrain, seed, "bush", 5.0, 7.0, 0.5 * knobs.trees)
        items += _single(terrain, seed, "tree", 8.5, 8.0, 0.7 * knobs.trees)
        items += _houses(terrain, seed, 32.0, 0.25 * knobs.houses)
    for number, away in enumerate((WOOD_METRES, WOOD_METRES + 14.0, WOOD_METRES + 32.0)):
        items += _single(
            terrain, seed + 7 + number, "tree", away, 9.0 + 5.0 * number, 0.7 * knobs.trees, 1.5
        )
    return items


def _walk(
    terrain: Terrain, away: float, seed: int, effect: str, pitch: float
) -> tuple[Float[Array, "n 2"], Float[Array, "n 2"], Float[Array, "n 6"]]:
    """Points along the roads about a pitch apart, directions away, six draws each."""
    number, found = 0, [(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros((0, 6)))]
    for points, out in terrain.lines(away):
        count = max(int(len(points) / pitch), 1)
        ids = np.arange(number, number + count)
        chance = random_numbers.uniform(seed, effect, ids, np.zeros_like(ids), 6)
        rows = ((np.arange(count) + 0.5 * chance[:, 0]) * len(points) / count).astype(int)
        found.append((points[rows], out[rows], chance))
        number += count
    points, out, chance = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return points, out, chance


def _houses(terrain: Terrain, seed: int, away: float, amount: float) -> list[Item]:
    """Houses in a row that face the road, gaps between them."""
    points, outs, draws = _walk(terrain, away, seed, "house", 4.0)
    kinds = (HOUSE_KINDS * draws[:, 1]).astype(int)
    width, depth = HOUSE_SIZES[kinds].T
    alongs = np.stack((outs[:, 1], -outs[:, 0]), axis=1)  # the house lies left of x, behind y
    starts = points - 0.5 * width[:, None] * alongs + 2.5 * draws[:, 3:4] * outs
    across, back = width[:, None] * alongs, depth[:, None] * outs
    bases = starts[:, None] + np.stack((0.0 * outs, across, across + back, back), axis=1)
    behind = terrain.distance[terrain.cells(bases[:, 2:].reshape(-1, 2))].reshape(-1, 2)
    # Where it is near another road lies behind the house, as around an island.
    is_alone = behind.min(axis=1) >= (away + depth - 3.0).astype(np.float32)
    rows = np.flatnonzero(is_alone & (draws[:, 4] < amount))
    settled = rows[terrain.settle(bases[rows], away - 1.5, 1.2)].tolist()
    return [
        _house_item(seed, int(kinds[row]), starts[row], alongs[row], outs[row]) for row in settled
    ]


def _house_on(plot: Plot, terrain: Terrain, seed: int, number: int) -> Item:
    """The house of a plot."""
    start, side = np.array(plot.corner), 1.0 if plot.is_right else -1.0
    along = np.array([np.cos(plot.front), np.sin(plot.front)])
    out = side * np.array([-along[1], along[0]])
    key = np.array([number]), np.zeros(1, np.int64)
    kind = int(HOUSE_KINDS * random_numbers.uniform(seed, "plot", *key)[0, 0])
    base = _outline(start, along, out, kind)
    if not terrain.settle(base[None], MIN_CLEARANCE_METRES):
        raise BadConfig(
            f"a house at {plot.corner}: it stands on something, or nearer to the asphalt than "
            f"{MIN_CLEARANCE_METRES:g} m"
        )
    return _house_item(seed, kind, start, along, out)


def _house_item(seed: int, kind: int, start: Array, along: Array, out: Array) -> Item:
    turn = float(np.arctan2(along[1], along[0]))
    make = partial(_house_at, seed, kind, (start, turn, out))
    return Item("house", make, _outline(start, along, out, kind))


def _outline(start: Array, along: Array, out: Array, kind: int) -> Float[Array, "4 2"]:
    """The corners of a house from its first one along its front and back."""
    width, depth = _house_size(kind)
    return start + np.array([0.0 * out, width * along, width * along + depth * out, depth * out])


def _house_size(kind: int) -> tuple[float, float]:
    """Width and depth of a kind of house, metres."""
    wide, deep = kind * 7 % HOUSE_KINDS, kind * 5 % HOUSE_KINDS
    return 8.5 + 6.5 * wide / HOUSE_KINDS, 8.0 + 3.5 * deep / HOUSE_KINDS


HOUSE_SIZES = np.array([_house_size(kind) for kind in range(HOUSE_KINDS)])


def _house_at(seed: int, kind: int, spot: tuple[Array, float, Array], detail: int) -> Solid:
    return _set_down(_house(seed, kind, detail), *spot)


@lru_cache(maxsize=256)
def _house(seed: int, kind: int, detail: int) -> Solid:
    return house(seed, kind, *_house_size(kind), detail)


def _set_down(solid: Solid, start: Array, turn: float, out: Array) -> Solid:
    """A solid that reaches from x along and back to y > 0, put so that +y looks along `out`."""
    c, s = np.cos(turn), np.sin(turn)
    if -s * out[0] + c * out[1] < 0.0:  # the frame would have to be mirrored: mirror the solid
        corners = solid.corners * (1.0, -1.0, 1.0)
        solid = replace(solid, corners=corners[:, ::-1])
    return solid.moved((float(start[0]), float(start[1])), turn)


def _single(
    terrain: Terrain,
    seed: int,
    kind: str,
    away: float,
    pitch: float,
    amount: float,
    scatter: float = 0.5,
) -> list[Item]:
    """Trees, bushes, lamps or signs, one by one; a sign faces those who drive on its side."""
    make, radius, leafy = makers(seed)[kind]
    circle = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]) * radius
    least = max(min(away - 0.8, 0.6 * away), MIN_CLEARANCE_METRES)
    points, outs, draws = _walk(terrain, away, seed, kind, pitch)
    shifts = scatter * (4.0 * (draws[:, 1] - 0.5)) if leafy else np.zeros(len(points))
    spots = points + np.maximum(shifts, away * -0.2)[:, None] * outs
    bases = spots[:, None] + circle
    rows = np.flatnonzero(draws[:, 2] < amount)
    settled = rows[terrain.settle(bases[rows], least, 0.8 if leafy else 0.0)].tolist()
    found = []
    for number, out, draw in zip(settled, outs[settled], draws[settled].tolist(), strict=True):
        size = 0.75 + 0.55 * draw[3] if leafy else 1.0
        turn = 2.0 * np.pi * draw[4] if leafy else float(np.arctan2(out[1], out[0]) - 0.5 * np.pi)
        scale = (size, size * (0.9 + 0.35 * draw[5])) if leafy else (1.0, 1.0)
        there = (float(spots[number, 0]), float(spots[number, 1]))
        move = partial(_moved, make, number, (there, turn, scale))
        found.append(Item(kind, move, bases[number], leafy))
    return found


def _wires(lamps: list[Item], seed: int) -> list[Item]:
    """Wires from lamp to lamp along some streets: they hang high above all cars."""
    feet = np.array([lamp.base.mean(axis=0) for lamp in lamps]).reshape(-1, 2)
    spans = np.diff(feet, axis=0)
    lengths = np.hypot(*spans.T)
    rows = np.flatnonzero((lengths > WIRE_METRES[0]) & (lengths < WIRE_METRES[1]))
    draws = random_numbers.uniform(seed, "wire", rows // WIRED_LAMPS, np.zeros_like(rows))[:, 0]
    found = []
    for row in rows[draws < WIRED_SHARE].tolist():
        side = 0.05 * np.array([-spans[row, 1], spans[row, 0]]) / lengths[row]
        start, end = feet[row], feet[row + 1]
        base = np.array([start - side, end - side, end + side, start + side])
        found.append(Item("wire", partial(wire, start, end), base))
    return found


def _moved(
    make: Make,
    number: int,
    spot: tuple[tuple[float, float], float, tuple[float, float]],
    detail: int,
) -> Solid:
    return make(number, detail).moved(*spot)


def _fences(terrain: Terrain, seed: int, amount: float) -> list[Item]:
    """Hedges and walls along the plots, straight pieces with gaps."""
    points, outs, draws = _walk(terrain, FENCE_METRES, seed, "fence", 9.0)
    lengths = 5.0 + (5.0 * draws[:, 1]).astype(int)
    alongs = np.stack((outs[:, 1], -outs[:, 0]), axis=1)
    starts = points - 0.5 * lengths[:, None] * alongs
    across, half = lengths[:, None] * alongs, 0.36 * outs
    bases = starts[:, None] + np.stack((-half, across - half, across + half, half), axis=1)
    rows = np.flatnonzero(draws[:, 2] < 0.75 * amount)
    found = []
    for number in rows[terrain.settle(bases[rows], FENCE_METRES - 1.0)].tolist():
        length, along, start = float(lengths[number]), alongs[number], starts[number]
        spot = (float(start[0]), float(start[1])), float(np.arctan2(along[1], along[0])), UNSCALED
        is_hedge = draws[number, 3] < 0.6
        make = partial(_hedge if is_hedge else _garden, length, seed)
        put = partial(_moved, make, number, spot)
        found.append(Item("hedge" if is_hedge else "wall", put, bases[number]))
    return found


def _hedge(length: float, seed: int, number: int, detail: int) -> Solid:
    return _hedge_of(length, seed, number % 6, detail)


def _garden(length: float, seed: int, number: int, detail: int) -> Solid:
    return _garden_of(length, seed, number % 6, detail)


def _rail(length: float, number: int, detail: int) -> Solid:
    return _rail_of(round(length, 1), detail)


@lru_cache(maxsize=256)
def _garden_of(length: float, seed: int, kind: int, detail: int) -> Solid:
    tones = random_numbers.uniform(seed, "stone", np.full(24, kind), np.arange(24))[:, 0]
    return garden_wall(length, 0.8 + 0.35 * tones, detail)


def _rails(terrain: Terrain, amount: float) -> list[Item]:
    """Guard rails along roads outside of towns."""
    found: list[Item] = []
    piece = 12
    for points, _ in terrain.lines(1.6) if amount > 0.0 else []:
        for row in range(0, len(points) - piece, piece):
            start, end = points[row], points[row + piece]
            length = float(np.hypot(*(end - start)))
            if length < 0.9 * piece:
                continue
            along = (end - start) / length
            side = 0.1 * np.array([-along[1], along[0]])
            base = np.array([start - side, end - side, end + side, start + side])
            turn = float(np.arctan2(along[1], along[0]))
            there = (float(start[0]), float(start[1]))
            build = partial(_moved, partial(_rail, length), 0, (there, turn, UNSCALED))
            found.append(Item("rail", build, base))
    bases = np.array([rail.base for rail in found]).reshape(-1, 4, 2)
    return [found[row] for row in terrain.settle(bases, MIN_CLEARANCE_METRES, takes=False)]
