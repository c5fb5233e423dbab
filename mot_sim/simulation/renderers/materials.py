"""What scenery is made of, in a frame: gaps in crowns, and patterns on the faces that are seen."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Bool, Float, Float32, Int8, Int32, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.random_numbers import named_stream
from mot_sim.simulation.renderers.filling import Filler
from mot_sim.simulation.renderers.ground import plane_depth
from mot_sim.simulation.renderers.skins import glyphs
from mot_sim.simulation.renderers.triangles import Triangles
from mot_sim.simulation.renderers.view import NO_INSTANCE, Material, View
from tracker.kernels import Kernel

LAY_LABELS = Kernel("mot_sim.simulation.kernels.labels", "lay_labels")
PAINT_FACES = Kernel("mot_sim.simulation.kernels.materials", "paint_faces")

OPEN_SHARE = 108  # of 256 cells between tufts of leaves that one sees through
NOISE_SIZES = (512, 256, 128, 64, 32, 16)  # texels along the sides of the noise's levels
NOISE_SLOPE = 0.8  # by which its amplitude falls with the frequency: as rough from near as from far
TEXELS_A_METRE = 40.0
WALL_NUMBERS = 11  # see `kernels.materials.lay_axes`
TONE_STEPS = 80.0  # of the patterns' whole numbers that are the whole brightness
# Crowns break into cells aslant to all faces.
R_CELL_OBJECT = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


@dataclass(frozen=True, eq=False)
class Shown:
    """What the image shows of triangles: the nearest, and others through the gaps of crowns."""

    numbers: Int32[Array, "h w"]
    """1 + row of the triangle; 0: none, -1: none in a gap."""
    nearness: Float32[Array, "h w"]
    """The inverse of its depth, 1 / m; 0: none."""
    seen: Bool[Array, " t"]
    """Which triangles there are."""
    spans: Int32[Array, "h 2"]
    """Of each row, the first column without a triangle, and the last one plus one."""


@dataclass(frozen=True, eq=False)
class Materials:
    """What a frame's triangles are made of, and the way from pixels into the things' spaces."""

    codes: UInt8[Array, "t 4"]
    """Their own colours and semantic ids."""
    kinds: UInt8[Array, " t"]
    """A `Material` of each triangle."""
    objects: Int32[Array, " t"]
    """Row of `MeshInstances` that each triangle belongs to."""
    Rs_object_cam: Float[Array, "n 3 3"]
    """From the camera's axes to each object's."""
    As_object_ray: Float[Array, "n 3 3"]
    """From a pixel (u, v, 1), times its depth, to the objects' frames, less their eyes."""
    eyes: Float[Array, "n 3"]
    """The camera in the objects' frames, metres."""
    As_cell_ray: Float[Array, "n 3 4"]
    """From a pixel (u, v, 1), times its depth, and 1, to the axes of leaves' cells, metres."""
    pixel: float
    """A pixel's width at a depth of one metre, metres."""

    @classmethod
    def of(cls, view: View, triangles: Triangles) -> "Materials":
        """Those of a view's triangles."""
        codes, kinds = np.empty((len(triangles), 4), np.uint8), np.zeros(len(triangles), np.uint8)
        packed = codes.view(np.uint32)[:, 0]
        for row, (start, end) in enumerate(triangles.slices(len(view.instances)).tolist()):
            if start < end:
                mesh, faces = view.instances.meshes[row], triangles.faces[start:end]
                own = mesh.codes.view(np.uint32)[:, 0]
                np.take(own, faces, out=packed[start:end], mode="clip")
                if mesh.materials is not None:
                    np.take(mesh.materials, faces, out=kinds[start:end], mode="clip")
        T_cam_object = view.instances.T_cam_object
        Rs = np.ascontiguousarray(T_cam_object[:, :3, :3].swapaxes(1, 2), float)
        As, eyes = Rs @ view.camera.K_inverse, -(Rs @ T_cam_object[:, :3, 3:])[..., 0]
        objects = triangles.objects.astype(np.int32)
        pixel = 1.0 / float(view.camera.K[0, 0])
        As, eyes = np.ascontiguousarray(As), np.ascontiguousarray(eyes)
        cells = R_CELL_OBJECT @ np.concatenate((As, eyes[..., None]), axis=2)
        return cls(codes, kinds, objects, Rs, As, eyes, np.ascontiguousarray(cells), pixel)

    def lay(
        self, triangles: Triangles, view: View, filler: Filler, semantics: UInt8[Array, "h w"]
    ) -> tuple[Float32[Array, "h w"], Int32[Array, "h w"], Shown]:
        """Depth and ids of the nearest triangles and of the road plane, and what is shown.

        semantics: ids of the road plane; those of the triangles are laid over them, in place.
        """
        tufts, shape = self.kinds == Material.TUFT, semantics.shape
        nearest, leaves = filler.fill_apart(triangles, view.camera, tufts)
        has_tufts, leaves = leaves is not None, leaves or nearest
        depth, instances = np.empty(shape, np.float32), np.empty(shape, np.int32)
        seen, spans = np.zeros(len(triangles), bool), np.empty((shape[0], 2), np.int32)
        ids = view.instances.ids[triangles.objects].astype(np.int32)
        LAY_LABELS(
            nearest.numbers, nearest.nearness, leaves.numbers, leaves.nearness, plane_depth(view),
            self.codes, self.objects, ids, NO_INSTANCE, self.As_cell_ray, self.pixel, OPEN_SHARE,
            has_tufts, seen, depth, instances, semantics, spans,
            np.empty((2, shape[1])), np.empty(shape[1], np.uint32),
        )  # fmt: skip
        return depth, instances, Shown(nearest.numbers, nearest.nearness, seen, spans)

    def paint(
        self,
        triangles: Triangles,
        shown: Shown,
        painted: UInt8[Array, "t 4"],
        slots: Int32[Array, " t"],
        image: UInt8[Array, "h w 3"],
    ) -> None:
        """Paint what is shown into an image, in place, but for what has a skin's slot, over -1.

        painted: lit colours and semantic ids.
        """
        width = image.shape[1]
        if not (shown.seen & (slots < 0)).any():
            return
        walls, laid = np.empty((len(triangles), WALL_NUMBERS)), np.zeros(len(triangles), bool)
        PAINT_FACES(
            shown.numbers, shown.nearness, triangles.corners, self.codes, painted, self.kinds,
            slots, self.objects, self.Rs_object_cam, self.As_object_ray, self.eyes,
            self.As_cell_ray, self.pixel, patterns(), glyphs(), walls, laid, np.empty((2, width)),
            np.empty((4, width), np.int32), np.empty(width, np.uint32), np.empty(11), image,
        )  # fmt: skip


@cache
def patterns() -> Int8[Array, "m k"]:
    """How much brighter than its mean each material is, of 80 = twice: a row each.

    A row holds periodic pictures of 12.8 m, from texels of 25 mm on, each level the means of the
    one before.
    """
    size = NOISE_SIZES[0]
    noise, streaks = _noise(1.0, 1.0), _noise(1.0, 0.09)
    v, u = np.mgrid[:size, :size] / TEXELS_A_METRE
    walls = {
        Material.PLASTER: 0.06 * _noise(1.0, 1.0, 0.8) + 0.03 * noise + 0.03 * streaks,
        Material.BRICK: _courses(u, v, 0.256, 12.8 / 154, 0.020, 0.5, 0.4)
        + 0.13 * noise + 0.05 * streaks,
        Material.BOARDS: _courses(u, v, 12.8, 12.8 / 68, 0.026, 0.16, -0.4)
        + 0.07 * noise + 0.05 * streaks,
        Material.BLOCKS: _courses(u, v, 0.64, 0.32, 0.026, 0.26, -0.36)
        + 0.09 * noise + 0.05 * streaks,
        Material.TILES: _courses(u, v, 0.256, 0.32, 0.0, 0.3, 0.0) + 0.17 * noise
        + 0.32 * (0.5 - v / 0.32 % 1.0) - 0.2 * (v / 0.32 % 1.0 > 0.8),
        # Curtains, dim rooms, and what stands opposite, mirrored.
        Material.PANE: 0.22 * _noise(1.0, 0.6, 1.5) + 0.5 * (_noise(1.0, 0.3, 1.8) > 0.9),
        Material.BARK: 0.28 * _noise(1.0, 0.2),
    }  # fmt: skip
    rows = np.zeros((max(walls) + 1, sum(side * side for side in NOISE_SIZES)), np.int8)
    for material, tone in walls.items():
        rows[material] = _means(tone - tone.mean())
    return rows


def _means(tone: Float[Array, "s s"]) -> Int8[Array, " k"]:
    """A picture, and its means over 4, 16, ... texels, one after another."""
    levels = []
    for side in NOISE_SIZES:
        step = len(tone) // side
        mean = tone.reshape(side, step, side, step).mean(axis=(1, 3))
        levels.append(np.clip(np.rint(TONE_STEPS * mean), -79, 127).astype(np.int8).ravel())
    return np.concatenate(levels)


def _courses(
    u: Float[Array, "s s"],
    v: Float[Array, "s s"],
    wide: float,
    high: float,
    joint: float,
    spread: float,
    gap: float,
) -> Float[Array, "s s"]:
    """Stones in bond of a size in metres, each with its own tone; joints between them."""
    row = np.floor(v / high + 1e-9).astype(np.int64)
    place = u / wide + 0.5 * (row % 2)
    column = np.floor(place).astype(np.int64) % max(round(12.8 / wide), 1)
    draws = named_stream(0, "stones").uniform(-0.5, 0.5, (int(row.max()) + 1, 64))
    tone: Float[Array, "s s"] = spread * draws[row, column % 64]
    is_joint = ((place % 1.0) * wide < joint) | (v - row * high < joint)
    return np.where(is_joint, gap, tone)


def _noise(across: float, up: float, slope: float = NOISE_SLOPE) -> Float[Array, "s s"]:
    """Periodic noise of unit variance; less than 1 up: drawn out upwards."""
    size = NOISE_SIZES[0]
    spectrum = np.fft.rfft2(named_stream(0, "materials").standard_normal((size, size)))
    v, u = np.fft.fftfreq(size)[:, None] / up, np.fft.rfftfreq(size)[None] / across
    noise = np.fft.irfft2(
        spectrum * np.maximum(np.hypot(u, v), 12.0 / size) ** -slope, (size, size)
    )
    return (noise - noise.mean()) / noise.std()
