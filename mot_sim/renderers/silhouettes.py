"""What is seen of each instance, of how much, and what hides the rest: every object drawn alone."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, Int32
from numpy import ndarray as Array

from mot_sim.renderers.filling import Canvas, depth_of, near_far
from mot_sim.renderers.triangles import NEAR, Triangles
from mot_sim.renderers.view import NOBODY, View
from tracker.types import Camera, Rows

NO_BOX = (np.inf, np.inf, -np.inf, -np.inf)
PixelBox = tuple[int, int, int, int]


@dataclass(frozen=True, eq=False)
class Layer:
    """One instance drawn alone, in its own crop of the image.

    box: first column and row, last ones plus one. nearness: see `Scan.metres`; 0 where it is not.
    """

    instance: int
    box: PixelBox
    nearness: Float32[Array, "r c"]


@dataclass(frozen=True, eq=False)
class Hidden(Rows):
    """Who hides whom: `pixels` of the silhouette of `instances` show `by`, NOBODY = scenery."""

    instances: Int[Array, " m"]
    by: Int[Array, " m"]
    pixels: Int[Array, " m"]


@dataclass(frozen=True, eq=False)
class Silhouettes(Rows):
    """A row for each instance of a view, by ascending id; scenery has none.

    visible: its pixels in the frame. whole: its pixels if it stood there alone. Both inside the
    image. seen_boxes: around the visible pixels' centres; inverted where there are none.
    full_boxes: around its mesh's projection, from the near plane on, not clipped to the image;
    inverted where nothing is in sight.
    """

    instances: Int[Array, " n"]
    visible: Int[Array, " n"]
    whole: Int[Array, " n"]
    seen_boxes: Float[Array, "n 4"]
    full_boxes: Float[Array, "n 4"]

    @property
    def fraction(self) -> Float[Array, " n"]:
        """Visible pixels over the whole silhouette's; 0 where that has none."""
        return self.visible / np.maximum(self.whole, 1)


@dataclass(frozen=True, eq=False)
class Scan:
    """The geometry of a view without its colours: who is where, how far, and what hides whom.

    layers: of everything that is drawn inside the image, by ascending id, all scenery in one.
    numbers: 1 + the id of the nearest instance, 0 = none or scenery. nearness: of the nearest
    object, 0 = none.
    """

    silhouettes: Silhouettes
    hidden: Hidden
    layers: tuple[Layer, ...]
    numbers: Int32[Array, "h w"]
    nearness: Float32[Array, "h w"]
    range_: tuple[float, float]

    @property
    def instances(self) -> Int32[Array, "h w"]:
        """As in a `Rendered` of `raster`."""
        return self.numbers + np.int32(NOBODY)

    @property
    def depth(self) -> Float32[Array, "h w"]:
        """Metres along the optical axis to the nearest object, inf = none."""
        return self.metres(self.nearness)

    def metres(self, nearness: Float32[Array, "*s"]) -> Float32[Array, "*s"]:
        """The depth of what stands in `nearness`: from 1, just before the nearest, to 0, inf."""
        depth = depth_of(1.0 - nearness, self.range_)
        return np.where(nearness > 0.0, depth, np.float32(np.inf))


def scan(view: View, near: float = NEAR) -> Scan:
    """Draw every instance alone and lay them over one another: exact counts, boxes, occluders."""
    triangles = Triangles.of(view.placed, view.camera, near)
    owners = view.placed.instances
    every = np.unique(owners)
    full_boxes = join(object_boxes(triangles, view.camera, len(owners)), owners, every)
    canvas, range_ = Canvas(view.camera), near_far(triangles)
    width, height = view.camera.image_size
    # (Zeros cost nothing where nothing is drawn: the system hands out empty pages.)
    numbers = np.zeros((height, width), np.int32)
    nearest = np.zeros((height, width), np.float32)
    layers: list[Layer] = []
    for number, box in zip(every.tolist(), pixel_boxes(full_boxes, view.camera), strict=True):
        left, top, right, bottom = box
        if left < right and top < bottom:
            mine = triangles.of_objects(np.flatnonzero(owners == number))
            alone = 1.0 - canvas.draw_alone(mine, box, range_)
            crop = nearest[top:bottom, left:right]
            np.copyto(numbers[top:bottom, left:right], number - NOBODY, where=alone > crop)
            np.maximum(alone, crop, out=crop)
            layers.append(Layer(number, box, alone))
    silhouettes, hidden = _measured(every, full_boxes, layers, numbers)
    return Scan(silhouettes, hidden, tuple(layers), numbers, nearest, range_)


def silhouettes(view: View, near: float = NEAR) -> Silhouettes:
    """The silhouettes of a view's instances. Visible is at most whole."""
    return scan(view, near).silhouettes


def _measured(
    every: Int[Array, " k"],
    full_boxes: Float[Array, "k 4"],
    layers: list[Layer],
    numbers: Int32[Array, "h w"],
) -> tuple[Silhouettes, Hidden]:
    """Counts, boxes and occluders of everything that was drawn alone."""
    visible, whole = np.zeros(len(every), np.int64), np.zeros(len(every), np.int64)
    seen_boxes = np.tile(NO_BOX, (len(every), 1))
    hiding: list[tuple[int, int, int]] = []
    for layer in layers:
        (left, top, right, bottom), number = layer.box, layer.instance
        if number == NOBODY:
            continue
        row = int(np.searchsorted(every, number))
        silhouette, shown = layer.nearness > 0.0, numbers[top:bottom, left:right]
        mine = shown == number - NOBODY
        whole[row], visible[row] = np.count_nonzero(silhouette), np.count_nonzero(mine)
        seen_boxes[row] = box_around(mine) + (left, top, left, top)
        if visible[row] < whole[row]:
            others, pixels = np.unique(shown[silhouette & ~mine], return_counts=True)
            hiding += [
                (number, other + NOBODY, count)
                for other, count in zip(others.tolist(), pixels.tolist(), strict=True)
            ]
    known = every != NOBODY
    columns = np.array(hiding, dtype=np.int64).reshape(-1, 3).T
    measured = Silhouettes(every, visible, whole, seen_boxes, full_boxes)
    return measured.select(known), Hidden(*columns)


def object_boxes(triangles: Triangles, camera: Camera, count: int) -> Float[Array, "count 4"]:
    """Upright boxes around each object's triangles, pixels; inverted without a triangle."""
    boxes = np.tile(NO_BOX, (count, 1))
    starts = np.flatnonzero(np.diff(triangles.objects, prepend=-1))
    if len(starts):
        points = triangles.corners.reshape(-1, 3)
        pixels = points @ camera.K[:2].T
        pixels /= points[:, 2:]
        low = np.minimum.reduceat(pixels, 3 * starts)
        high = np.maximum.reduceat(pixels, 3 * starts)
        boxes[triangles.objects[starts]] = np.concatenate((low, high), axis=1)
    return boxes


def join(
    boxes: Float[Array, "n 4"], owners: Int[Array, " n"], ids: Int[Array, " m"]
) -> Float[Array, "m 4"]:
    """The boxes around all objects of each id."""
    joined = np.tile(NO_BOX, (len(ids), 1))
    rows = np.searchsorted(ids, owners)
    np.minimum.at(joined[:, :2], rows, boxes[:, :2])
    np.maximum.at(joined[:, 2:], rows, boxes[:, 2:])
    return joined


def pixel_boxes(boxes: Float[Array, "n 4"], camera: Camera) -> list[PixelBox]:
    """First column and row, last ones plus one, of all pixels a box may touch; in the image."""
    width, height = camera.image_size
    first = np.floor(boxes[:, :2].clip(0.0, (width, height))) - 1
    last = np.ceil(boxes[:, 2:].clip(-1.0, (width, height))) + 2
    low = np.maximum(first, 0).astype(np.int64)
    high = np.minimum(last, (width, height)).astype(np.int64)
    return [(*a, *b) for a, b in zip(low.tolist(), high.tolist(), strict=True)]


def box_around(mask: Bool[Array, "h w"]) -> Float[Array, "4"]:
    """The box around the centres of a mask's pixels; inverted where there are none."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    if not len(rows):
        return np.array(NO_BOX)
    return np.array([columns[0], rows[0], columns[-1], rows[-1]], float)
