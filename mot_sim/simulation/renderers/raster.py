"""The embedded renderer: labels first, then the backdrop where it is seen, then the objects."""

from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers.filling import Filler, Fragments, KernelFiller
from mot_sim.simulation.renderers.ground import (
    horizon,
    plane_depth,
    road_rgba,
    road_semantics,
    sky_image,
)
from mot_sim.simulation.renderers.materials import Materials, Shown
from mot_sim.simulation.renderers.shadows import casters, closed_mask, light_left, shadow_mask
from mot_sim.simulation.renderers.skins import GLOSS, Skins, glyphs, room_of
from mot_sim.simulation.renderers.surroundings import Sun
from mot_sim.simulation.renderers.triangles import NEAR_METRES, Triangles
from mot_sim.simulation.renderers.view import NO_INSTANCE, Rendered, Semantic, View
from tracker.errors import BadConfig
from tracker.kernels import Kernel
from tracker.types import Camera

PAINT_TRIANGLES = Kernel("mot_sim.simulation.kernels.shading", "paint_triangles")
LAY_GROUND = Kernel("mot_sim.simulation.kernels.backdrop", "lay_ground")
KEEP_EDGES = Kernel("mot_sim.simulation.kernels.shading", "keep_edges")
SMOOTH_EDGES = Kernel("mot_sim.simulation.kernels.shading", "smooth_edges")
LIGHT_SKINS = Kernel("mot_sim.simulation.kernels.skins", "light_skins")

SKY_COLOUR = np.array([196.0, 208.0, 220.0])
GROUND_LIGHT_SHARE = 0.3  # of the sky's light, what comes from below the horizon
SUN_GLINT_LEVELS = 120.0  # grey levels of the sun in a face that mirrors it
# By semantic id: the share of light mirrored straight on, the share more at flat angles, and
# how narrow the sun's image is. The first two are near Fresnel's for glass and clear coat.
SHINE = np.zeros((256, 3))
SHINE[Semantic.CAR] = 0.02, 0.5, 18.0
SHINE[Semantic.GLASS] = 0.16, 0.7, 40.0
ROUNDING = 1e-3  # so that 99.99999 is 100
ROAD_LIGHT_SHARE = 0.55  # of the sky's light, what a face that looks down still gets from the road


class RasterRenderer:
    """Draws on one core without OpenGL; the same view gives the same bytes.

    near: metres before the camera; what is nearer is cut off. shadows: on the road. antialias:
    smooth edges of objects in the image, by four samples a pixel; depth and ids stay those of the
    pixels' centres.
    """

    def __init__(
        self, near: float = NEAR_METRES, shadows: bool = True, antialias: bool = False
    ) -> None:
        if not (np.isfinite(near) and near > 0.0):
            raise BadConfig(
                f"near plane at {near:g} m: it must lie before the camera, e.g. {NEAR_METRES}"
            )
        self.near = near
        self.shadows = shadows
        self.antialias = antialias
        self.filler: Filler = KernelFiller()

    def render(self, view: View) -> Rendered:
        """The frame of a view; its arrays are the caller's own."""
        triangles = Triangles.of(view.instances, view.camera, self.near)
        if not len(triangles):
            return self.backdrop(view)
        materials, semantics = Materials.of(view, triangles), _plane_semantics(view)
        depth, instances, shown = materials.lay(triangles, view, self.filler, semantics)
        image = self._painted(view, semantics, shown.numbers, shown.spans)
        rendered = Rendered(image, depth, instances, semantics, view.instances.unlit)
        samples = None
        if self.antialias:
            samples = self.filler.fill(triangles, with_four_samples(view.camera))
        _lay(rendered, view, triangles, materials, shown, samples)
        return rendered

    def backdrop(self, view: View) -> Rendered:
        """The view without its objects, but with their shadows."""
        width, height = view.camera.image_size
        instances = np.full((height, width), NO_INSTANCE, np.int32)
        semantics, nowhere = _plane_semantics(view), np.zeros((height, width), np.int32)
        everywhere = np.tile(np.array([0, width], np.int32), (height, 1))
        image = self._painted(view, semantics, nowhere, everywhere)
        depth = plane_depth(view).copy()
        return Rendered(image, depth, instances, semantics, view.instances.unlit)

    def _painted(
        self,
        view: View,
        semantics: UInt8[Array, "h w"],
        numbers: Int32[Array, "h w"],
        spans: Int32[Array, "h 2"],
    ) -> UInt8[Array, "h w 3"]:
        """The backdrop where numbers are below 1; the road's semantic ids, in place, where 0.

        spans: see `materials.Shown`. With smooth edges the backdrop is all over the image.
        """
        camera, road = view.camera, view.road
        needed = None if self.antialias else spans
        image = sky_image(camera, view.sky, needed)
        if road is None:
            return image
        seen = horizon(camera)
        rgba = road_rgba(camera, road, needed)
        if needed is None:
            spans = np.tile(np.array([0, image.shape[1]], np.int32), (len(image), 1))
        if seen.full < len(image):
            cv2.cvtColor(rgba[seen.full - seen.first :], cv2.COLOR_RGBA2RGB, image[seen.full :])
        dark = closed = np.zeros(image.shape[:2], np.uint8)
        if self.shadows and len(view.instances) and len(rgba):
            rows = casters(view, self.near)
            covered = np.zeros_like(numbers) if self.antialias else numbers
            dark = shadow_mask(view, self.near, rows)
            closed = closed_mask(view, seen.first, rows, covered)
        ids, left = (int(Semantic.ROAD), int(Semantic.GROUND)), light_left(view.sun.shade)
        # Of a plain road the ids are there already, by its exact border.
        kinds = semantics if road.finer else np.empty_like(semantics)
        LAY_GROUND(
            rgba, seen.below, dark, closed, left, seen.first, seen.full, *ids, self.antialias,
            numbers, spans, image, kinds,
        )  # fmt: skip
        return image


class SmoothRenderer(RasterRenderer):
    """`raster` with smooth edges of objects."""

    def __init__(self, near: float = NEAR_METRES, shadows: bool = True) -> None:
        super().__init__(near, shadows, antialias=True)


def _plane_semantics(view: View) -> UInt8[Array, "h w"]:
    """Semantic ids without objects; those of a road with finer levels are not there yet."""
    if view.road is None or view.road.finer:
        return np.full(view.camera.image_size[::-1], Semantic.SKY, np.uint8)
    return road_semantics(view.camera, view.road)


def _lay(
    rendered: Rendered,
    view: View,
    triangles: Triangles,
    materials: Materials,
    shown: Shown,
    samples: Fragments | None,
) -> None:
    """Paint the objects over the backdrop, in place; with four samples a pixel, edges smoothly."""
    if samples is not None:
        edges, behind = np.empty_like(samples.numbers), rendered.image.copy()
        KEEP_EDGES(samples.numbers, materials.objects, shown.seen, edges)
    painted = paint(view, triangles, materials.codes, shown.seen)
    skins = Skins.of(view, triangles, shown.seen)
    own = skins.slots, skins.skins, skins.objects, skins.places, skins.light
    tables = diffuse_light(view.sun), GLOSS, skins.mirror, skins.cover, glyphs()
    materials.paint(triangles, shown, painted, skins.slots, rendered.image)
    room = room_of(view.camera)
    LIGHT_SKINS(shown.numbers, shown.nearness, 1.0, 0.0, *own, *tables, *room, rendered.image)
    if samples is not None:
        lit = np.empty((*edges.shape, 3), np.uint8)
        room = room_of(with_four_samples(view.camera))
        LIGHT_SKINS(edges, samples.nearness, 0.5, -0.25, *own, *tables, *room, lit)
        SMOOTH_EDGES(edges, painted, skins.slots, lit, behind, rendered.image)


@lru_cache(maxsize=8)
def with_four_samples(camera: Camera) -> Camera:
    """The camera with four pixels, a quarter of a pixel aside, in place of each."""
    K = np.diag((2.0, 2.0, 1.0)) @ camera.K
    K[:2, 2] += 0.5
    width, height = camera.image_size
    return replace(camera, K=K, image_size=(2 * width, 2 * height))


def paint(
    view: View, triangles: Triangles, codes: UInt8[Array, "t 4"], seen: Bool[Array, " t"]
) -> UInt8[Array, "t 4"]:
    """The lit colours and semantic ids of triangles; only those that are seen are known."""
    R_cam_road, sun, painted = view.camera.T_cam_road[:3, :3], view.sun, np.empty_like(codes)
    PAINT_TRIANGLES(
        triangles.corners,
        codes,
        seen,
        -R_cam_road[:, 1],
        R_cam_road @ sun.direction,
        diffuse_light(sun),
        SHINE,
        SKY_COLOUR,
        GROUND_LIGHT_SHARE,
        SUN_GLINT_LEVELS * sun.shade,
        ROUNDING,
        painted,
    )
    return painted


def diffuse_light(sun: Sun) -> Float[Array, "3"]:
    """How much of their colours faces have in the sun (Lambert's law) and the sky's light.

    What they have anyway, what is added by the cosine to the zenith, and by that to the sun.
    """
    # A level face has exactly its own colour, as the road's texture has.
    level = sun.ambient + (1.0 - sun.ambient) * max(-float(sun.direction[1]), 0.0)
    sky, road = 0.5 * (1.0 + ROAD_LIGHT_SHARE), 0.5 * (1.0 - ROAD_LIGHT_SHARE)
    return np.array([sun.ambient * sky, sun.ambient * road, 1.0 - sun.ambient]) / level
