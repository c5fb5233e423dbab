"""The embedded renderer: OpenCV fills triangles, everything else is a look-up by triangle."""

import cv2
import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers.filling import Canvas, Fragments
from mot_sim.simulation.renderers.ground import horizon, road_rgba, road_semantics, sky_image
from mot_sim.simulation.renderers.shadows import shadow_mask
from mot_sim.simulation.renderers.surroundings import Sun
from mot_sim.simulation.renderers.triangles import NEAR_METRES, Triangles
from mot_sim.simulation.renderers.view import NO_INSTANCE, Rendered, Semantic, View
from tracker.errors import BadConfig

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


def specular_light(
    semantics: UInt8[Array, " k"],
    points: Float[Array, "k 3"],
    normals: Float[Array, "k 3"],
    up: Float[Array, "3"],
    sun: Float[Array, "3"],
    bright: float,
) -> Float[Array, "k 3"]:
    """The light that faces at points mirror into the camera, to be added.

    All in the camera's frame: up and the direction to the sun, unit vectors. bright: of the sun,
    0 to 1.
    """
    straight, flat, narrow = SHINE[semantics].T
    distance = np.sqrt(np.einsum("ki,ki->k", points, points))
    towards = (-np.einsum("ki,ki->k", normals, points) / distance).clip(0.0, 1.0)
    # What is mirrored comes from 2 (n . v) n - v, with v = -point / distance to the eye.
    axes = np.stack((up, sun), axis=1)
    to_up, to_sun = (
        2.0 * towards[:, None] * (normals @ axes) + points @ axes / distance[:, None]
    ).T
    sky = GROUND_LIGHT_SHARE + (1.0 - GROUND_LIGHT_SHARE) * np.clip(2.0 * to_up + 0.35, 0.0, 1.0)
    share = straight + flat * (1.0 - towards) ** 4
    glint = np.where(narrow > 0.0, np.maximum(to_sun, 1e-3) ** narrow, 0.0)
    return (share * sky)[:, None] * SKY_COLOUR + (SUN_GLINT_LEVELS * bright * glint)[:, None]


class RasterRenderer:
    """Draws on one core without OpenGL; the same view gives the same bytes.

    near: metres before the camera; what is nearer is cut off. shadows: on the road.
    """

    def __init__(self, near: float = NEAR_METRES, shadows: bool = True) -> None:
        if not (np.isfinite(near) and near > 0.0):
            raise BadConfig(
                f"near plane at {near:g} m: it must lie before the camera, e.g. {NEAR_METRES}"
            )
        self.near = near
        self.shadows = shadows

    def render(self, view: View) -> Rendered:
        """The frame of a view; its arrays are the caller's own."""
        triangles = Triangles.of(view.instances, view.camera, self.near)
        fragments = Canvas(view.camera).fill(triangles)
        rendered = self.backdrop(view)
        if len(fragments.numbers):
            _lay(rendered, fragments, view, triangles)
        return rendered

    def backdrop(self, view: View) -> Rendered:
        """The view without its objects, but with their shadows."""
        camera, road = view.camera, view.road
        image = sky_image(camera, view.sky)
        instances = np.full(image.shape[:2], NO_INSTANCE, np.int32)
        if road is None:
            depth = np.full(image.shape[:2], np.inf, np.float32)
            return Rendered(image, depth, instances, np.zeros(image.shape[:2], np.uint8))
        seen = horizon(camera)
        rgba = road_rgba(camera, road)
        ground = cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB) if len(rgba) else rgba[..., :3]
        if self.shadows and len(view.instances) and len(ground):
            ground = shade_image(ground, shadow_mask(view, self.near)[seen.first :], view.sun.shade)
        cv2.copyTo(ground, seen.below[seen.first :], image[seen.first :])
        return Rendered(image, seen.depth.copy(), instances, road_semantics(camera, road, rgba))


def shade_image(
    image: UInt8[Array, "h w 3"], mask: UInt8[Array, "h w"], shade: float
) -> UInt8[Array, "h w 3"]:
    """The image with less light: all of `shade` is taken where the mask is 255."""
    left = cv2.convertScaleAbs(mask, alpha=-shade, beta=255.0)
    return cv2.multiply(image, cv2.merge((left, left, left)), scale=1.0 / 255.0)


def _lay(rendered: Rendered, fragments: Fragments, view: View, triangles: Triangles) -> None:
    """Lay the objects over the backdrop, in place: look-ups by triangle."""
    numbers = fragments.numbers
    shown = np.zeros(len(triangles) + 1, bool)
    shown[numbers.ravel()] = True
    shown[0] = False
    seen = np.flatnonzero(shown)
    codes, instances = (
        np.zeros((len(shown), 4), np.uint8),
        np.full(len(shown), NO_INSTANCE, np.int32),
    )
    codes[seen] = paints(view, triangles.at(seen - 1))
    instances[seen] = view.instances.ids[triangles.objects[seen - 1]]
    rows = slice(fragments.top, fragments.top + len(numbers))
    covered = (numbers > 0).view(np.uint8)
    rgbs = np.take(codes.view(np.uint32)[:, 0], numbers).view(np.uint8).reshape(*numbers.shape, 4)
    cv2.copyTo(cv2.cvtColor(rgbs, cv2.COLOR_RGBA2RGB), covered, rendered.image[rows])
    cv2.copyTo(cv2.extractChannel(rgbs, 3), covered, rendered.semantics[rows])
    cv2.copyTo(fragments.depth, covered, rendered.depth[rows])
    np.take(instances, numbers, out=rendered.instances[rows], mode="clip")


def paints(view: View, triangles: Triangles) -> UInt8[Array, "k 4"]:
    """The lit colour and the semantic id of triangles."""
    codes = np.zeros((len(triangles), 4), np.uint8)
    for row, (start, end) in enumerate(triangles.slices(len(view.instances)).tolist()):
        if start < end:
            codes[start:end] = view.instances.meshes[row].codes[triangles.faces[start:end]]
    normals, semantics = triangles.normals, codes[:, 3]
    R_cam_road = view.camera.T_cam_road[:3, :3]
    up, sun = -R_cam_road[:, 1], R_cam_road @ view.sun.direction
    colours = codes[:, :3] * strength(semantics, normals @ up, normals @ sun, view.sun)[:, None]
    shiny = np.flatnonzero((semantics == Semantic.CAR) | (semantics == Semantic.GLASS))
    points = triangles.corners[shiny, 0]
    colours[shiny] += specular_light(
        semantics[shiny], points, normals[shiny], up, sun, view.sun.shade
    )
    codes[:, :3] = np.minimum(colours + ROUNDING, 255.0)
    return codes


def strength(
    semantics: UInt8[Array, " k"], up: Float[Array, " k"], towards: Float[Array, " k"], sun: Sun
) -> Float[Array, " k"]:
    """How much of their colours faces have in the sun (Lambert's law) and the sky's light.

    up, towards: cosines of their normals' angles to the zenith and to the sun.
    """
    sky = sun.ambient * (0.5 * (1.0 + ROAD_LIGHT_SHARE) + 0.5 * (1.0 - ROAD_LIGHT_SHARE) * up)
    # Light goes through leaves, and from leaf to leaf.
    leaves = semantics == Semantic.VEGETATION
    direct = np.where(leaves, 0.4 + 0.35 * towards, np.maximum(towards, 0.0))
    # A level face has exactly its own colour, as the road's texture has.
    level = sun.ambient + (1.0 - sun.ambient) * max(-float(sun.direction[1]), 0.0)
    return (sky + (1.0 - sun.ambient) * direct) / level
