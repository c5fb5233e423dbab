"""The embedded renderer: OpenCV fills triangles, everything else is a look-up by triangle."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers.filling import Filler, KernelFiller
from mot_sim.simulation.renderers.ground import horizon, road_rgba, road_semantics, sky_image
from mot_sim.simulation.renderers.materials import Materials
from mot_sim.simulation.renderers.shadows import closed_mask, light_left, shadow_mask
from mot_sim.simulation.renderers.skins import GLOSS, Skins, glyphs, marked
from mot_sim.simulation.renderers.surroundings import Sun
from mot_sim.simulation.renderers.triangles import NEAR_METRES, Triangles
from mot_sim.simulation.renderers.view import NO_INSTANCE, Rendered, Semantic, View
from tracker.errors import BadConfig
from tracker.kernels import Kernel
from tracker.types import Camera

PAINT_TRIANGLES = Kernel("mot_sim.simulation.kernels.shading", "paint_triangles")
LAY_GROUND = Kernel("mot_sim.simulation.kernels.backdrop", "lay_ground")
SMOOTH_EDGES = Kernel("mot_sim.simulation.kernels.shading", "smooth_edges")
LIGHT_SKINS = Kernel("mot_sim.simulation.kernels.skins", "light_skins")
LAY_OVER = Kernel("mot_sim.simulation.kernels.shading", "lay_over")

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
        rendered = self.backdrop(view)
        if len(triangles):
            _lay(rendered, view, triangles, self.filler, self.antialias)
        return rendered

    def backdrop(self, view: View) -> Rendered:
        """The view without its objects, but with their shadows."""
        camera, road = view.camera, view.road
        image = sky_image(camera, view.sky)
        instances = np.full(image.shape[:2], NO_INSTANCE, np.int32)
        if road is None:
            depth = np.full(image.shape[:2], np.inf, np.float32)
            nothing = np.zeros(image.shape[:2], np.uint8)
            return Rendered(image, depth, instances, nothing, view.instances.unlit)
        seen = horizon(camera)
        rgba = road_rgba(camera, road)
        semantics = np.full(image.shape[:2], Semantic.SKY, np.uint8)
        dark = closed = np.zeros(image.shape[:2], np.uint8)
        if self.shadows and len(view.instances) and len(rgba):
            dark = shadow_mask(view, self.near)
            closed = closed_mask(view, self.near, seen.first)
        ids = int(Semantic.ROAD), int(Semantic.GROUND)
        left = light_left(view.sun.shade)
        LAY_GROUND(rgba, seen.below, dark, closed, left, seen.first, *ids, image, semantics)
        if not road.finer:  # whose alpha is that of a plain picture: the border is exact
            semantics = road_semantics(camera, road)
        unlit = view.instances.unlit
        return Rendered(image, seen.depth.copy(), instances, semantics, unlit)


class SmoothRenderer(RasterRenderer):
    """`raster` with smooth edges of objects."""

    def __init__(self, near: float = NEAR_METRES, shadows: bool = True) -> None:
        super().__init__(near, shadows, antialias=True)


def _lay(
    rendered: Rendered, view: View, triangles: Triangles, filler: Filler, antialias: bool
) -> None:
    """Lay the objects over the backdrop, in place."""
    materials = Materials.of(view, triangles)
    fragments, shown = materials.fill(triangles, view, filler)
    seen, samples, behind = shown.numbers, None, rendered.image
    if antialias:
        samples, behind = filler.fill(triangles, with_four_samples(view.camera)), behind.copy()
        seen = np.concatenate((seen.ravel(), samples.numbers.ravel()))[None]
    seen = marked(triangles, seen)
    painted = paint(view, triangles, materials.codes, seen)
    skins = Skins.of(view, triangles, seen)
    own = skins.slots, skins.skins, skins.objects, skins.places, skins.light
    tables = diffuse_light(view.sun), GLOSS, skins.mirror, skins.cover, glyphs()
    ids = view.instances.ids[triangles.objects].astype(np.int32)
    layers = rendered.image, rendered.depth, rendered.instances, rendered.semantics
    LAY_OVER(
        fragments.numbers, fragments.nearness, shown.numbers, materials.codes, painted, ids, *layers
    )
    LIGHT_SKINS(shown.numbers, shown.nearness, 1.0, 0.0, *own, *tables, rendered.image)
    materials.texture(triangles, shown, painted, rendered.image)
    if samples is not None:
        lit = np.empty((*samples.numbers.shape, 3), np.uint8)
        LIGHT_SKINS(samples.numbers, samples.nearness, 0.5, -0.25, *own, *tables, lit)
        mixed = painted, skins.slots, lit, behind, rendered.image
        SMOOTH_EDGES(samples.numbers, skins.objects, *mixed)


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


def diffuse_light(sun: Sun) -> Float[Array, "256 4"]:
    """How much of their colours faces have in the sun (Lambert's law) and the sky's light.

    By semantic id: what they have anyway, what is added by the cosine to the zenith, and by that
    to the sun, and whether light goes through.
    """
    # A level face has exactly its own colour, as the road's texture has.
    level = sun.ambient + (1.0 - sun.ambient) * max(-float(sun.direction[1]), 0.0)
    sky, road = 0.5 * (1.0 + ROAD_LIGHT_SHARE), 0.5 * (1.0 - ROAD_LIGHT_SHARE)
    light = np.zeros((256, 4))
    light[:, :3] = np.array([sun.ambient * sky, sun.ambient * road, 1.0 - sun.ambient]) / level
    light[Semantic.VEGETATION, 3] = 1.0
    return light
