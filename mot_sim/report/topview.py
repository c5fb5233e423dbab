"""The scene from above: our heading, or the world's x, to the right."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.plotting.canvas import (
    Image,
    draw_line,
    draw_lines,
    draw_text,
    fill_polygon,
    text_width,
    tint_polygon,
)
from mot_sim.plotting.colours import (
    EGO_COLOUR,
    FAINT_COLOUR,
    GRASS_COLOUR,
    PAINT_COLOURS,
    PANEL_COLOUR,
    Colour,
    colour_of_id,
    ink_on,
    mix,
)
from mot_sim.simulation.traffic.roads import Roads
from tracker.types import Camera

GROUND_DIMMING = 0.45  # share of the panel's dark colour in those of the ground
TRUTH_COLOUR: Colour = (245, 245, 245)
DOUBT_SHARE = 0.3  # share of a track's colour in its ellipse
TRAIL_DIMMING = 0.45
ID_TEXT_PIXELS = 12
SURE = 0.9  # probability of a heading from which on the other one is not shown
HEAD_METRES = 1.2  # length of an arrow's head
VIEW_EDGE_METRES = 90.0  # length of the drawn edges of the camera's view
RING_METRES = 20.0  # between the rings of a map without roads
CIRCLE_ANGLES = np.linspace(0.0, 2.0 * np.pi, 97)[:-1]
UNIT_CIRCLE = np.stack((np.cos(CIRCLE_ANGLES), np.sin(CIRCLE_ANGLES)), axis=1)


@dataclass(frozen=True, eq=False)
class TopView:
    """A panel that shows the map from above."""

    roads: Roads
    """The roads, in the map's x and y; without surfaces rings are drawn instead."""
    origin: tuple[float, float]
    """Point x, y of the map, metres, that is shown at `anchor`."""
    scale: float
    """Pixels per metre; raising it shows less of the map."""
    size: tuple[int, int]
    """Width and height of the panel, px."""
    anchor: tuple[float, float] = (0.0, 0.0)
    """Where `origin` lies in the panel: right, down, px."""
    heading: float = 0.0
    """Direction of the map that points to the right, radians from x towards y."""

    def pixels(self, points: Float[Array, "*n 2"]) -> Float[Array, "*n 2"]:
        """Where points (x, y) of the map lie in the panel."""
        return (points - self.origin) @ self._R.T * self.scale + self.anchor

    @cached_property
    def _R(self) -> Float[Array, "2 2"]:
        c, s = np.cos(self.heading), np.sin(self.heading)
        return np.array([[c, s], [-s, c]])

    @cached_property
    def ground(self) -> Image:
        """The roads alone, or rings every 20 m around the origin where there are none."""
        image = np.empty((self.size[1], self.size[0], 3), np.uint8)
        image[:] = (
            mix(GRASS_COLOUR, PANEL_COLOUR, GROUND_DIMMING)
            if self.roads.surfaces
            else mix(PANEL_COLOUR, TRUTH_COLOUR, 0.04)
        )
        for surface in self.roads.surfaces:
            fill_polygon(
                image,
                self.pixels(surface.corners),
                mix(PAINT_COLOURS[surface.paint], PANEL_COLOUR, GROUND_DIMMING),
            )
        if not self.roads.surfaces:
            self._draw_rings(image)
        return image

    def _draw_rings(self, image: Image) -> None:
        faint = mix(PANEL_COLOUR, TRUTH_COLOUR, 0.17)
        for radius in np.arange(RING_METRES, 6 * RING_METRES, RING_METRES):
            ring = radius * self.scale * UNIT_CIRCLE + self.anchor
            draw_line(image, ring, faint, closed=True)
            u, v = self.anchor[0] + radius * self.scale, self.anchor[1]
            place = (round(u) + 4, round(v) + 14)
            draw_text(image, f"{radius:.0f} m", place, mix(PANEL_COLOUR, FAINT_COLOUR, 0.8), 12)

    def draw_us(
        self, image: Image, outline: Float[Array, "4 2"], camera: Camera, pose: Float[Array, "3"]
    ) -> None:
        """Our own car, and the two edges of what the camera sees."""
        width, _ = camera.image_size
        row = camera.K[1, 2]
        rays = camera.rays_road(np.array([(0.0, row), (width - 1.0, row)]))
        c, s = np.cos(pose[2]), np.sin(pose[2])
        for right, ahead in rays[:, ::2] * VIEW_EDGE_METRES:
            tip = pose[:2] + np.array([c * ahead - s * right, s * ahead + c * right])
            draw_line(image, self.pixels(np.stack((pose[:2], tip))), EGO_COLOUR)
        fill_polygon(image, self.pixels(outline), EGO_COLOUR)

    def draw_truth(self, image: Image, outlines: Float[Array, "n 4 2"]) -> None:
        """Outlines of cars, each with an arrow's head before its nose."""
        rings, heads = self.pixels(outlines), self.pixels(arrow_head(outlines))
        lines = [line for pair in zip(rings, heads, strict=True) for line in pair]
        draw_lines(image, lines, TRUTH_COLOUR, closed=True)

    def draw_doubts(
        self,
        image: Image,
        ids: Int[Array, " n"],
        centres: Float[Array, "n 2"],
        cov: Float[Array, "n 2 2"],
    ) -> None:
        """Where tracks may be: tinted ellipses of two standard deviations; none for NaN."""
        stated = np.isfinite(cov).all(axis=(1, 2))
        for track_id, centre, covariance in zip(
            ids[stated].tolist(), centres[stated], cov[stated], strict=True
        ):
            colour, around = colour_of_id(track_id), self.pixels(ellipse(centre, covariance, 2.0))
            tint_polygon(image, around, colour, DOUBT_SHARE)
            draw_line(image, around, mix(colour, TRUTH_COLOUR, 0.35), closed=True)

    def draw_places(
        self,
        image: Image,
        ids: Int[Array, " n"],
        outlines: Float[Array, "n 4 2"],
        heading_known: Float[Array, " n"] | None = None,
    ) -> None:
        """Where tracks are believed to be: outlines with an arrow's head at the nose, and ids.

        heading_known: probability of the heading; below SURE a hollow head at the tail says that
        the other way round is possible, and NaN has no head at all. None: all are sure.
        """
        known = np.ones(len(ids)) if heading_known is None else heading_known
        for track_id, corners, chance in zip(ids.tolist(), outlines, known.tolist(), strict=True):
            colour = colour_of_id(track_id)
            draw_line(image, self.pixels(corners), colour, 2, closed=True)
            if np.isfinite(chance):
                fill_polygon(image, self.pixels(arrow_head(corners)), colour)
            if chance < SURE:
                draw_line(image, self.pixels(arrow_head(np.roll(corners, 2, axis=0))), colour,
                          closed=True)  # fmt: skip
        for track_id, corners in zip(ids.tolist(), outlines, strict=True):
            self._draw_id(image, track_id, self.pixels(corners))

    def _draw_id(self, image: Image, track_id: int, pixels: Float[Array, "4 2"]) -> None:
        """A tag above an outline."""
        words, colour = str(track_id), colour_of_id(track_id)
        half = 0.5 * text_width(words, ID_TEXT_PIXELS) + 2.0
        u, v = round(float(pixels[:, 0].mean())), round(float(pixels[:, 1].min())) - 2
        left, right, top = u - half, u + half, v - ID_TEXT_PIXELS
        fill_polygon(image, np.array([(left, v), (right, v), (right, top), (left, top)]), colour)
        draw_text(image, words, (round(left + 2.0), v - 2), ink_on(colour), ID_TEXT_PIXELS)

    def draw_trails(self, image: Image, trails: Mapping[int, Float[Array, "_ 2"]]) -> None:
        """The past positions of tracks."""
        for track_id, points in trails.items():
            colour = mix(colour_of_id(track_id), PANEL_COLOUR, TRAIL_DIMMING)
            draw_line(image, self.pixels(points), colour)


def arrow_head(corners: Float[Array, "*n 4 2"]) -> Float[Array, "*n 3 2"]:
    """A triangle before the nose of a car's outline: its first two corners are in front."""
    nose = corners[..., :2, :]
    middle = nose.mean(axis=-2)
    ahead = middle - corners[..., 2:, :].mean(axis=-2)
    length = np.hypot(ahead[..., 0], ahead[..., 1])[..., None]
    tip = middle + ahead * np.divide(
        HEAD_METRES, length, out=np.zeros_like(length), where=length > 0
    )
    return np.stack((nose[..., 0, :], tip, nose[..., 1, :]), axis=-2)


def ellipse(
    centre: Float[Array, "2"], cov: Float[Array, "2 2"], sigmas: float = 1.0
) -> Float[Array, "p 2"]:
    """Points of the ellipse of `sigmas` standard deviations around a place."""
    values, vectors = np.linalg.eigh(cov)
    return centre + sigmas * UNIT_CIRCLE * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
