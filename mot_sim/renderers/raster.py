"""The embedded renderer: OpenCV fills triangles, everything else is a look-up by triangle."""

import cv2
import numpy as np
from jaxtyping import Float, Int, Int32, UInt8, UInt32
from numpy import ndarray as Array

from mot_sim.renderers.filling import Canvas, Fragments
from mot_sim.renderers.gloss import mirrored
from mot_sim.renderers.ground import horizon, road_rgba, road_semantics, sky_image
from mot_sim.renderers.shadows import shadow_mask
from mot_sim.renderers.surroundings import Sun
from mot_sim.renderers.triangles import NEAR, Triangles
from mot_sim.renderers.view import NOBODY, Mesh, Rendered, Semantic, View
from tracker.errors import BadConfig

BELOW = 0.55  # of the sky's light, what a face that looks down still gets from the road


class RasterRenderer:
    """Draws on one core without OpenGL; the same view gives the same bytes.

    near: metres before the camera; what is nearer is cut off. shadows: on the road.
    """

    def __init__(self, near: float = NEAR, shadows: bool = True) -> None:
        if not (np.isfinite(near) and near > 0.0):
            raise BadConfig(f"near plane at {near:g} m: it must lie before the camera, e.g. {NEAR}")
        self.near = near
        self.shadows = shadows

    def render(self, view: View) -> Rendered:
        """The frame of a view; its arrays are the caller's own."""
        triangles = Triangles.of(view.placed, view.camera, self.near)
        fragments = Canvas(view.camera).fill(triangles)
        rendered = self.backdrop(view)
        if len(fragments.numbers):
            _lay(rendered, fragments, view, triangles)
        return rendered

    def backdrop(self, view: View) -> Rendered:
        """The view without its objects, but with their shadows."""
        camera, road = view.camera, view.road
        image = sky_image(camera, view.sky)
        instances = np.full(image.shape[:2], NOBODY, np.int32)
        if road is None:
            depth = np.full(image.shape[:2], np.inf, np.float32)
            return Rendered(image, depth, instances, np.zeros(image.shape[:2], np.uint8))
        seen = horizon(camera)
        rgba = road_rgba(camera, road)
        ground = cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB) if len(rgba) else rgba[..., :3]
        if self.shadows and len(view.placed) and len(ground):
            ground = darkened(ground, shadow_mask(view, self.near)[seen.first :], view.sun.shade)
        cv2.copyTo(ground, seen.below[seen.first :], image[seen.first :])
        return Rendered(image, seen.depth.copy(), instances, road_semantics(camera, road, rgba))


def darkened(
    image: UInt8[Array, "h w 3"], mask: UInt8[Array, "h w"], shade: float
) -> UInt8[Array, "h w 3"]:
    """The image with less light: all of `shade` is taken where the mask is 255."""
    left = cv2.convertScaleAbs(mask, alpha=-shade, beta=255.0)
    return cv2.multiply(image, cv2.merge((left, left, left)), scale=1.0 / 255.0)


def _lay(rendered: Rendered, fragments: Fragments, view: View, triangles: Triangles) -> None:
    """Lay the objects over the backdrop, in place: a look-up by triangle, four times."""
    colours, semantics, instances = paints(view, triangles)
    numbers = fragments.numbers
    rows = slice(fragments.top, fragments.top + len(numbers))
    covered = (numbers > 0).view(np.uint8)
    rgba = np.take(colours, numbers).view(np.uint8).reshape(*numbers.shape, 4)
    cv2.copyTo(cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB), covered, rendered.image[rows])
    cv2.copyTo(fragments.depth, covered, rendered.depth[rows])
    rendered.instances[rows] = np.take(instances, numbers)
    cv2.copyTo(np.take(semantics, numbers), covered, rendered.semantics[rows])


def paints(
    view: View, triangles: Triangles
) -> tuple[UInt32[Array, " k"], UInt8[Array, " k"], Int32[Array, " k"]]:
    """The lit colour (RGBA in 32 bits), semantic id and instance by triangle number.

    Numbers begin with 1; 0 is no triangle, NOBODY's.
    """
    placed, count = view.placed, len(triangles) + 1
    colours = np.zeros((count, 4), np.uint8)
    semantics = np.zeros(count, np.uint8)
    for row, (start, end) in enumerate((triangles.slices(len(placed)) + 1).tolist()):
        if start < end:
            mesh, faces = placed.meshes[row], triangles.faces[start - 1 : end - 1]
            R_road_object = view.camera.T_road_cam[:3, :3] @ placed.T_cam_object[row, :3, :3]
            lit = lit_colours(mesh, R_road_object, view.sun, faces)
            if mesh.shines:
                T = placed.T_cam_object[row]
                light = mirrored(mesh, R_road_object, -T[:3, :3].T @ T[:3, 3], view.sun, faces)
                lit = np.minimum(lit + light, 255.0).astype(np.uint8)
            colours[start:end, :3] = lit
            semantics[start:end] = mesh.semantics[faces]
    instances = np.full(count, NOBODY, np.int32)
    instances[1:] = placed.instances[triangles.objects]
    return colours.view(np.uint32).ravel(), semantics, instances


def lit_colours(
    mesh: Mesh, R_road_object: Float[Array, "3 3"], sun: Sun, faces: Int[Array, " k"]
) -> UInt8[Array, "k 3"]:
    """The colours of some of a mesh's faces in the sun (Lambert's law) and the sky."""
    up = -R_road_object[1]  # the road's y is down
    light = R_road_object.T @ sun.direction
    towards_sun, upwards = (mesh.normals[faces] @ np.stack((light, up), axis=1)).T
    sky = sun.ambient * (0.5 * (1.0 + BELOW) + 0.5 * (1.0 - BELOW) * upwards)
    direct = np.maximum(towards_sun, 0.0)
    leaves = mesh.semantics[faces] == Semantic.VEGETATION
    if leaves.any():  # light goes through them, and from leaf to leaf
        direct = np.where(leaves, 0.4 + 0.35 * towards_sun, direct)
    strength = sky + (1.0 - sun.ambient) * direct
    # A level face has exactly its own colour, as the road's texture has.
    level = sun.ambient + (1.0 - sun.ambient) * max(-float(sun.direction[1]), 0.0)
    shade = (strength / level).astype(np.float32)[:, None]
    return np.minimum(mesh.colours[faces] * shade, 255.0).astype(np.uint8)
