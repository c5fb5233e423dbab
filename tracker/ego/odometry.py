"""Visual odometry: an image and its cars' boxes in, the camera's motion out."""

from dataclasses import dataclass, field

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, UInt8
from numpy import ndarray as Array

from tracker.ego.features import CornerFlow, Features
from tracker.ego.filter import CameraVelocity, Coasting, Motion, MotionMeasurement
from tracker.ego.relative import Relative, relative_motion, turn_alone
from tracker.ego.road import Length, RoadScale
from tracker.ego.rotations import rotation_vector
from tracker.errors import BadConfig, BadDetections, BadImage
from tracker.types import Camera

MIN_POINTS = 30
BOX_MARGIN_PIXELS = 3.0  # pixels around a box that are hidden with it
MIN_REACH = 0.5  # metres around the predicted length that are searched at least
UNREAD_STD = 20.0  # metres: of a length that could not be read
MAX_DEVIATION = 3.0  # standard deviations that a length may be off from the predicted one
UNREAD_STILL_STD = 0.1  # metres: what `still` pixels may hide in a scene some 50 m deep


@dataclass(frozen=True, eq=False)
class Limits:
    """When a measurement is one, and how good it can be.

    The std are what every measurement is off by besides its points' noise; measured against OXTS
    on KITTI's sequences.
    """

    noise: float = 0.3
    """Std of a followed point, px; more: worse points count as agreeing."""
    agreeing: float = 0.4
    """Least share of the points that must fit a motion, 0 to 1; more: fewer frames are measured."""
    still: float = 0.35
    """Median px that points move beyond a rotation, up to which the camera only turned; more: slow
    motions count as none."""
    direction_std: float = 0.015
    """Std of the direction of the motion, rad."""
    rotation_std: float = 4e-4
    """Std of the rotation about each axis, rad."""
    length_std: tuple[float, float] = (0.03, 0.01)
    """Std of the length: a share of it, and metres."""


@dataclass(frozen=True, eq=False)
class _View:
    """What is kept of an image until the next one."""

    grey: UInt8[Array, "h w"]
    free: Bool[Array, "h w"]
    texture: Float32[Array, "r w"]


@dataclass(eq=False)
class VisualOdometry:
    """The camera's motion, image by image; one object for one drive.

    Deterministic: the same images and boxes give the same motions, bit by bit.
    """

    camera: Camera
    """The camera; images must have its size."""
    features: Features = field(default_factory=CornerFlow)
    """What finds the same points in two images."""
    road: RoadScale | None = None
    """What reads lengths off the road; None: a `RoadScale` with its defaults."""
    coasting: Coasting = field(default_factory=Coasting)
    """The filter of the motion, and when it is unknown."""
    limits: Limits = field(default_factory=Limits)
    """When a measurement is used, and how good it can be."""
    velocity: CameraVelocity | None = None
    """What is known of the camera's velocity; None: nothing yet."""
    measured: MotionMeasurement | None = None
    """What the last step saw; None where it coasted."""
    _before: _View | None = None

    def __post_init__(self) -> None:
        self._road = RoadScale(self.camera) if self.road is None else self.road

    def step(
        self,
        image: Array | None,
        boxes: Float[Array, "n 4"],
        seconds: float = 0.1,
    ) -> Motion:
        """T_now_before since the last step, and its covariance, see `Frame`.

        image: RGB; None where there is none, then the motion is that of the frames before.
        boxes: of the cars in it, which move on their own; they are clipped to the image, and
        boxes without area hide nothing. seconds: since the last step. Both are None as long as
        nothing was measured, and after coasting for longer than `Coasting.patience`.
        Raises BadImage for another kind or size of image, BadDetections for boxes that are not
        finite, BadConfig for seconds that are not above 0.
        """
        if not (np.isfinite(seconds) and seconds > 0.0):
            raise BadConfig(f"{seconds:g} s between two images: time must go on")
        hidden = without_boxes(boxes, self.camera.image_size)
        now = None if image is None else self._view(check_image(image, self.camera), hidden)
        seen = None
        if now is not None and self._before is not None:
            seen = self._measure(self._before, now, seconds)
        self._before = now
        known = self.velocity
        self.velocity, motion = self.coasting.step(known, seen, self.camera, seconds)
        is_used = self.velocity is not None and self.velocity.age == 0.0
        self.measured = seen if is_used else None
        return motion

    def _view(self, image: UInt8[Array, "h w 3"], free: Bool[Array, "h w"]) -> _View:
        grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
        return _View(grey, free, self._road.texture(grey))

    def _measure(self, before: _View, now: _View, seconds: float) -> MotionMeasurement | None:
        """The motion between two images; None when too few points agree on one."""
        pixels_before, pixels_now = self.features(before.grey, now.grey, before.free)
        if len(pixels_before) < MIN_POINTS:
            return None
        rays = self.camera.rays(pixels_before), self.camera.rays(pixels_now)
        noise = self.limits.noise / float(self.camera.K[0, 0])
        R, parallax = turn_alone(*rays, noise)
        if parallax * self.camera.K[0, 0] < self.limits.still:
            return self._still(before, now, R)
        relative = relative_motion(*rays, noise)
        if relative is None or relative.agreeing.sum() < MIN_POINTS:
            return None
        if relative.agreeing.mean() < self.limits.agreeing:
            return None
        return self._moving(before, now, relative, seconds)

    def _still(self, before: _View, now: _View, R: Float[Array, "3 3"]) -> MotionMeasurement:
        """No motion, or a rotation: only the road can tell small steps from none."""
        ahead = -self.camera.T_cam_road[:3, 2]
        guesses = np.linspace(-0.2, 0.2, 11)
        length = self._length(before, now, R, ahead, guesses)
        metres, std = (0.0, UNREAD_STILL_STD)
        if length is not None and abs(length.metres) < 0.3:
            metres, std = length.metres, float(np.hypot(length.std, self.limits.length_std[1]))
        across = max(0.3 * std, self.limits.length_std[1])
        cov = np.diag(np.r_[np.full(3, across), np.full(3, self.limits.rotation_std)] ** 2)
        cov[:3, :3] += (std**2 - across**2) * np.outer(ahead, ahead) if std > across else 0.0
        return MotionMeasurement(np.concatenate((metres * ahead, rotation_vector(R))), cov)

    def _moving(
        self, before: _View, now: _View, relative: Relative, seconds: float
    ) -> MotionMeasurement | None:
        """The motion in metres; where the road cannot be read, of the predicted length."""
        d = relative.direction
        expected = self.coasting.predict(self.velocity, self.camera, seconds)
        predicted = float(expected.mean[:3] @ d) * seconds
        spread = float(np.sqrt(d @ expected.cov[:3, :3] @ d)) * seconds
        reach = max(4.0 * spread, MIN_REACH)
        low, high = (
            max(predicted - reach, 0.0),
            min(predicted + reach, self.coasting.speed * seconds),
        )
        guesses = np.linspace(low, max(high, low), 2 + int(max(high - low, 0.0) / 0.08))
        length = self._length(before, now, relative.R, d, guesses)
        if (length is None or length.metres < 0.0) and self.velocity is None:
            return None
        metres, std, is_outlier = predicted, UNREAD_STD, False
        if length is not None:
            metres, std = length.metres, self._length_std(length)
            deviation = abs(metres - predicted)
            is_outlier = bool(deviation > MAX_DEVIATION * np.hypot(std, spread))
            if is_outlier:  # but not left out: if it stays, the filter follows
                std = float(np.sqrt((deviation / MAX_DEVIATION) ** 2 - spread**2))
        return self._metric(relative, metres, std, is_outlier)

    def _metric(
        self, relative: Relative, metres: float, std: float, is_outlier: bool
    ) -> MotionMeasurement:
        """A motion of known length; its covariance from its parts', never below the limits'."""
        floor = [self.limits.direction_std] * 2 + [self.limits.rotation_std] * 3
        cov = np.diag([*np.square(floor), std**2])
        cov[:5, :5] += relative.cov
        parts = np.zeros((6, 6))  # from (tangents of the direction, rotation, length) to the twist
        parts[:3, :2], parts[:3, 5] = metres * relative.tangents, relative.direction
        parts[3:, 2:5] = np.eye(3)
        twist = np.concatenate((metres * relative.direction, rotation_vector(relative.R)))
        return MotionMeasurement(twist, parts @ cov @ parts.T, is_outlier)

    def _length_std(self, length: Length) -> float:
        """What a length is off by; the less alike the road looks, the more."""
        share, least = self.limits.length_std
        share *= length.metres / length.likeness**2
        return float(np.sqrt(length.std**2 + least**2 + share**2))

    def _length(
        self,
        before: _View,
        now: _View,
        R: Float[Array, "3 3"],
        direction: Float[Array, "3"],
        guesses: Float[Array, " k"],
    ) -> Length | None:
        free = before.free & now.free
        return self._road(before.texture, now.texture, free, R, direction, guesses)


def check_image(image: Array, camera: Camera) -> UInt8[Array, "h w 3"]:
    """The image when it is RGB, 8 bits, and of the camera's size; else BadImage."""
    if image.dtype != np.uint8:
        raise BadImage(
            f"an image of {image.dtype}: give 8 bits a channel (uint8); 16 bits: image // 257"
        )
    if image.ndim != 3 or image.shape[2] != 3:
        raise BadImage(
            f"an image of shape {image.shape}: give RGB, (height, width, 3); grey: "
            "np.repeat(image[:, :, None], 3, axis=2)"
        )
    height, width = image.shape[:2]
    if (width, height) != camera.image_size:
        raise BadImage(
            f"an image of {width}x{height} pixels, the camera's calibration is for "
            f"{camera.image_size[0]}x{camera.image_size[1]}: give the size that K belongs to"
        )
    return image


def without_boxes(boxes: Float[Array, "n 4"], image_size: tuple[int, int]) -> Bool[Array, "h w"]:
    """Which pixels lie in none of the boxes, some pixels around them included.

    Boxes are clipped to the image; those outside it or without area hide nothing.
    """
    if not np.isfinite(boxes).all():
        row = int(np.flatnonzero(~np.isfinite(boxes).all(axis=1))[0])
        raise BadDetections(f"box {row} is not finite: {boxes[row].tolist()}; leave it out")
    width, height = image_size
    free = np.ones((height, width), dtype=bool)
    outer = boxes + (-BOX_MARGIN_PIXELS, -BOX_MARGIN_PIXELS, BOX_MARGIN_PIXELS, BOX_MARGIN_PIXELS)
    corners = np.clip(np.round(outer), 0, [width, height, width, height]).astype(int)
    area = (boxes[:, 2] > boxes[:, 0]) & (boxes[:, 3] > boxes[:, 1])
    for x_min, y_min, x_max, y_max in corners[area].tolist():
        free[y_min : y_max + 1, x_min : x_max + 1] = False
    return free
