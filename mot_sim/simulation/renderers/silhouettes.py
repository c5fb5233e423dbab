"""What is seen of each instance, of how much, and what hides the rest: every object drawn alone."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, Int32
from numpy import ndarray as Array

from mot_sim.simulation.renderers.filling import Canvas, depth_of, near_far
from mot_sim.simulation.renderers.triangles import (
    NEAR_METRES,
    NO_BOX,
    Triangles,
    boxes_inside,
    enclose,
)
from mot_sim.simulation.renderers.view import NO_INSTANCE, View
from tracker.types import Camera, Rows

PixelBox = tuple[int, int, int, int]


@dataclass(frozen=True, eq=False)
class Layer:
    """One instance drawn alone, in its own crop of the image."""

    instance: int
    """Its id; NO_INSTANCE for all scenery together."""
    box: PixelBox
    """First column and row, last column and row plus one, of the crop in the image."""
    nearness: Float32[Array, "r c"]
    """How near it is at each pixel, see `Scan.metres`; 0 where it is not."""


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

    Scenery that can hide nothing is not in here.
    """

    silhouettes: Silhouettes
    """What is seen of each instance."""
    hidden: Hidden
    """Who hides whom."""
    layers: tuple[Layer, ...]
    """All that is drawn inside the image: scenery first, in one, then instances by ascending id."""
    numbers: Int32[Array, "h w"]
    """1 + id of the nearest instance; 0: none or scenery."""
    nearness: Float32[Array, "h w"]
    """Of the nearest object, see `metres`; 0: none."""
    range_: tuple[float, float]
    """Depths of nearness 1 and 0, metres."""

    @property
    def instances(self) -> Int32[Array, "h w"]:
        """As in a `Rendered` of `raster`."""
        return self.numbers + np.int32(NO_INSTANCE)

    @property
    def depth(self) -> Float32[Array, "h w"]:
        """Metres along the optical axis to the nearest object, inf = none."""
        return self.metres(self.nearness)

    def metres(self, nearness: Float32[Array, "*s"]) -> Float32[Array, "*s"]:
        """The depth of what stands in `nearness`: from 1, just before the nearest, to 0, inf."""
        depth = depth_of(1.0 - nearness, self.range_)
        return np.where(nearness > 0.0, depth, np.float32(np.inf))


def scan_view(view: View, near: float = NEAR_METRES) -> Scan:
    """Draw every instance alone and lay them over one another: exact counts, boxes, occluders.

    Of the scenery only what may hide an instance is drawn.
    """
    triangles = Triangles.of(view.instances, view.camera, near)
    owners = view.instances.ids
    every = np.unique(owners[owners != NO_INSTANCE])
    amodal_boxes, clipped_boxes, farthest = extents(triangles, view.camera, owners, every)
    scenery = triangles.of_objects(np.flatnonzero(owners == NO_INSTANCE))
    scenery, over = hiders(scenery, view.camera, clipped_boxes, farthest)
    canvas, range_ = Canvas(view.camera), near_far(triangles)
    width, height = view.camera.image_size
    # (Zeros cost nothing where nothing is drawn: the system hands out empty pages.)
    numbers = np.zeros((height, width), np.int32)
    nearest = np.zeros((height, width), np.float32)
    layers: list[Layer] = []
    boxes = pixel_boxes(np.concatenate((over, clipped_boxes)), view.camera)
    for number, box in zip([NO_INSTANCE, *every.tolist()], boxes, strict=True):
        left, top, right, bottom = box
        if left < right and top < bottom:
            mine = scenery
            if number != NO_INSTANCE:
                mine = triangles.of_objects(np.flatnonzero(owners == number))
            alone = 1.0 - canvas.draw_alone(mine, box, range_)
            crop = nearest[top:bottom, left:right]
            np.copyto(numbers[top:bottom, left:right], number - NO_INSTANCE, where=alone > crop)
            np.maximum(alone, crop, out=crop)
            layers.append(Layer(number, box, alone))
    counted, hidden = _measured(every, layers, numbers)
    silhouettes = Silhouettes(every, *counted, amodal_boxes, clipped_boxes)
    return Scan(silhouettes, hidden, tuple(layers), numbers, nearest, range_)


def silhouettes(view: View, near: float = NEAR_METRES) -> Silhouettes:
    """The silhouettes of a view's instances. Visible is at most whole."""
    return scan_view(view, near).silhouettes


def _measured(
    every: Int[Array, " k"], layers: list[Layer], numbers: Int32[Array, "h w"]
) -> tuple[tuple[Int[Array, " k"], Int[Array, " k"], Float[Array, "k 4"]], Hidden]:
    """Visible and whole counts, visible boxes and occluders of everything that was drawn alone."""
    visible, whole = np.zeros(len(every), np.int64), np.zeros(len(every), np.int64)
    visible_boxes = np.tile(NO_BOX, (len(every), 1))
    hiding: list[tuple[int, int, int]] = []
    for layer in layers:
        (left, top, right, bottom), number = layer.box, layer.instance
        if number == NO_INSTANCE:
            continue
        row = int(np.searchsorted(every, number))
        silhouette, shown = layer.nearness > 0.0, numbers[top:bottom, left:right]
        mine = shown == number - NO_INSTANCE
        whole[row], visible[row] = np.count_nonzero(silhouette), np.count_nonzero(mine)
        visible_boxes[row] = box_around(mine) + (left, top, left, top)
        if visible[row] < whole[row]:
            others, pixels = np.unique(shown[silhouette & ~mine], return_counts=True)
            hiding += [
                (number, other + NO_INSTANCE, count)
                for other, count in zip(others.tolist(), pixels.tolist(), strict=True)
            ]
    columns = np.array(hiding, dtype=np.int64).reshape(-1, 3).T
    return (visible, whole, visible_boxes), Hidden(*columns)


def extents(
    triangles: Triangles, camera: Camera, owners: Int[Array, " n"], ids: Int[Array, " m"]
) -> tuple[Float[Array, "m 4"], Float[Array, "m 4"], Float[Array, " m"]]:
    """Boxes around each instance's triangles, and around their parts inside the image, pixels.

    And their largest depth, metres. Inverted, and -inf, without a triangle.
    """
    boxes, clipped = np.tile(NO_BOX, (len(ids), 1)), np.tile(NO_BOX, (len(ids), 1))
    farthest = np.full(len(ids), -np.inf)
    starts = np.flatnonzero(np.diff(triangles.objects, prepend=-1))
    if len(starts):
        points = triangles.corners.reshape(-1, 3)
        pixels = projected(points, camera)
        rows = np.searchsorted(ids, owners[triangles.objects[starts]])
        known = np.flatnonzero(owners[triangles.objects[starts]] != NO_INSTANCE)
        around = np.concatenate(
            (np.minimum.reduceat(pixels, 3 * starts), np.maximum.reduceat(pixels, 3 * starts)),
            axis=1,
        )
        deep = np.maximum.reduceat(points[:, 2], 3 * starts)
        enclose(boxes, rows[known], around[known])
        np.maximum.at(farthest, rows[known], deep[known])
        cut = np.zeros(len(starts), bool)
        cut[known] = (camera.clip_boxes(around[known]) != around[known]).any(axis=1)
        if cut.any():
            counts = np.diff(starts, append=len(triangles))
            chosen = np.flatnonzero(np.repeat(cut, counts))
            inside = boxes_inside(pixels.reshape(-1, 3, 2)[chosen], camera.far_corner[2:])
            begin = np.cumsum(counts[cut]) - counts[cut]
            around[cut, :2] = np.minimum.reduceat(inside[:, :2], begin)
            around[cut, 2:] = np.maximum.reduceat(inside[:, 2:], begin)
        enclose(clipped, rows[known], around[known])
    return boxes, clipped, farthest


def hiders(
    triangles: Triangles, camera: Camera, boxes: Float[Array, "m 4"], farthest: Float[Array, " m"]
) -> tuple[Triangles, Float[Array, "1 4"]]:
    """The triangles that may hide something in some boxes, up to some depths; their own box."""
    a, b, c = projected(triangles.corners.reshape(-1, 3), camera).reshape(-1, 3, 2).swapaxes(0, 1)
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    nearest = triangles.corners[..., 2].min(axis=1, initial=np.inf)
    deep = np.flatnonzero(np.isfinite(farthest))
    around = np.concatenate(
        (boxes[deep, :2].min(axis=0, initial=np.inf), boxes[deep, 2:].max(axis=0, initial=-np.inf))
    )
    rows = np.flatnonzero(_over(low, high, around) & (nearest < farthest.max(initial=-np.inf)))
    low, high, nearest = low[rows], high[rows], nearest[rows]
    may = np.zeros(len(rows), bool)
    for car in deep.tolist():
        may |= _over(low, high, boxes[car]) & (nearest < farthest[car])
    extent = low[may].min(axis=0, initial=np.inf), high[may].max(axis=0, initial=-np.inf)
    keep = np.zeros(len(triangles), bool)
    keep[rows[may]] = True
    return triangles.select(keep), np.concatenate(extent)[None]


def _over(
    low: Float[Array, "t 2"], high: Float[Array, "t 2"], box: Float[Array, "4"]
) -> Bool[Array, " t"]:
    """Which upright boxes come within a pixel of another one."""
    left, top, right, bottom = box.tolist()
    across = (low[:, 0] < right + 1.0) & (high[:, 0] > left - 1.0)
    return across & (low[:, 1] < bottom + 1.0) & (high[:, 1] > top - 1.0)


def projected(points: Float[Array, "p 3"], camera: Camera) -> Float[Array, "p 2"]:
    """Pixels of points before the camera."""
    pixels = points @ camera.K[:2].T
    pixels /= points[:, 2:]
    return pixels


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
