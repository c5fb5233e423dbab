"""Where a camera stands above the road, by the boxes of the cars that it saw (Hoiem et al., 2008).

Cars are 1.5 m high, and boxes end where they touch the road: how high boxes are, by where they end,
tells the horizon and the camera's height over it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.optimize import minimize
from scipy.stats import t as student_t

from mot_sim.datasets.recorded import DetectionLog
from tracker.errors import BadDetections
from tracker.geometry import box_iou, covered_share, rotation_x, rotation_z
from tracker.types import CAR_SIZE, CAR_SIZE_STD, Camera, Cuboids

# Std of the mean height of the cars of one place, share of it: 1.45 to 1.61 m in KITTI's drives.
PLACE_STD = 0.03
# Boxes with lower scores (or the lower half of all, if that leaves more), nearer to the border
# (px), lower (px), or hidden by a larger share are left out.
MIN_SCORE, MIN_GAP, MIN_BOX_HEIGHT, MAX_HIDDEN = 0.5, 8.0, 20.0, 0.02
# Boxes of one car: of frames that are no farther apart, with this IoU.
MAX_FRAMES_APART, MIN_IOU = 5, 0.2
# Cars without which nothing is said: of 12, the mean height is known to 2 %.
MIN_CARS = 12
# Boxes of one car that are used, spread over its distances.
MAX_BOXES_PER_CAR = 15
# Of edges: std in box heights and in px; of the camera's nods, rad.
EDGE_STD, PIXEL_STD, NOD_STD = 0.03, 1.0, 0.004
# Share of boxes that are of no car, or not of a whole one, and the density of their log-sizes.
OUTLIERS, OUTLIER_DENSITY = 0.1, 0.25
# Cars lean rarely: std of the roll that is expected, rad.
ROLL_STD = np.radians(1.0)
# Headings that cars may have, of those in half a turn; the search looks at fewer.
YAW_COUNT, SEARCH_YAW_COUNT = 8, 4
MIN_DEPTH = 0.3
PLACEMENTS = 3
# Where the search begins: heights, m, and pitches, rad.
HEIGHTS = np.geomspace(0.6, 30.0, 12)
PITCHES = np.radians(np.arange(-84.0, 31.0, 4.0))
MAX_SEARCH_BOXES = 100
STARTS = 3
STEPS = np.array([1e-3, 1e-4, 1e-4])
MAX_STEP = np.array([0.1, 0.02, 0.02])
ITERATIONS = 16
# Of Student's t.
FREEDOM = 4.0
# Cars whose height is so many stds off count 60 % (Welsch): at the first step, at the last one.
CAR_WIDTHS = (4.0, 1.5)
# Boxes end lower than the labels' cuboids, in box heights: RRC 0.010, PointRCNN 0.004, PermaTrack
# -0.004 on KITTI's ten drives.
BOTTOM_BIAS = 0.004


@dataclass(frozen=True, eq=False)
class CameraEstimate:
    """A camera's place above the road, and how well it is known."""

    camera: Camera
    """The camera at the estimated height, pitch and roll."""
    pitch: float
    """Positive looks up, rad."""
    roll: float
    """Positive leans right, rad."""
    half_widths: Float[Array, "3"]
    """Of the 95 % intervals of height (m), pitch and roll (rad)."""
    car_count: int
    """Cars by which it was estimated."""
    box_count: int
    """Boxes of theirs."""

    @property
    def content(self) -> dict[str, float | int]:
        """The figures by name; angles in degrees."""
        height, pitch, roll = self.half_widths.tolist()
        return {
            "camera_height": self.camera.height,
            "camera_height_95": height,
            "pitch_deg": float(np.degrees(self.pitch)),
            "pitch_deg_95": float(np.degrees(pitch)),
            "roll_deg": float(np.degrees(self.roll)),
            "roll_deg_95": float(np.degrees(roll)),
            "cars": self.car_count,
            "boxes": self.box_count,
        }

    @property
    def lines(self) -> list[str]:
        """The estimate in words, with its 95 % intervals."""
        height, (pitch, roll) = self.half_widths[0], np.degrees(self.half_widths[1:])
        up, right = np.degrees([self.pitch, self.roll])
        return [
            f"by {self.box_count:,} boxes of {self.car_count:,} cars, with 95 % intervals:",
            f"height {self.camera.height:.3f} \u00b1{height:.3f} m",
            f"pitch {up:.2f} \u00b1{pitch:.2f} degrees (up is positive)",
            f"roll {right:.2f} \u00b1{roll:.2f} degrees (right is positive)",
        ]


def estimate_camera(
    logs: Sequence[DetectionLog], K: Float[Array, "3 3"], image_size: tuple[int, int]
) -> CameraEstimate:
    """Height, pitch and roll of the camera that saw these drives, its intrinsics being known.

    logs: boxes of cars, of one or several drives; those of other classes are left out, as are
    weak, small and hidden boxes and those at the image's border. Cars are taken to be 1.506 m high
    on average, 7.8 % more or less each, and 3 % all of a place; vans and trucks among them count
    as outliers.
    Raises BadDetections for too few cars.
    """
    seen = [SeenBoxes.of(log, image_size) for log in logs]
    offsets = np.cumsum([0, *(each.car_count for each in seen)])
    count = int(offsets[-1])
    if count < MIN_CARS:
        raise BadDetections(
            f"{count} car{'' if count == 1 else 's'} of which a whole box was seen; at least "
            f"{MIN_CARS} are needed: give longer drives, or several of the same camera"
        )
    boxes = np.concatenate([each.boxes for each in seen])
    boxes[:, 3] -= BOTTOM_BIAS * (boxes[:, 3] - boxes[:, 1])
    cars = np.concatenate([each.cars + first for each, first in zip(seen, offsets, strict=False)])
    fit = CameraFit(boxes, cars, np.asarray(K, dtype=float))
    found, cov = fit.solve(fit.start())
    cov[0, 0] += PLACE_STD**2
    half_widths = np.sqrt(np.diag(cov)) * float(student_t.ppf(0.975, count - 3))
    height, pitch, roll = float(np.exp(found[0])), float(found[1]), float(found[2])
    half_widths[0] *= height
    camera = Camera.mounted(K, image_size, height, pitch, roll)
    return CameraEstimate(camera, pitch, roll, half_widths, count, len(boxes))


@dataclass(frozen=True, eq=False)
class SeenBoxes:
    """Whole boxes of cars."""

    boxes: Float[Array, "n 4"]
    """x_min, y_min, x_max, y_max, px."""
    cars: Int[Array, " n"]
    """Which car each shows, from 0 on."""
    car_count: int
    """The number of cars."""

    @classmethod
    def of(cls, log: DetectionLog, image_size: tuple[int, int]) -> "SeenBoxes":
        """The whole boxes of a drive, chained from frame to frame by their overlap."""
        found = log.detections
        is_car = np.full(len(found), True) if found.kinds is None else found.kinds == "Car"
        least = min(MIN_SCORE, float(np.median(found.scores))) if len(found) else 0.0
        cars, count = np.full(len(found), -1), 0
        whole = np.zeros(len(found), bool)
        before, last = np.zeros(0, np.int64), None
        shifts = np.zeros((len(found), 4))  # from the box before, px
        for frame in np.unique(log.frames).tolist():
            first, end = np.searchsorted(log.frames, [frame, frame + 1])
            rows = np.arange(first, end)
            rows = rows[is_car[rows] & (found.scores[rows] >= least)]
            boxes = found.boxes[rows]
            whole[rows] = _whole(boxes, image_size)
            if last is None or frame > last + MAX_FRAMES_APART:
                before = before[:0]
            foreseen = found.boxes[before] + shifts[before]
            overlap = box_iou(foreseen[:, None], boxes[None])
            while overlap.size and overlap.max() > MIN_IOU:
                old, new = np.unravel_index(overlap.argmax(), overlap.shape)
                cars[rows[new]] = cars[before[old]]
                shifts[rows[new]] = boxes[new] - found.boxes[before[old]]
                overlap[old], overlap[:, new] = 0.0, 0.0
            fresh = rows[cars[rows] < 0]
            cars[fresh] = count + np.arange(len(fresh))
            count += len(fresh)
            before, last = rows, frame
        kept = np.flatnonzero(whole)
        kept = np.concatenate(
            [np.zeros(0, np.int64)]
            + [_spread(kept[cars[kept] == car], found.boxes) for car in np.unique(cars[kept])]
        )
        numbers, cars = np.unique(cars[kept], return_inverse=True)
        return cls(found.boxes[kept], cars, len(numbers))


def _whole(boxes: Float[Array, "n 4"], image_size: tuple[int, int]) -> Bool[Array, " n"]:
    """Which boxes are high enough, inside the image, and not behind one that ends lower."""
    border = np.array(image_size) - 1.0
    inside = (boxes[:, :2] > MIN_GAP).all(axis=1) & (boxes[:, 2:] < border - MIN_GAP).all(axis=1)
    high = boxes[:, 3] - boxes[:, 1] >= MIN_BOX_HEIGHT
    return np.asarray(inside & high & (covered_share(boxes, boxes) <= MAX_HIDDEN))


def _spread(rows: Int[Array, " n"], boxes: Float[Array, "m 4"]) -> Int[Array, " k"]:
    """Some of the rows, from the lowest box to the highest one."""
    by_height = rows[np.argsort(boxes[rows, 3] - boxes[rows, 1], kind="stable")]
    chosen = np.linspace(0, len(rows) - 1, min(len(rows), MAX_BOXES_PER_CAR)).round()
    return by_height[np.unique(chosen.astype(np.int64))]


@dataclass(frozen=True, eq=False)
class CameraFit:
    """Fits log height, pitch and roll of a camera to boxes of cars."""

    boxes: Float[Array, "n 4"]
    """x_min, y_min, x_max, y_max, px."""
    cars: Int[Array, " n"]
    """Which car each shows, in ascending order."""
    K: Float[Array, "3 3"]
    """Intrinsics, px."""
    yaw_count: int = YAW_COUNT
    """How many headings a car may have."""

    @cached_property
    def rays(self) -> Float[Array, "n 3"]:
        """Through the middles of the boxes' lower edges, in the camera's axes."""
        return self._rays(0.5 * (self.boxes[:, 0] + self.boxes[:, 2]), self.boxes[:, 3])

    def _rays(self, u: Float[Array, "*n"], v: Float[Array, "*n"]) -> Float[Array, "*n 3"]:
        return np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(self.K).T

    def start(self) -> Float[Array, "3"]:
        """About the likeliest camera: by some of the boxes, each for itself."""
        some = np.sort(np.random.default_rng(0).permutation(len(self.boxes))[:MAX_SEARCH_BOXES])
        few = CameraFit(self.boxes[some], self.cars[some], self.K, SEARCH_YAW_COUNT)
        starts = [np.array([np.log(h), pitch, 0.0]) for h in HEIGHTS for pitch in PITCHES]
        likely = np.argsort([-few.likelihood(start) for start in starts], kind="stable")
        simplex = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.03, 0], [0, 0, 0.02]])
        tried = [
            minimize(
                lambda x: -few.likelihood(x), starts[index], method="Nelder-Mead",
                options={"initial_simplex": starts[index] + simplex, "maxfev": 100},
            )
            for index in likely[:STARTS]
        ]  # fmt: skip
        return np.asarray(min(tried, key=lambda each: each.fun).x)

    def likelihood(self, camera: Float[Array, "3"]) -> float:
        """The log-likelihood of all boxes, taken one by one, less what the roll costs."""
        off, variances, chance = self.residuals(camera)
        inside = chance * np.exp(-0.5 * off**2 / variances) / np.sqrt(2.0 * np.pi * variances)
        mixed = (1.0 - OUTLIERS) * np.where(np.isfinite(inside), inside, 0.0)
        return float(
            np.log(mixed + OUTLIERS * OUTLIER_DENSITY).sum() - 0.5 * (camera[2] / ROLL_STD) ** 2
        )

    def residuals(
        self, camera: Float[Array, "3"]
    ) -> tuple[Float[Array, " n"], Float[Array, " n"], Float[Array, " n"]]:
        """Log heights of boxes over those that mean cars have there, and their variances.

        Of cars of all headings, by how well their widths fit; and how well they do. NaN above the
        horizon. The variance holds that of the cars' heights.
        """
        R_road_cam = rotation_x(float(camera[1])) @ rotation_z(float(camera[2]))
        made, below = self._expected(R_road_cam, float(np.exp(camera[0])))
        size = self.boxes[:, 2:] - self.boxes[:, :2]
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.log(size / made)
        edges = 2.0 * (EDGE_STD**2 + (PIXEL_STD / size) ** 2)
        wide = edges[:, 0] + CAR_SIZE_STD[2] ** 2
        chance = np.exp(-0.5 * off[..., 0] ** 2 / wide) / np.sqrt(2.0 * np.pi * wide)
        total = chance.sum(axis=0)
        share = np.where(total > 1e-12, chance / np.maximum(total, 1e-12), 1.0 / self.yaw_count)
        nod = self.K[1, 1] * NOD_STD / np.maximum(below, 1.0)
        variance = edges[:, 1] + CAR_SIZE_STD[1] ** 2 + nod**2
        return (share * off[..., 1]).sum(axis=0), variance, total / self.yaw_count

    def _expected(
        self, R_road_cam: Float[Array, "3 3"], height: float
    ) -> tuple[Float[Array, "y n 2"], Float[Array, " n"]]:
        """Widths and heights of the boxes of mean cars of all headings that end where these do, px.

        NaN above the horizon; and how far below it they end, px.
        """

        def meet(rays: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
            """The road, in the camera's axes."""
            down = rays @ R_road_cam[1]
            with np.errstate(divide="ignore", invalid="ignore"):
                return rays * np.where(down > 0.0, height / down, np.nan)[..., None]

        feet = meet(self.rays)
        yaws = np.linspace(0.0, np.pi, self.yaw_count, endpoint=False)
        sizes = np.tile(CAR_SIZE, (len(yaws), 1))
        corners = Cuboids(np.zeros((len(yaws), 3)), yaws, sizes).corners()
        shown = (corners @ R_road_cam @ self.K.T)[:, None]  # y, 1, 8, 3
        place = np.tile(feet, (self.yaw_count, 1, 1))
        for step in range(PLACEMENTS):
            pixels = shown + (place @ self.K.T)[:, :, None]
            pixels = pixels[..., :2] / np.maximum(pixels[..., 2:], MIN_DEPTH)
            low, high = pixels.min(axis=2), pixels.max(axis=2)
            if step < PLACEMENTS - 1:
                foot = self._rays(0.5 * (low[..., 0] + high[..., 0]), high[..., 1])
                place = place + feet - meet(foot)
        return high - low, self.K[1, 1] * (self.rays @ R_road_cam[1])

    def _jacobian(self, camera: Float[Array, "3"]) -> Float[Array, "n 3"]:
        """How the log heights change with log height, pitch and roll of the camera."""
        columns = [
            (self.residuals(camera + step)[0] - self.residuals(camera - step)[0]) / (2 * step.max())
            for step in np.diag(STEPS)
        ]
        return np.stack(columns, axis=1)

    def solve(self, camera: Float[Array, "3"]) -> tuple[Float[Array, "3"], Float[Array, "3 3"]]:
        """The estimate by all boxes, and its covariance.

        Boxes of a car share its unknown height: what they tell of the horizon does not depend on
        that. Far-off boxes and cars count less (Student's t), as in iterated least squares.
        """
        prior = np.diag([0.0, 0.0, ROLL_STD**-2])
        count = int(self.cars[-1]) + 1
        spread = CAR_SIZE_STD[1] ** 2
        whole = np.ones(count)
        for width in np.linspace(*CAR_WIDTHS, ITERATIONS):
            off, variances, _ = self.residuals(camera)
            J = self._jacobian(camera)
            known = np.isfinite(off) & np.isfinite(J).all(axis=1)
            J, off = np.where(known[:, None], J, 0.0), np.where(known, off, 0.0)
            precision = known / (variances - spread)
            level = self._of_cars(precision * off) / np.maximum(self._of_cars(precision), 1e-9)
            apart = (off - level[self.cars]) ** 2 * precision
            precision = precision * (FREEDOM + 1.0) / (FREEDOM + apart)
            own = self._of_cars(precision)
            level = self._of_cars(precision * off) / np.maximum(own, 1e-9)
            whole = np.exp(-0.5 * level**2 / (spread + 1.0 / np.maximum(own, 1e-9)) / width**2)
            shrink = 1.0 / (own + 1.0 / spread)
            # inverse covariance of a car's boxes: D - D 1 1' D / (1' D 1 + 1 / spread)
            Jd = self._of_cars(precision[:, None] * J)
            rd = self._of_cars(precision * off)
            each = self._of_cars(precision[:, None, None] * J[:, :, None] * J[:, None])
            each -= shrink[:, None, None] * Jd[:, :, None] * Jd[:, None]
            slope = (
                self._of_cars((precision * off)[:, None] * J) - shrink[:, None] * Jd * rd[:, None]
            )
            information = (whole[:, None, None] * each).sum(axis=0) + prior
            slope = whole[:, None] * slope
            step = np.linalg.solve(information, slope.sum(axis=0) + prior @ camera)
            camera = camera - np.clip(step, -MAX_STEP, MAX_STEP)
        inverse = np.linalg.inv(information)
        return camera, inverse @ (slope.T @ slope + prior) @ inverse

    def _of_cars(self, values: Float[Array, "n *k"]) -> Float[Array, "c *k"]:
        """Sums over the boxes of each car."""
        total = np.zeros((int(self.cars[-1]) + 1, *values.shape[1:]))
        np.add.at(total, self.cars, values)
        return total
