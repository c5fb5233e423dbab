"""The rotation of the camera since the last frame, corrected by what the boxes agree on."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.errors import BadConfig
from tracker.geometry import box_iou, homogeneous, rotation_x, rotation_y
from tracker.types import Camera

# Of a left perturbation (rho, phi) of T_now_before: where its yaw and its pitch stand.
YAW, PITCH = 4, 3
# Rotations that are tried, in standard deviations.
SEARCH_DEVIATIONS = np.linspace(-3.0, 3.0, 25)
# What a squared standard deviation costs in the search, in overlapping boxes.
DEVIATION_PENALTY = 0.1
# Boxes that overlap less are not the same car.
MIN_IOU = 0.2
# A squared difference of this many variances has half the weight of none.
HALF_WEIGHT_VARIANCES = 6.0


@dataclass(frozen=True)
class CameraRotationFilter:
    """Yaw and pitch of the camera's motion, as far as its covariance leaves them open.

    A small rotation shifts all boxes alike, which no car does. The motion as stated is the prior;
    the measurement is the rotation that most predicted boxes share with the detected ones (a mean
    with Cauchy weights, since cars move on their own); both are Gaussian.
    """

    min_pixels: float = 1.0
    """Where the stated motion has a std below this, in pixels of the image, nothing is done: so
    with KITTI's GPS/IMU."""
    jitter: tuple[float, float] = (1.5, 0.03)
    """Std of the place of a box, pixels and share of its height."""

    def __post_init__(self) -> None:
        if not (self.min_pixels > 0.0 and min(self.jitter) >= 0.0 and max(self.jitter) > 0.0):
            raise BadConfig(f"{self}: give min_pixels above 0, a jitter not below 0 and not all 0")

    def is_uncertain(self, motion_cov: Float[Array, "6 6"], camera: Camera) -> bool:
        """Whether the std of the rotation is more than `min_pixels` pixels."""
        widest = max(float(motion_cov[YAW, YAW]), float(motion_cov[PITCH, PITCH]))
        return float(camera.K[0, 0]) ** 2 * widest > self.min_pixels**2

    def __call__(
        self,
        expected: Float[Array, "n 4"],
        detected: Float[Array, "m 4"],
        T_now_before: Float[Array, "4 4"],
        motion_cov: Float[Array, "6 6"],
        camera: Camera,
    ) -> tuple[Float[Array, "4 4"], Float[Array, "6 6"]]:
        """The corrected motion, its covariance. expected: boxes predicted by the stated motion."""
        if len(expected) == 0 or len(detected) == 0:
            return T_now_before, motion_cov
        std = np.sqrt(motion_cov[[YAW, PITCH], [YAW, PITCH]])
        open_ = (std * camera.K[0, 0] > self.min_pixels).nonzero()[0]
        tried = self._search(expected, detected, std, open_, camera)
        rows, columns = _pairs(_turned(expected, tried, camera), detected)
        if len(rows) == 0:
            return T_now_before, motion_cov
        before, now = _bearings(expected[rows], camera), _bearings(detected[columns], camera)
        heights = expected[rows, 3:] - expected[rows, 1:2]
        pixels = self.jitter[0] ** 2 + (self.jitter[1] * heights) ** 2
        var = pixels / _pixels_a_radian(expected[rows], camera) ** 2
        off, shared = now - before, tried
        if len(rows) > 2:
            shared = np.median(off, axis=0)
        for _ in range(3):
            weights = 1.0 / (var + (off - shared) ** 2 / HALF_WEIGHT_VARIANCES)
            shared = (weights * off).sum(axis=0) / weights.sum(axis=0)
        left = np.ones(2)  # of the standard deviations as stated
        turn = np.zeros(2)
        precision = weights.sum(axis=0)[open_] + 1.0 / std[open_] ** 2
        turn[open_] = (weights * off).sum(axis=0)[open_] / precision
        left[open_] = 1.0 / (std[open_] * np.sqrt(precision))
        R = rotation_y(float(turn[0])) @ rotation_x(float(turn[1]))
        scale = np.ones(6)
        scale[[YAW, PITCH]] = left
        return homogeneous(R) @ T_now_before, motion_cov * np.outer(scale, scale)

    def _search(
        self,
        expected: Float[Array, "n 4"],
        detected: Float[Array, "m 4"],
        std: Float[Array, "2"],
        open_: Int[Array, " k"],
        camera: Camera,
    ) -> Float[Array, "2"]:
        """The turn (yaw, pitch) that makes most of the expected boxes meet detected ones."""
        best = np.zeros(2)
        for axis in open_.tolist():
            turns = np.tile(best, (len(SEARCH_DEVIATIONS), 1))
            turns[:, axis] = SEARCH_DEVIATIONS * std[axis]
            boxes = np.stack([_turned(expected, turn, camera) for turn in turns])
            met = box_iou(boxes[:, :, None], detected[None, None]).max(axis=2).sum(axis=1)
            best = turns[int(np.argmax(met - DEVIATION_PENALTY * SEARCH_DEVIATIONS**2))]
        return best


def _slopes(boxes: Float[Array, "n 4"], camera: Camera) -> Float[Array, "n 2"]:
    """x / z and y / z of the rays through the boxes' centres."""
    centres = 0.5 * (boxes[:, :2] + boxes[:, 2:]) - camera.K[:2, 2]
    return centres / np.diag(camera.K)[:2]


def _bearings(boxes: Float[Array, "n 4"], camera: Camera) -> Float[Array, "n 2"]:
    """Yaw and pitch of the rays through the boxes' centres; a turn adds to all alike."""
    return np.arctan(_slopes(boxes, camera)) * (1.0, -1.0)


def _pixels_a_radian(boxes: Float[Array, "n 4"], camera: Camera) -> Float[Array, "n 2"]:
    """How far the boxes' centres move with the camera's yaw and pitch."""
    return np.diag(camera.K)[:2] * (1.0 + _slopes(boxes, camera) ** 2)


def _turned(
    boxes: Float[Array, "n 4"], turn: Float[Array, "2"], camera: Camera
) -> Float[Array, "n 4"]:
    """The boxes after a small turn (yaw, pitch) of the camera."""
    shift = _pixels_a_radian(boxes, camera) * turn * (1.0, -1.0)
    return boxes + np.concatenate((shift, shift), axis=1)


def _pairs(
    a: Float[Array, "n 4"], b: Float[Array, "m 4"]
) -> tuple[Int[Array, " k"], Int[Array, " k"]]:
    """The rows and columns of boxes that are likely the same cars."""
    from scipy.optimize import linear_sum_assignment

    overlap = box_iou(a[:, None], b[None])
    rows, columns = linear_sum_assignment(-np.where(overlap > MIN_IOU, overlap, 0.0))
    met = overlap[rows, columns] > MIN_IOU
    return rows[met], columns[met]
