"""What a frame's skins are lit with: normals between corners, mirrored sky, shadows, patterns."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, Int32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.random_numbers import uniform
from mot_sim.simulation.renderers.surroundings import Colour, Cover, Panorama, Sky
from mot_sim.simulation.renderers.triangles import Triangles
from mot_sim.simulation.renderers.view import MeshInstances, Semantic, View
from tracker.kernels import Kernel
from tracker.types import Camera

PREPARE_SKINS = Kernel("mot_sim.simulation.kernels.skins", "prepare_skins")

SKIN_NUMBERS = 17
PLACE_NUMBERS = 30
ROOM_NUMBERS = 16
GLINT_LEVELS = 230.0  # grey levels of the sun in a face that mirrors it
# By semantic id: the share of light mirrored straight on, the share more at flat angles (Fresnel's
# law for clear coat and glass, by Schlick's approximation), and how narrow the sun's image is: 16,
# 32, 64, ...
GLOSS = np.zeros((256, 3))
GLOSS[Semantic.CAR] = 0.08, 0.85, 64.0
GLOSS[Semantic.GLASS] = 0.07, 0.90, 128.0
GLOSS[Semantic.LIGHT] = 0.05, 0.80, 64.0
# What a car mirrors below the sky: the road, and above it houses and trees in the shade.
ROAD_MIRRORED = (64.0, 64.0, 66.0)
DARK_MIRRORED = (34.0, 38.0, 36.0)
DARK_FROM, DARK_TO, SKY_FROM = -0.10, 0.22, 0.34  # heights of the mirrored ray over the horizon
FAR_SKY = 0.55  # height from which on the sky is the same
LETTERS, DIGITS = "ABCDEFGHKLMNPRSTUVWXZ", "0123456789"
GLYPH_SIZE = (24, 16)  # rows and columns of a character
NO_GLYPH = -1.0
OPEN_COVER = np.zeros((2, 2), np.uint8)


@dataclass(frozen=True, eq=False)
class Skins:
    """All that `kernels.skins.light_skins` takes of a frame."""

    slots: Int32[Array, " t"]
    """Row in `skins` of each triangle; -1: it has one colour."""
    skins: Float[Array, "k 17"]
    """See `kernels.skins.prepare_skins`."""
    objects: Int32[Array, " t"]
    """Row of `MeshInstances` that each triangle belongs to."""
    places: Float[Array, "n 30"]
    """Of each object: T_cam_object's three rows, its marks and the characters on its plates."""
    light: Float[Array, "24"]
    """Directions, strengths and the way into `cover`; see `kernels.skins.light_skins`."""
    mirror: Float32[Array, "256 3"]
    """The squares of the grey levels mirrored, by the height of the ray, from straight down to
    straight up."""
    cover: UInt8[Array, "h w"]
    """The picture of static shadows."""

    @classmethod
    def of(cls, view: View, triangles: Triangles, seen: Bool[Array, " t"]) -> "Skins":
        """The skins of the triangles that are seen."""
        instances, camera = view.instances, view.camera
        slots = np.full(len(triangles), -1, np.int32)
        skins = np.empty((int(seen.sum()), SKIN_NUMBERS))
        Ts = np.ascontiguousarray(instances.T_cam_object, float)
        K_inverse, slot = np.ascontiguousarray(camera.K_inverse, float), 0
        for row, (start, end) in enumerate(triangles.slices(len(instances)).tolist()):
            mesh = instances.meshes[row]
            if start < end and mesh.skin is not None:
                vertices, faces, _, _ = mesh.geometry
                skin, part = mesh.skin, slice(start, end)
                slot = PREPARE_SKINS(
                    vertices, faces, skin.normals, skin.openness, mesh.codes, skin.patterns,
                    Ts[row], K_inverse, slot, triangles.faces[part], seen[part], slots[part], skins,
                )  # fmt: skip
        cover = OPEN_COVER if view.cover is None else view.cover.pixels
        return cls(
            slots,
            skins[:slot],
            triangles.objects.astype(np.int32),
            _places(instances, Ts),
            _light(view),
            mirrored_light(view.sky),
            np.ascontiguousarray(cover),
        )


def room_of(camera: Camera) -> tuple[Float32[Array, "16 w"], Int32[Array, "2 w"]]:
    """Room for a row of pixels, as `kernels.skins.light_skins` takes it."""
    width = camera.image_size[0]
    return np.empty((ROOM_NUMBERS, width), np.float32), np.empty((2, width), np.int32)


def _places(instances: MeshInstances, Ts_cam_object: Float[Array, "n 4 4"]) -> Float[Array, "n 30"]:
    places = np.zeros((len(instances), PLACE_NUMBERS))
    places[:, :12] = Ts_cam_object[:, :3].reshape(-1, 12)
    places[:, 20:29] = NO_GLYPH
    for row, mesh in enumerate(instances.meshes):
        if mesh.skin is not None:
            places[row, 12:20] = mesh.skin.marks
            places[row, 20:29] = plate_of(int(instances.ids[row]))
    return places


def _light(view: View) -> Float[Array, "24"]:
    camera, sun, light = view.camera, view.sun, np.zeros(24)
    R_cam_road, towards = camera.T_cam_road[:3, :3], sun.direction
    light[0:3], light[3:6] = -R_cam_road[:, 1], R_cam_road @ towards
    light[6:9], light[9:11] = camera.K_inverse[0], camera.K_inverse[1, 1:]
    light[11] = GLINT_LEVELS * sun.shade
    if view.cover is not None:
        light[12] = 1.0
        light[13:21] = _way_into(view.cover, camera.T_road_cam, towards).ravel()
    # An axis of the world's, so that what is mirrored stays where it is when the camera turns.
    c, s = np.cos(view.sky.heading), np.sin(view.sky.heading)
    light[21:24] = R_cam_road @ (-s, 0.0, c)
    return light


def _way_into(
    cover: Cover, T_road_cam: Float[Array, "4 4"], towards: Float[Array, "3"]
) -> Float[Array, "2 4"]:
    """From a point of the camera's frame, (x, y, z, 1), to where its shadow's pixel is."""
    A_fall_road = np.zeros((3, 4))
    A_fall_road[0, 0] = A_fall_road[1, 2] = A_fall_road[2, 3] = 1.0
    A_fall_road[:2, 1] = -towards[[0, 2]] / towards[1]
    found: Float[Array, "2 4"] = (cover.A_cover_road @ A_fall_road @ T_road_cam)[:2]
    return found


def mirrored_light(sky: Sky) -> Float32[Array, "256 3"]:
    """The squares of what is mirrored by the height of a ray: road, things in the shade, sky."""
    if sky.panorama is not None:
        return _mirrored_panorama(sky.panorama)
    return _mirrored_fading(sky.low, sky.top)


@lru_cache(maxsize=8)
def _mirrored_fading(low: Colour, top: Colour) -> Float32[Array, "256 3"]:
    return _mirrored(np.array([low, top], float), np.array([0.0, FAR_SKY]))


@lru_cache(maxsize=8)
def _mirrored_panorama(panorama: Panorama) -> Float32[Array, "256 3"]:
    means = panorama.rgba[..., :3].mean(axis=1)[::-1]
    return _mirrored(means, np.linspace(panorama.bottom, panorama.top, len(means)))


def _mirrored(colours: Float[Array, "m 3"], heights: Float[Array, " m"]) -> Float32[Array, "256 3"]:
    """The squared colours of the sky by height, above what hides it."""
    level = np.arange(256) / 127.5 - 1.0
    sky = np.stack([np.interp(level, heights, colours[:, band]) for band in range(3)], axis=1)
    into_dark = np.clip((level - DARK_FROM + 0.1) / 0.1, 0.0, 1.0)[:, None]
    into_sky = np.clip((level - DARK_TO) / (SKY_FROM - DARK_TO), 0.0, 1.0)[:, None]
    below = (1.0 - into_dark) * ROAD_MIRRORED + into_dark * DARK_MIRRORED
    return (np.round(below + into_sky * (sky - below)) ** 2).astype(np.float32)


@lru_cache(maxsize=1)
def glyphs() -> UInt8[Array, "g r c"]:
    """How much ink each character of LETTERS and DIGITS has in each cell, 255 = all."""
    rows, columns = GLYPH_SIZE
    found = []
    for character in LETTERS + DIGITS:
        canvas = np.zeros((4 * rows, 4 * columns), np.uint8)
        cv2.putText(
            canvas, character, (4, 4 * rows - 6), cv2.FONT_HERSHEY_DUPLEX, 2.9, 255, 9, cv2.LINE_AA
        )
        found.append(cv2.resize(canvas, (columns, rows), interpolation=cv2.INTER_AREA))
    return np.stack(found)


@lru_cache(maxsize=4096)
def plate_of(number: int) -> tuple[float, ...]:
    """The nine characters on the plates of a car, by its id: two letters, two, four digits."""
    if number < 0:
        return (NO_GLYPH,) * 9
    draws = uniform(0, "plate", np.array([number]), np.zeros(1, np.int64), 8)[0]
    letters = [float(int(draw * len(LETTERS))) for draw in draws[:4]]
    digits = [float(len(LETTERS) + int(draw * len(DIGITS))) for draw in draws[4:]]
    return (*letters[:2], NO_GLYPH, *letters[2:], *digits)
