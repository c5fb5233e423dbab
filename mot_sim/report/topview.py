"""The scene from above: world x to the right, world y down, as in the world frame."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.report.canvas import Image, fill, line, text, text_width
from mot_sim.report.colours import EGO, GRASS, PAINT, PANEL, Colour, colour_of_id, ink_on, mix
from mot_sim.rig import Rig
from mot_sim.traffic.roads import Roads
from mot_sim.traffic.world import World
from tracker.geometry import transform
from tracker.types import Tracks

DIM = 0.45  # how far the ground's colours go towards the dark panel's
TRUTH: Colour = (245, 245, 245)
Point = Float[Array, "2"]
FAR = 90.0  # metres; a road contact further away is too uncertain to draw


@dataclass(frozen=True, eq=False)
class TopView:
    """A panel of width x height pixels; its upper left corner is the point `origin` (x, y).

    scale: pixels a metre.
    """

    roads: Roads
    origin: tuple[float, float]
    scale: float
    size: tuple[int, int]

    def pixels(self, points: Float[Array, "*n 2"]) -> Float[Array, "*n 2"]:
        """Where points (x, y) of the world lie in the panel."""
        return (points - self.origin) * self.scale

    @cached_property
    def _ground(self) -> Image:
        image = np.empty((self.size[1], self.size[0], 3), np.uint8)
        image[:] = mix(GRASS, PANEL, DIM)
        for surface in self.roads.surfaces:
            fill(image, self.pixels(surface.corners), mix(PAINT[surface.paint], PANEL, DIM))
        return image

    def draw(self, world: World, rig: Rig, trails: Mapping[int, Float[Array, "_ 2"]]) -> Image:
        """The cars' true outlines, our own car with its view, and the trails by track id."""
        image = self._ground.copy()
        self._draw_view(image, world, rig)
        for corners in world.footprint():
            line(image, self.pixels(corners), TRUTH, closed=True)
            nose = np.stack((corners[0], corners[1])) * 0.5 + corners[[0, 1]].mean(axis=0) * 0.5
            line(image, self.pixels(nose), TRUTH, 2)
        fill(image, self.pixels(world.ego_footprint()), EGO)
        for track_id, points in trails.items():
            pixels = self.pixels(points)
            colour = colour_of_id(track_id)
            line(image, pixels, colour, 2)
            fill(image, pixels[-1] + 8.0 * _CIRCLE, colour)
            words, (u, v) = str(track_id), np.round(pixels[-1]).astype(int).tolist()
            text(image, words, (u - text_width(words, 13) // 2, v + 5), ink_on(colour), 13)
        return image

    def _draw_view(self, image: Image, world: World, rig: Rig) -> None:
        """The two edges of what the camera sees."""
        width, _ = rig.camera.image_size
        row = rig.camera.K[1, 2]
        rays = rig.camera.rays(np.array([(0.0, row), (width - 1.0, row)]))
        tips = transform(rig.T_world_cam(world.ego), FAR * rays)[:, :2]
        for tip in tips:
            line(image, self.pixels(np.stack((world.ego[:2], tip))), EGO)


_TURN = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
_CIRCLE = np.stack((np.cos(_TURN), np.sin(_TURN)), axis=1)


def road_contacts(
    tracks: Tracks, rig: Rig, egos: Mapping[int, Float[Array, "3"]]
) -> dict[int, dict[int, Point]]:
    """By id and frame: where the lower edge's middle of a track's box touches the world's road.

    Boxes cut by the lower or lateral borders and far ones tell no such point and are left out.
    """
    width, height = rig.camera.image_size
    boxes = tracks.boxes
    feet = np.stack((0.5 * (boxes[:, 0] + boxes[:, 2]), boxes[:, 3]), axis=1)
    contacts_cam = rig.camera.touch_road(feet)
    inside = (boxes[:, 3] < height - 3.0) & (boxes[:, 0] > 2.0) & (boxes[:, 2] < width - 3.0)
    known = inside & (contacts_cam[:, 2] < FAR)
    contacts: dict[int, dict[int, Point]] = {}
    for row in np.flatnonzero(known).tolist():
        frame = int(tracks.frames[row])
        point = transform(rig.T_world_cam(egos[frame]), contacts_cam[row])[:2]
        contacts.setdefault(int(tracks.ids[row]), {})[frame] = point
    return contacts


def trails_until(
    contacts: Mapping[int, Mapping[int, Point]], frame: int, length: int
) -> dict[int, Float[Array, "_ 2"]]:
    """The last `length` points of the tracks that were placed within the last second.

    Every point is the mean of the contacts within two frames before and after it.
    """
    trails = {}
    for track_id, points in contacts.items():
        recent = [moment for moment in range(frame - length + 1, frame + 1) if moment in points]
        if recent and recent[-1] > frame - 10:
            trails[track_id] = np.array([
                np.mean([points[near] for near in range(m - 2, m + 3) if near in points], axis=0)
                for m in recent
            ])  # fmt: skip
    return trails
