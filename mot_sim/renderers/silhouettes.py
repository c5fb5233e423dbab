"""What is seen of each instance, of how much: pixel counts and boxes."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.renderers.filling import Canvas
from mot_sim.renderers.triangles import Triangles
from mot_sim.renderers.view import NOBODY, Rendered, View
from mot_sim.truth import NEAR
from tracker.types import Camera, Rows

NO_BOX = (np.inf, np.inf, -np.inf, -np.inf)


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


def silhouettes(view: View, rendered: Rendered, near: float = NEAR) -> Silhouettes:
    """The silhouettes of a view's instances, for a frame that `raster` drew with that `near`.

    Of a frame of `raster`, visible is at most whole, and equal to it where nothing is in front.
    Instances whose boxes nothing nearer touches are not drawn again: their silhouette is seen.
    """
    triangles = Triangles.of(view.placed, view.camera, near)
    owners = view.placed.instances
    ids = np.unique(owners[owners != NOBODY])
    boxes, depths = object_extents(triangles, view.camera, len(owners))
    full_boxes = join(boxes, owners, ids)
    crops, object_crops = pixel_boxes(full_boxes, view.camera), pixel_boxes(boxes, view.camera)
    canvas = Canvas(view.camera)
    visible, whole = np.zeros(len(ids), np.int64), np.zeros(len(ids), np.int64)
    seen_boxes = np.tile(NO_BOX, (len(ids), 1))
    for row, (left, top, right, bottom) in enumerate(crops.tolist()):
        if left >= right or top >= bottom:
            continue
        mine = rendered.instances[top:bottom, left:right] == ids[row]
        visible[row] = np.count_nonzero(mine)
        seen_boxes[row] = box_around(mine) + (left, top, left, top)
        others = owners != ids[row]
        before = depths[others, 0] < depths[~others, 1].max()
        if touches(crops[row], object_crops[others][before]).any():
            alone = triangles.select(owners[triangles.objects] == ids[row])
            whole[row] = canvas.count(alone, (left, top, right, bottom))
        else:
            whole[row] = visible[row]
    return Silhouettes(ids, visible, whole, seen_boxes, full_boxes)


def object_extents(
    triangles: Triangles, camera: Camera, count: int
) -> tuple[Float[Array, "count 4"], Float[Array, "count 2"]]:
    """Upright boxes around each object's triangles, pixels, and their smallest and largest depth.

    Both are inverted for objects without a triangle.
    """
    boxes, depths = np.tile(NO_BOX, (count, 1)), np.tile(NO_BOX[1:3], (count, 1))
    present, starts = np.unique(triangles.objects, return_index=True)
    if len(present):
        points = triangles.corners.reshape(-1, 3)
        pixels_depth = points @ camera.K.T
        pixels_depth[:, :2] /= points[:, 2:]
        low = np.minimum.reduceat(pixels_depth, 3 * starts)
        high = np.maximum.reduceat(pixels_depth, 3 * starts)
        boxes[present] = np.concatenate((low[:, :2], high[:, :2]), axis=1)
        depths[present] = np.stack((low[:, 2], high[:, 2]), axis=1)
    return boxes, depths


def join(
    boxes: Float[Array, "n 4"], owners: Int[Array, " n"], ids: Int[Array, " m"]
) -> Float[Array, "m 4"]:
    """The boxes around all objects of each id."""
    joined = np.tile(NO_BOX, (len(ids), 1))
    known = owners != NOBODY
    rows = np.searchsorted(ids, owners[known])
    np.minimum.at(joined[:, :2], rows, boxes[known, :2])
    np.maximum.at(joined[:, 2:], rows, boxes[known, 2:])
    return joined


def pixel_boxes(boxes: Float[Array, "n 4"], camera: Camera) -> Int[Array, "n 4"]:
    """First column and row, last ones plus one, of all pixels a box may touch; in the image."""
    width, height = camera.image_size
    first = np.floor(boxes[:, :2].clip(0.0, (width, height))) - 1
    last = np.ceil(boxes[:, 2:].clip(-1.0, (width, height))) + 2
    low = np.maximum(first, 0).astype(np.int64)
    return np.concatenate((low, np.minimum(last, (width, height)).astype(np.int64)), axis=1)


def box_around(mask: Bool[Array, "h w"]) -> Float[Array, "4"]:
    """The box around the centres of a mask's pixels; inverted where there are none."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    if not len(rows):
        return np.array(NO_BOX)
    return np.array([columns[0], rows[0], columns[-1], rows[-1]], float)


def touches(box: Int[Array, "4"], others: Int[Array, "n 4"]) -> Bool[Array, " n"]:
    """Whether pixel boxes share a pixel with one."""
    return np.all((others[:, :2] < box[2:]) & (others[:, 2:] > box[:2]), axis=1)
