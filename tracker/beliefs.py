"""Where we think objects are: detections lifted through the road, and carried to the next frame.

Sharma et al., ICRA 2018: `Lift` is phi(pi_G^-1(.), s) of eqs. 2-4, `transport` is g(xi, .).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.geometry import road_contact, road_contact_jacobian
from tracker.types import Camera, Cuboids, Detections
from tracker.types.look import Look
from tracker.types.rows import Rows
from tracker.types.shape_pose import ShapePose

# Length, height, width of the median car among KITTI's labels (ten sequences), metres.
MEAN_CAR = (3.9, 1.5, 1.63)
# Nearest depth of anything in front of the camera, metres.
NEAR = 1.0
# Beyond this a road contact says nothing (one pixel is 20 m at KITTI's focal length), metres.
FAR = 150.0
# A box whose lower edge is this near to the image's (pixels) is cut by it: no road contact.
BORDER = 2.0
# A box grows at most five times as the camera passes the car.
MIN_SCALE = 0.2
# Boxes times this are the pixels of their bottom centres.
BOTTOM_CENTRE = np.array([[0.5, 0.0], [0.0, 0.0], [0.5, 0.0], [0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class Beliefs(Rows):
    """Objects in the road frame of one moment, with their uncertainty.

    cuboids: where they stand. velocity: of the base along road x and z, m/s (0: nobody knows).
    cov: covariance of (x, z, velocity x, velocity z). boxes: in the image of that moment, as
    seen (after `Lift`) or as expected (after `transport`), pixels, not clipped. shape_pose,
    look: as last measured; None when no detector gives it.
    """

    cuboids: Cuboids
    velocity: Float[Array, "n 2"]
    cov: Float[Array, "n 4 4"]
    boxes: Float[Array, "n 4"]
    shape_pose: ShapePose | None = None
    look: Look | None = None

    @classmethod
    def empty(cls) -> "Beliefs":
        """Nothing is believed to be anywhere."""
        return cls(Cuboids.empty(), np.zeros((0, 2)), np.zeros((0, 4, 4)), np.zeros((0, 4)))

    @classmethod
    def concatenate(cls, parts: Sequence["Beliefs"]) -> "Beliefs":
        """The rows of all parts; where only some know a cue, the others' is unknown.

        A frame without detections has no columns; it takes nothing from those remembered.
        """
        for cue in ("shape_pose", "look"):
            measured = [getattr(part, cue) for part in parts]
            known = [column for column in measured if column is not None]
            if known and len(known) < len(parts):
                parts = [
                    replace(part, **{cue: known[0].unknown(len(part))}) if column is None else part
                    for part, column in zip(parts, measured, strict=True)
                ]
        return super().concatenate(parts)

    def region(self, sigmas: float) -> Cuboids:
        """The cuboids stretched by `sigmas` standard deviations along and across the car.

        The uncertainty is far longer than wide (it points along the viewing ray): it is taken
        in the car's own axes, so that the region stays a cuboid.
        """
        c, s = np.cos(self.cuboids.yaw), np.sin(self.cuboids.yaw)
        axes = np.empty((len(c), 2, 2))  # rows: forward and left of the car, on road x and z
        axes[:, 0, 0] = axes[:, 1, 1] = c
        axes[:, 0, 1] = -s
        axes[:, 1, 0] = s
        var = axes @ self.cov[:, :2, :2] * axes
        size = self.cuboids.size.copy()
        size[:, ::2] += 2.0 * sigmas * np.sqrt(var[:, :, 0] + var[:, :, 1])
        return Cuboids(self.cuboids.base, self.cuboids.yaw, size)


NOTHING = Beliefs.empty()


@dataclass(frozen=True)
class Lift:
    """From boxes to beliefs on the road: eq. 2 with its linearised covariance.

    edge_std: std of a box's bottom centre at confidence 1, as a fraction of the box's height;
        it doubles at confidence 0 (sigma(s) of the paper). RRC's edges: 2.7-3.1 %.
    pitch_std, height_std: how the camera nods (radians) and heaves (metres) from frame to frame;
        what is constant shifts the belief and the new detection alike.
    car_size: length, height, width where no detector measured them; car_size_std: of the height,
        as a fraction; it is what limits the depth that a box's height tells.
    yaw: where no detector measured it (-pi/2: along the road that the camera looks down).
    speed_std: prior of the unknown velocity along x and z, m/s.
    use_box_height: fuse the depth that the box's height tells. Unlike the paper, which has eq. 2
        alone; a box whose bottom edge is no road contact is placed by its height in any case.
    """

    edge_std: float = 0.03
    pitch_std: float = 0.005
    height_std: float = 0.03
    car_size: tuple[float, float, float] = MEAN_CAR
    car_size_std: float = 0.06
    yaw: float = -np.pi / 2
    speed_std: tuple[float, float] = (3.0, 8.0)
    use_box_height: bool = False

    def __call__(self, detections: Detections, camera: Camera) -> Beliefs:
        """One belief a detection.

        The bottom centre of the box touches the road at the car's near face (eq. 2); the centre
        lies behind it, on the same ray, by half of the yawed extent. Where the bottom edge is no
        road contact (cut by the lower border, or above the horizon) the depth comes from the
        box's height, at most that of the border, and its std is half of it.
        """
        boxes, n = detections.boxes, len(detections)
        if n == 0:
            return NOTHING
        yaw, size = detections.yaw, detections.size  # a NaN row: not measured
        yaw = np.full(n, self.yaw) if yaw is None else np.where(np.isnan(yaw), self.yaw, yaw)
        if size is None:
            size = np.empty((n, 3))
            size[:] = self.car_size
        else:
            size = np.where(np.isnan(size), self.car_size, size)
        rays = camera.rays_road(boxes @ BOTTOM_CENTRE)
        heights = np.maximum(boxes[:, 3] - boxes[:, 1], 1.0)
        doubt = self.edge_std * (2.0 - np.minimum(np.maximum(detections.scores, 0.0), 1.0))

        near, cov = self._road_contact(rays, doubt * heights, camera)
        near_by_height = camera.K[1, 1] * size[:, 1] / heights
        cut = boxes[:, 3] >= camera.image_size[1] - 1.0 - BORDER
        lost = cut | ~(near < FAR)
        if np.count_nonzero(lost):
            _place_by_height(near, cov, near_by_height, lost, rays)
        if self.use_box_height:
            var = near_by_height**2 * (2.0 * doubt**2 + self.car_size_std**2)  # two edges
            var[cut] = np.inf
            gain = cov[:, 1] / (cov[:, 1, 1] + var)[:, None]
            near = near + gain[:, 1] * (near_by_height - near)
            cov = cov - gain[:, :, None] * cov[:, None, 1]
        behind = 0.5 * (size[:, 0] * np.abs(np.sin(yaw)) + size[:, 2] * np.abs(np.cos(yaw)))
        base = rays * near[:, None]
        base[:, 1] -= camera.height
        base[:, ::2] += rays[:, ::2] * behind[:, None]
        state_cov = np.zeros((n, 4, 4))
        state_cov[:, :2, :2] = cov
        state_cov[:, 2, 2], state_cov[:, 3, 3] = self.speed_std[0] ** 2, self.speed_std[1] ** 2
        cuboids, still = Cuboids(base, yaw, size), np.zeros((n, 2))
        cues = ShapePose.of(detections), Look.of(detections)
        return Beliefs(cuboids, still, state_cov, boxes, *cues)

    def _road_contact(
        self, rays: Float[Array, "n 3"], sigma: Float[Array, " n"], camera: Camera
    ) -> tuple[Float[Array, " n"], Float[Array, "n 2 2"]]:
        """Reach along the rays (NaN: none) and covariance on the road's x and z, eq. 2."""
        contact = road_contact(rays, camera.height)
        deviation = road_contact_jacobian(rays, camera.A_road_pixel[:, :2], camera.height)
        deviation[:, :, :2] *= sigma[:, None, None]
        deviation[:, :, 2] *= self.height_std
        deviation[:, :, 3] *= self.pitch_std
        return contact[:, 1] / rays[:, 1], deviation @ deviation.transpose(0, 2, 1)


def _place_by_height(
    near: Float[Array, " n"],
    cov: Float[Array, "n 2 2"],
    near_by_height: Float[Array, " n"],
    lost: Bool[Array, " n"],
    rays: Float[Array, "n 3"],
) -> None:
    """Overwrite, in the `lost` rows, reach and covariance by what the box's height tells."""
    near[lost] = np.clip(np.fmin(near[lost], near_by_height[lost]), NEAR, FAR)
    along = rays[lost, ::2] * (0.5 * near[lost])[:, None]
    cov[lost] = along[:, :, None] * along[:, None, :] + np.eye(2)


def transport(
    beliefs: Beliefs,
    camera: Camera,
    T_now_before: Float[Array, "4 4"],
    motion_cov: Float[Array, "6 6"],
    moved: Float[Array, "n 2"] | None = None,
) -> Beliefs:
    """The beliefs in the road frame of now, g(xi, .) of eqs. 3-4, the motion's doubt added.

    `moved` is how far each object itself went meanwhile, in the road frame of before, metres.
    The expected boxes are the seen ones, carried by the parallax of the car's near half: exact
    for a turning camera, to first order for a moving one.
    """
    n = len(beliefs)
    if n == 0:
        return beliefs
    base = beliefs.cuboids.base
    if moved is not None:
        base = base.copy()
        base[:, ::2] += moved
    T_road = camera.T_road_cam @ T_now_before @ camera.T_cam_road
    turn = math.atan2(T_road[0, 2] - T_road[2, 0], T_road[0, 0] + T_road[2, 2])
    base_now = base @ T_road[:3, :3].T + T_road[:3, 3]
    cuboids = Cuboids(base_now, beliefs.cuboids.yaw + turn, beliefs.cuboids.size)

    R = T_road[:3:2, :3:2]
    R_state = np.zeros((4, 4))
    R_state[:2, :2] = R_state[2:, 2:] = R
    cov = R_state @ beliefs.cov @ R_state.T
    shift = (base_now @ camera.road_shift[:3] + camera.road_shift[3]).reshape(n, 2, 6)
    cov[:, :2, :2] += shift @ motion_cov @ shift.transpose(0, 2, 1)
    boxes = _carry_boxes(beliefs, camera, T_now_before, moved)
    pose = beliefs.shape_pose
    if pose is not None:
        pose = ShapePose(pose.shape, pose.yaw + turn, pose.cov)
    return Beliefs(cuboids, beliefs.velocity @ R.T, cov, boxes, pose, beliefs.look)


def _carry_boxes(
    beliefs: Beliefs,
    camera: Camera,
    T_now_before: Float[Array, "4 4"],
    moved: Float[Array, "n 2"] | None,
) -> Float[Array, "n 4"]:
    """The boxes as fronto-parallel windows at the car's depth, seen from the camera of now."""
    cuboids = beliefs.cuboids
    depth = cuboids.base @ camera.T_cam_road[2, :3] + camera.T_cam_road[2, 3]
    depth = np.maximum(depth - 0.25 * cuboids.size[:, 0], NEAR)
    R, t = T_now_before[:3, :3], T_now_before[:3, 3]
    K_R = camera.K @ R
    H = K_R @ camera.K_inverse  # carries pixels at infinity
    shift = camera.K @ t
    if moved is not None:
        shift = shift + moved @ (K_R @ camera.T_cam_road[:3, :3:2]).T
    corners = beliefs.boxes.reshape(-1, 2, 2) @ H[:, :2].T + H[:, 2]
    corners += (shift / depth[:, None])[:, None]
    return (corners[:, :, :2] / np.maximum(corners[:, :, 2:], MIN_SCALE)).reshape(-1, 4)
