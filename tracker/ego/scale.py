"""Metres for odometry of unknown scale, by the cars that the camera drives past.

A monocular map (ORB-SLAM and its like) has a scale of its own. How fast cars come nearer is known
in metres: by their height, which hardly varies, and by where they touch the road. Parked ones come
nearer as fast as the camera drives; moving ones keep their speed, whatever it is. Which cars are
parked is decided with the scale, by what fits all of them.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.geometry import box_iou
from tracker.types import CAR_SIZE, CAR_SIZE_STD, Camera, Frame

# Natural logarithms of the scales that are told apart: metres per unit of the odometry.
LOG_SCALES = np.arange(-7.0, 7.0, 0.02)
# How much higher than the mean a car is taken to be, and how likely.
HEIGHT_BIASES = np.array([-1.5, -0.75, 0.0, 0.75, 1.5]) * CAR_SIZE_STD[1]
HEIGHT_SHARES = np.array([0.11, 0.24, 0.3, 0.24, 0.11])
# Std of the ratio of a car's height to that by where it touches the road: of the box's edges, and
# of the camera's pitch, rad.
RATIO_STD, PITCH_STD = 0.05, 0.006
# Std of the mean of that over a drive past the car: errors of pitch and road stay.
ROAD_RATIO_STD = 0.07
# Boxes nearer to the border (px) and lower ones (px) are left out, and all but the tallest.
BORDER, MIN_BOX_HEIGHT, MAX_BOXES = 3.0, 18.0, 12
# Boxes of one car overlap from frame to frame.
MIN_IOU = 0.3
# Depths are compared over this time, s.
BASELINE = 0.5
# Std of the ratio of a box's heights then, and of depths besides, m.
DEPTH_STD, METRES_STD = 0.045, 0.2
# Shares of cars that are parked, that drive along, come towards the camera, or do anything else.
PARKED, ALONG, ONCOMING, OTHER = 0.4, 0.3, 0.15, 0.15
# m/s: std of the speeds of those that drive along, over the camera's; the others' largest ones.
ALONG_STD, ONCOMING_SPEED, MAX_SPEED = 3.0, 25.0, 40.0
# Std of a moving car's change of speed in a baseline, m/s.
CHANGE_STD = 1.0
# Share of observations that fit no car: two cars taken for one, a hidden box.
WRONG = 0.05
# The camera's largest speed so far is about this, m/s, with this std of its logarithm.
USUAL_SPEED, SPEED_STD = 10.0, 0.8
# How much of what a car tells counts: cars that are alike err alike.
CAR_WEIGHT = 0.4
# Std of what all cars of a drive share: heights that are not the mean one, slow traffic. On KITTI's
# ten drives with ORB-SLAM3 the scale comes out 2 to 20 % too small, on 0004 once 60 % too large.
SHARED_STD = 0.06
# Std by which the scale drifts in a second, share of it.
DRIFT = 0.003
# Until the scale is known so well (std of its logarithm), the translation counts as unknown;
# then it is so uncertain along and across the view, up and down, m/s.
MAX_STD = 0.25
UNKNOWN_SPEED = np.array([1.0, 0.3, 10.0])


@dataclass(frozen=True)
class ScaleEstimate:
    """How many metres a unit of the odometry is."""

    factor: float
    """Metres per unit."""
    low: float
    """Lower end of the 95 % interval."""
    high: float
    """Its upper end."""
    known: bool
    """Whether it is known well enough to be used."""


@dataclass(eq=False)
class _Car:
    """A car that is followed from frame to frame."""

    box: Float[Array, "4"]
    """Where it was seen last, turned with the camera since."""
    time: float
    """When it was seen last, s."""
    anchors: Float[Array, "2 3"]
    """Where it was first, and at the beginning of the baseline: in the camera frame of now but for
    the translation, metres for a mean car."""
    since: Float[Array, "2"]
    """When that was, s."""
    moved: Float[Array, "2 3"]
    """The camera's translation since then, units, in the camera frame of now."""
    modes: Float[Array, "m s"]
    """Its log-likelihood for each height and scale if it is parked; last: if it moves."""
    steady: Float[Array, "2 s"]
    """Log-likelihood of its changes of speed, if it is parked and if it moves."""
    likelihood: Float[Array, " s"]
    """What all this tells of the scale, a logarithm."""
    before: Float[Array, " s"] | None = None
    """Its own speed by the last baseline, m/s, for each scale; None: none yet."""
    ratio: Float[Array, "2"] = field(default_factory=lambda: np.zeros(2))
    """Sum of its log heights over that by the road, times their weights; of the weights."""


@dataclass
class EgoScale:
    """Scales the camera's translation while a drive is played; knows nothing of what comes."""

    camera: Camera
    """The camera of the drive; its height above the road is used."""

    def __post_init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the drive."""
        self._past = np.zeros(len(LOG_SCALES))  # log-likelihood by cars that are out of sight
        self._cars: list[_Car] = []
        self._time: float | None = None
        self._speed, self._fastest = 0.0, 0.0  # units a second

    @property
    def estimate(self) -> ScaleEstimate:
        """What is known so far."""
        chance = self._posterior()
        mean, std = _moments(chance)
        ends = np.interp([0.025, 0.975], np.cumsum(chance), LOG_SCALES) - mean
        low, high = np.exp(mean + np.sign(ends) * np.hypot(ends, 1.96 * SHARED_STD)).tolist()
        return ScaleEstimate(math.exp(mean), low, high, known=std < MAX_STD)

    def step(self, frame: Frame) -> Frame:
        """The frame with its translation in metres, and the scale's uncertainty in `motion_cov`.

        Until the scale is known the translation is 0, and uncertain. Boxes of other classes than
        cars are not looked at.
        """
        dt = 0.0 if self._time is None else frame.time - self._time
        self._time = frame.time
        T = frame.T_now_before
        if T is None or dt <= 0.0:
            self._forget(self._cars)
            self._cars = []
        else:
            self._move(T, dt)
        if frame.looked_at:
            self._look(frame)
        return frame if T is None else self._scaled(frame, T, dt)

    def _move(self, T: Float[Array, "4 4"], dt: float) -> None:
        """All cars as seen from the camera of now."""
        R, t = T[:3, :3], T[:3, 3]
        for car in self._cars:
            car.anchors, car.moved = car.anchors @ R.T, car.moved @ R.T + t
            centre = 0.5 * (car.box[:2] + car.box[2:])
            turned = self.camera.project((R @ self.camera.rays(centre[None]).T).T)[0] - centre
            if np.isfinite(turned).all():
                car.box = car.box + np.tile(turned, 2)
        share = min(1.0, dt / BASELINE)
        self._speed += share * (float(np.linalg.norm(t)) / dt - self._speed)
        self._fastest = max(self._fastest, self._speed)
        spread = min(0.25, DRIFT**2 * dt / (2.0 * (LOG_SCALES[1] - LOG_SCALES[0]) ** 2))
        chance = np.exp(self._past - self._past.max())
        chance = np.convolve(chance, [spread, 1.0 - 2.0 * spread, spread], "same")
        self._past = np.log(np.maximum(chance, 1e-300))

    def _look(self, frame: Frame) -> None:
        """Match the boxes with the cars, and read off how fast they come nearer."""
        boxes = self._whole(frame)
        predicted = np.array([car.box for car in self._cars]).reshape(-1, 4)
        overlap = box_iou(predicted[:, None], boxes[None])
        partners = np.full(len(boxes), -1)
        while overlap.size and overlap.max() > MIN_IOU:
            old, new = np.unravel_index(int(overlap.argmax()), overlap.shape)
            partners[new] = old
            overlap[old], overlap[:, new] = 0.0, 0.0
        missed = [car for row, car in enumerate(self._cars) if row not in partners]
        waiting = [car for car in missed if frame.time - car.time <= BASELINE]
        self._forget([car for car in missed if frame.time - car.time > BASELINE])
        found = []
        for box, partner in zip(boxes, partners.tolist(), strict=True):
            place, ratio = self._place(box)
            if partner < 0:
                car = _new_car(box, frame.time, place, ratio)
            else:
                car = self._cars[partner]
                car.box, car.time, car.ratio = box, frame.time, car.ratio + ratio
                if frame.time - car.since[1] >= BASELINE - 1e-6:
                    _observe(car, place, frame.time)
                    car.anchors[1], car.since[1], car.moved[1] = place, frame.time, 0.0
            found.append(car)
        self._cars = waiting + found

    def _whole(self, frame: Frame) -> Float[Array, "n 4"]:
        """Boxes of cars that the image's border does not cut, the tallest ones."""
        detections = frame.found
        boxes = detections.boxes
        if detections.kinds is not None:
            boxes = boxes[detections.kinds == "Car"]
        gap = np.minimum(boxes, self.camera.far_corner - boxes).min(axis=1, initial=np.inf)
        heights = boxes[:, 3] - boxes[:, 1]
        boxes = boxes[(gap > BORDER) & (heights > MIN_BOX_HEIGHT)]
        return boxes[np.argsort(boxes[:, 1] - boxes[:, 3], kind="stable")[:MAX_BOXES]]

    def _place(self, box: Float[Array, "4"]) -> tuple[Float[Array, "3"], Float[Array, "2"]]:
        """Where a mean car with this box is; its log height by the road over that, and its weight.

        The former is multiplied by the weight.
        """
        foot = np.array([[0.5 * (box[0] + box[2]), box[3]]])
        depth = float(self.camera.K[1, 1]) * CAR_SIZE[1] / float(box[3] - box[1])
        place = depth * self.camera.rays(foot)[0]
        on_road = float(self.camera.touch_road(foot)[0, 2])
        if not on_road > 0.0:
            return place, np.zeros(2)
        variance = RATIO_STD**2 + (PITCH_STD * on_road / self.camera.height) ** 2
        weight = 1.0 / variance
        return place, np.array([weight * math.log(on_road / depth), weight])

    def _forget(self, cars: list[_Car]) -> None:
        """Keep what these told of the scale."""
        for car in cars:
            self._past = self._past + CAR_WEIGHT * car.likelihood

    def _posterior(self) -> Float[Array, " s"]:
        """The probability of each scale."""
        total = self._past + CAR_WEIGHT * sum(car.likelihood for car in self._cars)
        if self._fastest > 0.0:
            off = LOG_SCALES + math.log(self._fastest / USUAL_SPEED)
            total = total - 0.5 * (off / SPEED_STD) ** 2
        chance = np.exp(total - total.max())
        return np.asarray(chance / chance.sum())

    def _scaled(self, frame: Frame, T_given: Float[Array, "4 4"], dt: float) -> Frame:
        """The frame with metres."""
        mean, std = _moments(self._posterior())
        T = T_given.copy()
        cov = np.zeros((6, 6)) if frame.motion_cov is None else frame.motion_cov.copy()
        if std < MAX_STD:
            T[:3, 3] *= math.exp(mean)
            cov[:3, :3] += (std**2 + SHARED_STD**2) * np.outer(T[:3, 3], T[:3, 3])
        else:
            T[:3, 3] = 0.0
            cov[:3, :3] += np.diag((UNKNOWN_SPEED * dt) ** 2)
        return replace(frame, T_now_before=T, motion_cov=cov)


def _new_car(
    box: Float[Array, "4"], time: float, place: Float[Array, "3"], ratio: Float[Array, "2"]
) -> _Car:
    """A car that is seen for the first time."""
    modes = np.zeros((len(HEIGHT_BIASES) + 1, len(LOG_SCALES)))
    anchors, moved = np.tile(place, (2, 1)), np.zeros((2, 3))
    return _Car(
        box, time, anchors, np.full(2, time), moved, modes, modes[:2].copy(), modes[0], None, ratio
    )


def _observe(car: _Car, place: Float[Array, "3"], time: float) -> None:
    """Judge a car by each scale, since it was first seen and since the last baseline.

    By how fast it came nearer, and how fast the camera drove.
    """
    seconds = time - car.since
    camera = -np.exp(LOG_SCALES) * (car.moved[:, 2] / seconds)[:, None]  # m/s
    nearer = (car.anchors[:, 2] - place[2]) / seconds
    std = np.hypot(DEPTH_STD * car.anchors[:, 2], METRES_STD) / seconds
    own = camera - nearer[:, None]  # away from the camera
    wrong = WRONG / (2.0 * MAX_SPEED)
    if car.before is not None:
        change = own[1] - car.before
        for row, more in enumerate((0.0, CHANGE_STD)):
            likely = (1.0 - WRONG) * _normal(change, math.hypot(1.4 * std[1], more)) + wrong
            car.steady[row] += np.log(likely)
    car.before = own[1]
    bias = np.exp(HEIGHT_BIASES)[:, None]
    parked = (1.0 - WRONG) * _normal(bias * nearer[0] - camera[0], bias * std[0]) + wrong
    oncoming = np.tanh(-own[0] / std[0]) + np.tanh((own[0] + ONCOMING_SPEED) / std[0])
    moving = (
        ALONG * _normal(np.full_like(own[0], nearer[0]), math.hypot(std[0], ALONG_STD))
        + ONCOMING / ONCOMING_SPEED * 0.5 * np.maximum(oncoming, 0.0)
        + OTHER / (2.0 * MAX_SPEED)
    ) / (ALONG + ONCOMING + OTHER)
    car.modes = np.log(np.vstack([parked, (1.0 - WRONG) * moving[None] + wrong]))
    car.likelihood = _likelihood(car)


def _likelihood(car: _Car) -> Float[Array, " s"]:
    """The log-likelihood of each scale by one car, whatever its height and whether it is parked."""
    heights = np.log(HEIGHT_SHARES)
    if car.ratio[1] > 0.0:
        by_road = car.ratio[0] / car.ratio[1]
        heights = heights - 0.5 * (by_road - HEIGHT_BIASES) ** 2 / ROAD_RATIO_STD**2
        heights = heights - np.log(np.exp(heights).sum())
    shares = np.append(np.log(PARKED) + heights, np.log(1.0 - PARKED))
    total = car.modes + shares[:, None]
    total[:-1] += car.steady[0]
    total[-1] += car.steady[1]
    most = total.max(axis=0)
    return np.asarray(most + np.log(np.exp(total - most).sum(axis=0)))


def _moments(chance: Float[Array, " s"]) -> tuple[float, float]:
    """Mean and std of the log scale."""
    mean = float(chance @ LOG_SCALES)
    return mean, math.sqrt(max(float(chance @ (LOG_SCALES - mean) ** 2), 0.0))


def _normal(x: Float[Array, "*s"], std: Float[Array, "*#s"] | float) -> Float[Array, "*s"]:
    return np.asarray(np.exp(-0.5 * (x / std) ** 2) / (std * math.sqrt(2.0 * math.pi)))
