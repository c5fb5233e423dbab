"""Which pieces of the scenery may be seen, or may hide a car, told before their meshes are made."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from mot_sim.simulation.scenery.placing import Item
from tracker.geometry import transform, wrap_angle
from tracker.types import Camera, Cuboids

MAX_HEIGHT_METRES = 20.0  # of anything beside a road: houses reach 17 m, trees as far
MAX_DEPTH_METRES = 3.0  # below the ground: the tufts of a bush
# How far things reach beyond their bases: a tree's tufts, a lamp's arm, a roof.
MAX_OVERHANG_METRES = 6.0
HOUSE_OVERHANG_METRES = 0.6  # of roofs beyond the walls, to both sides of a corner
SPARE_PIXELS = 4.0  # the truth looks a pixel around a car
SPARE_METRES = 0.5  # around a car
SIDEWAYS = 1.57  # radians: farther to the side nothing is in any image


@dataclass(frozen=True, eq=False)
class Spheres:
    """Where things are before the camera, one row each."""

    centres_cam: Float[Array, "m 3"]
    """Centres in camera coordinates, metres."""
    radii: Float[Array, " m"]
    """Metres, that hold all of each thing."""

    @classmethod
    def of(cls, cuboids: Cuboids, camera: Camera) -> "Spheres":
        """Around cars, about the middle of their bottom faces."""
        length, height, width = cuboids.size.T
        radii = np.sqrt((0.5 * length) ** 2 + height**2 + (0.5 * width) ** 2) + SPARE_METRES
        return cls(transform(camera.T_cam_road, cuboids.base), radii)


def boxes_of_things(
    groups: Sequence[Sequence[Item]], overhang: float = MAX_OVERHANG_METRES
) -> Float[Array, "n 8 3"]:
    """The corners, in world, of upright boxes, each of which holds all of one or more things.

    overhang: how far they reach beyond their bases, metres.
    """
    bases = [item.base for items in groups for item in items]
    if not bases:
        return np.zeros((0, 8, 3))
    ends = np.cumsum([sum(len(item.base) for item in items) for items in groups])
    points, starts = np.concatenate(bases), np.append(0, ends[:-1])
    low = np.minimum.reduceat(points, starts) - overhang
    high = np.maximum.reduceat(points, starts) + overhang
    depths = np.full((2, len(groups), 1), [[[-MAX_HEIGHT_METRES]], [[MAX_DEPTH_METRES]]])
    corners = np.concatenate((np.stack((low, high)), depths), axis=2)
    pick = np.indices((2, 2, 2)).reshape(3, 8).T
    return corners[pick, :, np.arange(3)].transpose(2, 0, 1)


def may_be_seen(
    boxes_world: Float[Array, "n 8 3"],
    T_cam_world: Float[Array, "4 4"],
    camera: Camera,
    near: float,
    behind: Spheres | None = None,
) -> Bool[Array, " n"]:
    """Which boxes may be seen in the image; behind: of these, which may hide one of some things.

    Boxes are judged by their columns in the image and their depth alone; some pass in vain.
    """
    corners = transform(T_cam_world, boxes_world.reshape(-1, 3)).reshape(-1, 8, 3)
    is_ahead = corners[..., 2].max(axis=1) > near
    if camera.K[0, 1] != 0.0:  # columns then depend on the height, too
        return is_ahead
    middle = corners.mean(axis=1)
    bearing = np.arctan2(middle[:, 0], middle[:, 2])
    off = np.asarray(wrap_angle(np.arctan2(corners[..., 0], corners[..., 2]) - bearing[:, None]))
    reach = np.hypot(*(corners - middle[:, None])[..., [0, 2]].T).max(axis=0)
    is_around = np.hypot(middle[:, 0], middle[:, 2]) <= reach
    first, last = _columns(bearing + off.min(axis=1), bearing + off.max(axis=1), is_around, camera)
    width = float(camera.image_size[0])
    seen = is_ahead & (first < width + SPARE_PIXELS) & (last > -SPARE_PIXELS)
    if behind is None:
        return seen
    x, _, z = behind.centres_cam.T
    far = np.hypot(x, z)
    inside = far <= behind.radii
    half = np.arcsin(np.minimum(behind.radii / np.maximum(far, 1e-9), 1.0))
    bearing = np.arctan2(x, z)
    left, right = _columns(bearing - half, bearing + half, inside, camera)
    left, right = np.maximum(left, 0.0) - SPARE_PIXELS, np.minimum(right, width) + SPARE_PIXELS
    farthest = z + behind.radii
    meets = (first[:, None] < right) & (last[:, None] > left)
    meets &= (left < right) & (farthest > near)
    meets &= corners[..., 2].min(axis=1)[:, None] < farthest
    return seen & meets.any(axis=1)


def _columns(
    first: Float[Array, " k"],
    last: Float[Array, " k"],
    is_everywhere: Bool[Array, " k"],
    camera: Camera,
) -> tuple[Float[Array, " k"], Float[Array, " k"]]:
    """The columns of the image between two bearings, radians to the right of the optical axis."""
    ends = np.where(is_everywhere, -SIDEWAYS, first), np.where(is_everywhere, SIDEWAYS, last)
    tangents = (np.tan(end.clip(-SIDEWAYS, SIDEWAYS)) for end in ends)
    left, right = (camera.K[0, 0] * tangent + camera.K[0, 2] for tangent in tangents)
    return left, right
