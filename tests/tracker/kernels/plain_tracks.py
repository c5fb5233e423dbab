"""Lifting, ego-motion, gating, suppression and box filter in plain NumPy."""

import math

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.beliefs import (
    BORDER_PIXELS,
    BOTTOM_CENTRE,
    MAX_CONTACT_DEPTH,
    MIN_DEPTH,
    Beliefs,
    Lift,
)
from tracker.box_filter import MAX_INNOVATION, MIN_GAIN, MIN_POWER, BoxFilter, Filtered, Gains
from tracker.costs.gating import MIN_CORNER_DEPTH
from tracker.ego_motion import MIN_SCALE
from tracker.geometry import (
    box_area,
    box_intersection,
    box_iou,
    propagate_covariance,
    road_contact,
)
from tracker.lifecycle import MAX_CONSECUTIVE_STEPS, ActiveTracks
from tracker.suppression import Suppression
from tracker.types import Camera, Cuboids, Detections
from tracker.types.cuboids import CORNERS
from tracker.types.embedding import Embedding
from tracker.types.shape_pose import ShapePose

# Boxes times this are centres and sizes; and back.
TO_CENTRE = np.array(
    [[0.5, 0.0, -1.0, 0.0], [0.0, 0.5, 0.0, -1.0], [0.5, 0.0, 1.0, 0.0], [0.0, 0.5, 0.0, 1.0]]
)
FROM_CENTRE = np.linalg.inv(TO_CENTRE)
# Small, middle and large boxes learn gains of their own.
SIZE_CLASSES = np.arange(3)[:, None]


def road_contact_jacobian(
    rays: Float[Array, "n 3"], contact: Float[Array, "n 3"], d_rays: Float[Array, "3 2"]
) -> Float[Array, "n 2 4"]:
    """Derivatives of a contact's x and z by the pixel's u and v, the camera's height and pitch.

    contact: `road_contact(rays, height)`. d_rays: derivatives of a ray by u and v, R_road_cam
    K^-1 [:, :2]. With X = h r / r_y: dX = h (dr - r / r_y dr_y) / r_y for a pixel and X / h for
    the height. Looking up by d turns the ray by (0, -r_z, r_y) d, which gives (0, h) + X z / h.
    """
    per_height = contact[:, ::2] / contact[:, 1:2]
    jacobian = np.empty((len(rays), 2, 4))
    pixel = d_rays[::2] - per_height[:, :, None] * d_rays[1]
    np.multiply(pixel, (contact[:, 1] / rays[:, 1])[:, None, None], out=jacobian[:, :, :2])
    jacobian[:, :, 2] = per_height
    np.multiply(per_height, contact[:, 2:], out=jacobian[:, :, 3])
    jacobian[:, 1, 3] += contact[:, 1]
    return jacobian


def plain_region(self: Beliefs, sigmas: float) -> Cuboids:
    """The cuboids stretched by `sigmas` standard deviations along and across the car.

    The uncertainty is far longer than wide (it points along the viewing ray): it is taken
    in the car's own axes, so that the region stays a cuboid.
    """
    c, s = np.cos(self.cuboids.yaw), np.sin(self.cuboids.yaw)
    xx, zz = self.cov[:, 0, 0], self.cov[:, 1, 1]
    along = c * (c * xx - 2.0 * s * self.cov[:, 0, 1]) + s * s * zz
    across = xx + zz - along  # a covariance's trace does not turn
    size = self.cuboids.size.copy()
    size[:, 0] += 2.0 * sigmas * np.sqrt(np.maximum(along, 0.0))
    size[:, 2] += 2.0 * sigmas * np.sqrt(np.maximum(across, 0.0))
    return Cuboids(self.cuboids.base, self.cuboids.yaw, size)


def plain_lift(self: Lift, detections: Detections, camera: Camera) -> Beliefs:
    """One belief a detection.

    The bottom centre of the box touches the road at the car's near face (eq. 2); the centre
    lies behind it, on the same ray, by half of the yawed extent. Where the bottom edge is no
    road contact (cut by the lower border, or above the horizon) the depth comes from the
    box's height, at most that of the border, and its std is half of it.
    """
    boxes, n = detections.boxes, len(detections)
    if n == 0:
        return Beliefs.empty()
    yaw, size, behind = self._stance(detections)
    yaw, size = np.broadcast_to(yaw, n), np.broadcast_to(size, (n, 3))
    rays = camera.rays_road(boxes.dot(BOTTOM_CENTRE))
    heights = np.maximum(boxes[:, 3] - boxes[:, 1], 1.0)
    relative_std = self.edge_std * (2.0 - np.minimum(np.maximum(detections.scores, 0.0), 1.0))

    near, cov = _road_contact(self, rays, relative_std * heights, camera)
    near_by_height = camera.K[1, 1] * size[:, 1] / heights
    cut = boxes[:, 3] >= camera.image_size[1] - 1.0 - BORDER_PIXELS
    no_contact = cut | ~(near < MAX_CONTACT_DEPTH)
    if np.count_nonzero(no_contact):
        _place_by_height(near, cov, near_by_height, no_contact, rays)
    if self.use_box_height:
        var = near_by_height**2 * (2.0 * relative_std**2 + self.car_size_std**2)  # two edges
        var[cut] = np.inf
        gain = cov[:, 1] / (cov[:, 1, 1] + var)[:, None]
        near = near + gain[:, 1] * (near_by_height - near)
        cov = cov - gain[:, :, None] * cov[:, None, 1]
    base = rays * (near + behind)[:, None]
    base[:, 1] = rays[:, 1] * near - camera.height
    state_cov = np.tile(np.diag(np.square([0.0, 0.0, *self.speed_std])), (n, 1, 1))
    state_cov[:, :2, :2] = cov
    cuboids, still = Cuboids(base, yaw, size), np.zeros((n, 2))
    cues = ShapePose.of(detections), Embedding.of(detections)
    return Beliefs(cuboids, still, state_cov, boxes, *cues)


def _road_contact(
    self: Lift, rays: Float[Array, "n 3"], sigma: Float[Array, " n"], camera: Camera
) -> tuple[Float[Array, " n"], Float[Array, "n 2 2"]]:
    """Reach along the rays (NaN: none) and covariance on the road's x and z, eq. 2."""
    contact = road_contact(rays, camera.height)
    std = np.empty((len(sigma), 1, 4))
    std[:, 0, :2] = sigma[:, None]
    std[:, 0, 2:] = self.height_std, self.pitch_std
    deviation = std * road_contact_jacobian(rays, contact, camera.A_road_pixel[:, :2])
    return contact[:, 1] / rays[:, 1], deviation @ deviation.transpose(0, 2, 1)


def _place_by_height(
    near: Float[Array, " n"],
    cov: Float[Array, "n 2 2"],
    near_by_height: Float[Array, " n"],
    no_contact: Bool[Array, " n"],
    rays: Float[Array, "n 3"],
) -> None:
    """Overwrite, in the rows without road contact, reach and covariance by the box's height."""
    near[no_contact] = np.clip(
        np.fmin(near[no_contact], near_by_height[no_contact]), MIN_DEPTH, MAX_CONTACT_DEPTH
    )
    along = rays[no_contact, ::2] * (0.5 * near[no_contact])[:, None]
    cov[no_contact] = along[:, :, None] * along[:, None, :] + np.eye(2)


def plain_compensated(
    beliefs: Beliefs,
    camera: Camera,
    T_now_before: Float[Array, "4 4"],
    motion_cov: Float[Array, "6 6"],
    moved: Float[Array, "n 2"] | None = None,
) -> Beliefs:
    """The beliefs in the road frame of now, g(xi, .) of eqs. 3-4, the motion's covariance added.

    `moved` is how far each object itself went meanwhile, in the road frame of before, metres.
    The boxes move by the parallax of the car's near half: exact
    for a turning camera, to first order for a moving one.
    """
    n = len(beliefs)
    if n == 0:
        return beliefs
    base = beliefs.cuboids.base
    if moved is not None:
        base = base.copy()
        base[:, ::2] += moved
    T_road = camera.T_road_cam.dot(T_now_before).dot(camera.T_cam_road)
    turn = math.atan2(T_road[0, 2] - T_road[2, 0], T_road[0, 0] + T_road[2, 2])
    base_now = base.dot(T_road[:3, :3].T) + T_road[:3, 3]
    cuboids = Cuboids(base_now, beliefs.cuboids.yaw + turn, beliefs.cuboids.size)

    R = T_road[:3:2, :3:2]
    R_state = np.zeros((4, 4))
    R_state[:2, :2] = R_state[2:, 2:] = R
    cov = propagate_covariance(R_state, beliefs.cov)
    shift = (base_now.dot(camera.road_shift[:3]) + camera.road_shift[3]).reshape(-1, 6)
    from_motion = shift.dot(motion_cov).reshape(n, 2, 6)
    cov[:, :2, :2] += from_motion @ shift.reshape(n, 2, 6).transpose(0, 2, 1)
    boxes = _move_boxes(beliefs, camera, T_now_before, moved)
    pose = beliefs.shape_pose
    if pose is not None:
        pose = ShapePose(pose.shape, pose.yaw + turn, pose.cov)
    return Beliefs(cuboids, beliefs.velocity.dot(R.T), cov, boxes, pose, beliefs.embedding)


def _move_boxes(
    beliefs: Beliefs,
    camera: Camera,
    T_now_before: Float[Array, "4 4"],
    moved: Float[Array, "n 2"] | None,
) -> Float[Array, "n 4"]:
    """The boxes as fronto-parallel windows at the car's depth, seen from the camera of now."""
    cuboids = beliefs.cuboids
    depth = cuboids.base.dot(camera.T_cam_road[2, :3]) + camera.T_cam_road[2, 3]
    depth = np.maximum(depth - 0.25 * cuboids.size[:, 0], MIN_DEPTH)
    R, t = T_now_before[:3, :3], T_now_before[:3, 3]
    K_R = camera.K.dot(R)
    H = K_R.dot(camera.K_inverse)  # moves pixels at infinity
    shift = camera.K.dot(t)
    if moved is not None:
        shift = shift + moved.dot(K_R.dot(camera.T_cam_road[:3, :3:2]).T)
    corners = (beliefs.boxes.reshape(-1, 2).dot(H[:, :2].T) + H[:, 2]).reshape(-1, 2, 3)
    corners += (shift / depth[:, None])[:, None]
    return (corners[:, :, :2] / np.maximum(corners[:, :, 2:], MIN_SCALE)).reshape(-1, 4)


def plain_correction(expected: Beliefs, observed: Beliefs) -> Beliefs:
    """The Kalman update by the observed position; the box is the observed one.

    The height above the road plane, which no filter follows, is the observed one too.
    """
    cov = expected.cov
    gain = cov[:, :, :2] @ np.linalg.inv(cov[:, :2, :2] + observed.cov[:, :2, :2])
    before, base = expected.cuboids.base[:, ::2], observed.cuboids.base.copy()
    step = (gain @ (base[:, ::2] - before)[:, :, None])[:, :, 0]
    base[:, ::2] = before + step[:, :2]
    cuboids = Cuboids(base, observed.cuboids.yaw, observed.cuboids.size)
    cov = cov - gain @ cov[:, :2]
    velocity, cues = expected.velocity + step[:, 2:], (None, None)
    return Beliefs(cuboids, velocity, cov, observed.boxes, *cues)


def plain_filter(
    self: BoxFilter,
    learned: Gains,
    matched: ActiveTracks,
    boxes: Float[Array, "k 4"],
    dt: float,
    camera: Camera,
) -> Filtered:
    """The filtered boxes of tracks (as predicted) that were detected as `boxes`, pixels."""
    if len(boxes) == 0:
        return Filtered(boxes, boxes, learned)
    expected = matched.beliefs.boxes
    off = (boxes - expected).dot(TO_CENTRE)
    sides = expected[:, 2:] - expected[:, :2]
    shorter = np.minimum(sides[:, 0], sides[:, 1])
    size_class = (shorter > self.sizes[0]) + (shorter > self.sizes[1]).astype(np.int64)
    gain = np.maximum(learned.gains.take(size_class, 0), (1.0 / (matched.hits + 1.0))[:, None])
    unusable = matched.time_since_update > MAX_CONSECUTIVE_STEPS * dt
    if np.count_nonzero(unusable) and dt > 0.0:
        gain = 1.0 - (1.0 - gain) ** (matched.time_since_update / dt)[:, None]
    beyond = boxes[:, :2] < self.border
    beyond |= boxes[:, 2:] > camera.far_corner[:2] - self.border
    cut = beyond[:, 0] | beyond[:, 1]
    if np.count_nonzero(cut):
        gain[cut] = 1.0
        unusable |= cut
    innovations = off / np.maximum(sides[:, 1:], 1.0)
    innovations = np.minimum(np.maximum(innovations, -MAX_INNOVATION), MAX_INNOVATION)
    innovations[unusable] = np.nan
    learned = _learn(self, learned, size_class, matched.innovations, innovations)
    return Filtered(expected + (off * gain).dot(FROM_CENTRE), innovations, learned)


def _learn(
    self: BoxFilter,
    learned: Gains,
    size_class: Int[Array, " k"],
    before: Float[Array, "k 4"],
    now: Float[Array, "k 4"],
) -> Gains:
    """One step towards white innovations: gain + sum of products / sum of squares."""
    usable = np.isfinite(before[:, 0] + now[:, 0]).nonzero()[0]
    if len(usable) == 0:
        return learned
    a, b = before.take(usable, 0), now.take(usable, 0)
    member = (size_class.take(usable) == SIZE_CLASSES).astype(float)
    pairs = learned.pairs + np.add.reduce(member, 1, keepdims=True)
    power = learned.power + member.dot(0.5 * (a * a + b * b))
    worth = power * (1.0 + self.prior / np.maximum(pairs, 1.0)) + MIN_POWER
    gains = learned.gains + member.dot(a * b) / worth
    return Gains(np.minimum(np.maximum(gains, MIN_GAIN), 1.0), pairs, power)


def plain_suppression(self: Suppression, detections: Detections, camera: Camera) -> Detections:
    """What is left, in the given order, in arrays of its own."""
    boxes, scores = detections.boxes, detections.scores
    inside = camera.clip_boxes(boxes)
    kept = (inside[:, 2] > inside[:, 0]) & (inside[:, 3] > inside[:, 1])
    kept &= scores >= self.min_score
    if len(boxes) > 1:
        area = box_area(boxes)
        shared = box_intersection(boxes[:, None], boxes[None])
        limit: float | Array = self.max_iou
        if self.max_iou_of_sure is not None:
            sure = (scores >= self.sure_score) | (scores[:, None] == scores)  # the weaker one
            limit = np.where(sure, self.max_iou_of_sure, self.max_iou)
        # IoU > t, that is shared > t (both - shared)
        close = (1.0 + limit) * shared > limit * (area[:, None] + area)
        close.ravel()[:: len(boxes) + 1] = False  # each box with itself
        if np.count_nonzero(close):
            for row in np.argsort(-scores, kind="stable"):
                if kept[row]:
                    kept &= ~close[row]
    return detections.select(kept)


def plain_project_cuboids(cuboids: Cuboids, camera: Camera) -> Float[Array, "n 4"]:
    """The upright boxes around cuboids in the image, clipped to it.

    Corners nearer than NEAREST_CORNER, or behind the camera, are drawn forward to that depth, so
    that a region that passes the camera reaches the image's border on its own side; one wholly
    nearer than NEAR gets a box without area.
    """
    P = camera.P_road_centred
    axes = cuboids.half_axes().reshape(-1, 3).dot(P[:, :3].T).reshape(3, -1)
    centres = cuboids.base.dot(P[:, :3].T) + P[:, 3]
    corners = CORNERS.dot(axes).reshape(8, -1, 3) + centres
    depth = corners[:, :, 2:]
    pixels = corners[:, :, :2] / np.maximum(depth, MIN_CORNER_DEPTH)
    pixels += camera.K[:2, 2]
    sides = np.minimum.reduce(pixels, 0), np.maximum.reduce(pixels, 0)
    boxes = camera.clip_boxes(np.concatenate(sides, axis=1))
    behind = np.maximum.reduce(depth[:, :, 0], 0) < MIN_DEPTH
    if np.count_nonzero(behind):
        boxes[behind] = 0.0
    return boxes


def plain_pairs(
    areas: Float[Array, "n 4"], boxes: Float[Array, "m 4"]
) -> tuple[Int[Array, " k"], Int[Array, " k"]]:
    """Rows and columns of the boxes that meet the areas."""
    a, b = areas[:, None], boxes[None]
    meet = np.minimum(a[..., 2:], b[..., 2:]) > np.maximum(a[..., :2], b[..., :2])
    rows, columns = (meet[..., 0] & meet[..., 1]).nonzero()
    return rows, columns


def plain_overlap_cost(
    a: Float[Array, "k 4"], b: Float[Array, "k 4"], fraction: float
) -> Float[Array, " k"]:
    """1 - IoU of widened boxes."""
    widening = np.eye(4) * (1.0 + 2.0 * fraction) - fraction * np.tile(np.eye(2), (2, 2))
    return 1.0 - box_iou(a.dot(widening), b.dot(widening))
