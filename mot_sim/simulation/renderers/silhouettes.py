"""What is seen of each instance, of how much, and what hides the rest: every object drawn alone."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Float32, Int, Int32
from numpy import ndarray as Array

from mot_sim.simulation.renderers.filling import SPARE_PIXELS
from mot_sim.simulation.renderers.triangles import NEAR_METRES, NO_BOX, TOLERANCES, Triangles
from mot_sim.simulation.renderers.view import NO_INSTANCE, View
from tracker.kernels import Kernel
from tracker.types import Camera, Rows

EXTENTS = Kernel("mot_sim.simulation.kernels.extents", "extents")
MARK_HIDERS = Kernel("mot_sim.simulation.kernels.extents", "mark_hiders")
DRAW_LAYERS = Kernel("mot_sim.simulation.kernels.layers", "draw_layers")
MEASURE_LAYERS = Kernel("mot_sim.simulation.kernels.layers", "measure_layers")

PixelBox = tuple[int, int, int, int]
AROUND_PIXELS = 3.0  # around all instances: farther out nobody asks for the scenery


@dataclass(frozen=True, eq=False)
class Layer:
    """One instance drawn alone, in its own crop of the image."""

    instance: int
    """Its id; NO_INSTANCE for all scenery together."""
    box: PixelBox
    """First column and row, last column and row plus one, of the crop in the image."""
    nearness: Float32[Array, "r c"]
    """How near it is at each pixel: the inverse of its depth, 1 / m; 0 where it is not."""


@dataclass(frozen=True, eq=False)
class Cutouts:
    """All that is drawn alone, in its own crop of the image, layer by layer."""

    instances: Int[Array, " k"]
    """NO_INSTANCE, for all scenery together, then the instances' ids, ascending."""
    boxes: Int[Array, "k 4"]
    """First column and row, last column and row plus one, of the crops; nothing where inverted."""
    starts: Int[Array, " k"]
    """Where each crop begins in `nearness`."""
    nearness: Float32[Array, " p"]
    """As in `Layer`, of all crops; SPARE_PIXELS at the end mean nothing."""

    @classmethod
    def empty(cls, instances: Int[Array, " k"], boxes: Int[Array, "k 4"]) -> "Cutouts":
        """Cutouts in which nothing is drawn yet."""
        columns, rows = (boxes[:, 2:] - boxes[:, :2]).clip(min=0).T
        ends = np.cumsum(columns * rows)
        starts = ends - columns * rows
        return cls(instances, boxes, starts, np.empty(int(ends[-1]) + SPARE_PIXELS, np.float32))

    def __iter__(self) -> Iterator[Layer]:
        """Those that are inside the image, each by itself."""
        for number, box, start in zip(
            self.instances.tolist(), self.boxes.tolist(), self.starts.tolist(), strict=True
        ):
            left, top, right, bottom = box
            if left < right and top < bottom:
                shape = bottom - top, right - left
                crop = self.nearness[start : start + shape[0] * shape[1]].reshape(shape)
                yield Layer(number, (left, top, right, bottom), crop)


@dataclass(frozen=True, eq=False)
class Hidden(Rows):
    """Who hides whom: one row for each pair of a hidden instance and what hides it."""

    instances: Int[Array, " m"]
    """Id of the hidden instance."""
    occluder_ids: Int[Array, " m"]
    """Id of what hides it; NO_INSTANCE for scenery."""
    pixels: Int[Array, " m"]
    """Pixels of the hidden silhouette that show the occluder."""


@dataclass(frozen=True, eq=False)
class Silhouettes(Rows):
    """One row for each instance of a view, by ascending id; scenery has none."""

    instances: Int[Array, " n"]
    """Id of the instance."""
    visible: Int[Array, " n"]
    """Pixels of it that are seen in the frame."""
    amodal: Int[Array, " n"]
    """Pixels inside the image that it would have if it stood there alone."""
    visible_boxes: Float[Array, "n 4"]
    """Boxes around the visible pixels' centres, pixels; inverted where there are none."""
    amodal_boxes: Float[Array, "n 4"]
    """Boxes around the mesh's projection from the near plane on, pixels, not clipped to the image;
    inverted where nothing is in sight."""
    clipped_boxes: Float[Array, "n 4"]
    """Boxes around the part of that projection inside the image, up to its outer pixels' centres;
    inverted where there is none."""

    @property
    def fraction(self) -> Float[Array, " n"]:
        """Visible pixels over the whole silhouette's; 0 where that has none."""
        return self.visible / np.maximum(self.amodal, 1)


@dataclass(frozen=True, eq=False)
class Scan:
    """The geometry of a view without its colours: who is where, how far, and what hides whom.

    Scenery that can hide nothing is not in here, nor what of it lies beside all instances.
    """

    silhouettes: Silhouettes
    """What is seen of each instance."""
    hidden: Hidden
    """Who hides whom."""
    layers: Cutouts
    """All that is drawn inside the image."""
    numbers: Int32[Array, "h w"]
    """1 + row in `layers` of the nearest; 0: none."""

    @cached_property
    def nearness(self) -> Float32[Array, "h w"]:
        """Of the nearest object, as in `Layer`; 0: none."""
        nearness = np.zeros(self.numbers.shape, np.float32)
        for layer in self.layers:
            left, top, right, bottom = layer.box
            crop = nearness[top:bottom, left:right]
            np.maximum(crop, layer.nearness, out=crop)
        return nearness

    @property
    def instances(self) -> Int32[Array, "h w"]:
        """As in a `Rendered` of `raster`."""
        ids = np.concatenate(([NO_INSTANCE], self.layers.instances)).astype(np.int32)
        return ids[self.numbers]

    @property
    def depth(self) -> Float32[Array, "h w"]:
        """Metres along the optical axis to the nearest object, inf = none."""
        return metres(self.nearness)


def metres(nearness: Float32[Array, "*s"]) -> Float32[Array, "*s"]:
    """The depth of what is so near, 1 / m; inf where nothing is."""
    is_there = nearness > 0.0
    return np.where(is_there, 1.0 / np.where(is_there, nearness, 1.0), np.float32(np.inf))


def scan_view(view: View, near: float = NEAR_METRES) -> Scan:
    """Draw every instance alone and lay them over one another: exact counts, boxes, occluders.

    Of the scenery only what may hide an instance is drawn.
    """
    camera, K = view.camera, np.ascontiguousarray(view.camera.K, float)
    triangles = Triangles.of(view.instances, camera, near)
    owners = view.instances.ids
    every = owners[owners != NO_INSTANCE]
    if not (every[1:] > every[:-1]).all():  # parts of one thing, or cars in no order
        every = np.unique(every)
    layers_of = np.where(owners == NO_INSTANCE, 0, 1 + np.searchsorted(every, owners))
    parts = np.column_stack((layers_of, triangles.slices(len(owners))))
    parts = parts[np.argsort(layers_of, kind="stable")]
    scenery, cars = parts[parts[:, 0] == 0], parts[parts[:, 0] > 0]
    count = 1 + len(every)
    boxes, clipped = np.tile(NO_BOX, (count, 1)), np.tile(NO_BOX, (count, 1))
    farthest, far = np.full(count, -np.inf), camera.far_corner
    corners, pixels = triangles.corners, np.empty((len(triangles), 3, 2))
    EXTENTS(corners, cars, K, far, TOLERANCES, pixels, boxes, clipped, farthest)
    keep, over = np.ones(len(triangles), bool), np.array(NO_BOX)
    MARK_HIDERS(corners, pixels, scenery, clipped, farthest, keep, over)
    seen = clipped[1:]
    clipped[0, :2] = np.maximum(over[:2], seen[:, :2].min(axis=0, initial=np.inf) - AROUND_PIXELS)
    clipped[0, 2:] = np.minimum(over[2:], seen[:, 2:].max(axis=0, initial=-np.inf) + AROUND_PIXELS)
    layers = Cutouts.empty(np.append(NO_INSTANCE, every), pixel_boxes(clipped, camera))
    width, height = camera.image_size
    # (Zeros cost nothing where nothing is drawn: the system hands out empty pages.)
    nearest, numbers = np.zeros((height, width), np.float32), np.zeros((height, width), np.int32)
    crops = layers.boxes, layers.starts, layers.nearness
    DRAW_LAYERS(corners, keep, parts, K, *crops, nearest, numbers)
    counted, hidden = _measured(layers, numbers)
    return Scan(Silhouettes(every, *counted, boxes[1:], seen), hidden, layers, numbers)


def silhouettes(view: View, near: float = NEAR_METRES) -> Silhouettes:
    """The silhouettes of a view's instances. Visible is at most whole."""
    return scan_view(view, near).silhouettes


def _measured(
    layers: Cutouts, numbers: Int32[Array, "h w"]
) -> tuple[tuple[Int[Array, " k"], Int[Array, " k"], Float[Array, "k 4"]], Hidden]:
    """Visible and whole counts, visible boxes and occluders of everything that was drawn alone."""
    count = len(layers.instances)
    visible, whole = np.zeros(count, np.int64), np.zeros(count, np.int64)
    visible_boxes, pixels = np.tile(NO_BOX, (count, 1)), np.zeros((count, count), np.int64)
    crops = layers.nearness, layers.starts, layers.boxes, numbers
    MEASURE_LAYERS(*crops, whole, visible, visible_boxes, pixels)
    rows, others = np.nonzero(pixels)
    hidden = Hidden(layers.instances[rows], layers.instances[others], pixels[rows, others])
    return (visible[1:], whole[1:], visible_boxes[1:]), hidden


def pixel_boxes(boxes: Float[Array, "n 4"], camera: Camera) -> Int[Array, "n 4"]:
    """First column and row, last ones plus one, of all pixels a box may touch; in the image."""
    size = camera.image_size
    first = np.floor(boxes[:, :2].clip(0.0, size)) - 1
    last = np.ceil(boxes[:, 2:].clip(-1.0, size)) + 2
    corners = np.maximum(first, 0), np.minimum(last, size)
    return np.concatenate(corners, axis=1).astype(np.int64)
