"""What the ground is painted with: convex patches in world coordinates, from below to above."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

PAINTS = ("pavement", "asphalt", "kerb", "line")


@dataclass(frozen=True, eq=False)
class Surface:
    """A convex patch of ground."""

    paint: str
    """What it is: one of PAINTS."""
    corners: Float[Array, "n 2"]
    """Corners x, y in world, metres, in order around the patch."""


@dataclass(frozen=True, eq=False)
class Lane:
    """One lane: an edge of the lane graph."""

    centre: Float[Array, "n 2"]
    """Points x, y of the centre line in world, metres, in driving direction."""
    width: float
    """Metres."""
    begins: str
    """Name of the node that it leads from."""
    ends: str
    """Name of the node that it leads to."""


@dataclass(frozen=True, eq=False)
class Plot:
    """Where a house stands, however few stand elsewhere."""

    corner: tuple[float, float]
    """x, y in world of its corner that lies nearest to the roads, metres."""
    front: float
    """Direction from the corner along the front, radians from world +x towards +y."""
    is_right: bool
    """Whether the house lies to the right of that direction."""


@dataclass(frozen=True, eq=False)
class Roads:
    """All painted patches of a scene, and its lane graph."""

    surfaces: tuple[Surface, ...] = ()
    """Painted patches; later ones lie on earlier ones."""
    lanes: tuple[Lane, ...] = ()
    """The lane graph; empty where it is not known."""
    plots: tuple[Plot, ...] = ()
    """Houses that stand beside the roads in any case; the others are drawn by a seed."""


def rectangle(paint: str, x: tuple[float, float], y: tuple[float, float]) -> Surface:
    """The patch between two x and two y."""
    return Surface(paint, np.array([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]))


def ribbon(paint: str, centre: Float[Array, "n 2"], left: float, right: float) -> list[Surface]:
    """Quadrilaterals along a polyline, from `left` to `right` of it; right of travel is > 0."""
    ahead = np.gradient(centre, axis=0)
    ahead /= np.maximum(np.hypot(*ahead.T), 1e-9)[:, None]
    aside = np.stack((-ahead[:, 1], ahead[:, 0]), axis=1)
    a, b = centre + left * aside, centre + right * aside
    quads = np.stack((a[:-1], a[1:], b[1:], b[:-1]), axis=1)
    return [Surface(paint, quad) for quad in quads]


def stripe(
    start: tuple[float, float],
    end: tuple[float, float],
    width: float = 0.15,
    dash: tuple[float, float] | None = None,
) -> list[Surface]:
    """A painted line from start to end; dash: lengths of a dash and of the gap after it."""
    a, b = np.array(start), np.array(end)
    length = float(np.hypot(*(b - a)))
    along = (b - a) / length
    side = 0.5 * width * np.array([-along[1], along[0]])
    on, off = dash or (length, 0.0)
    surfaces = []
    for first in np.arange(0.0, length, on + off):
        p, q = a + first * along, a + min(first + on, length) * along
        surfaces.append(Surface("line", np.array([p - side, q - side, q + side, p + side])))
    return surfaces


def zebra(x: tuple[float, float], y: tuple[float, float], across: str = "y") -> list[Surface]:
    """A zebra crossing over the patch; its bars follow one another along x or y (`across`)."""
    low, high = y if across == "y" else x
    bars: Sequence[float] = np.arange(low + 0.25, high - 0.5, 1.0).tolist()
    if across == "y":
        return [rectangle("line", x, (bar, bar + 0.5)) for bar in bars]
    return [rectangle("line", (bar, bar + 0.5), y) for bar in bars]
