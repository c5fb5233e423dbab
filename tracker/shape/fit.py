"""Single-view shape and pose from keypoints, all cars of a frame at once.

The scheme of Murthy et al., ICRA 2017: pose on the mean shape first, then the coefficients of
eq. 1 with it. Unlike there, car, road and prior are all in likelihood units, so that the result
has a covariance, and several yaws are tried, so that a car seen from behind is not taken for one
seen from ahead.
"""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.errors import BadConfig, BadDetections
from tracker.geometry import wrap_angle
from tracker.shape.fit_start import Rays, rays_to, starts, visibility_score
from tracker.shape.model import CarModel
from tracker.shape.prior import load_prior, turned_points
from tracker.shape.projection import SCALE, SHAPE, YAW, ObservedPoints, X, Z
from tracker.shape.solver import Solved, inverses, solve
from tracker.types import Camera, Cuboids, Detections
from tracker.types.rows import Rows

MIN_KEYPOINTS = 4  # visible keypoints: with fewer a car has no fit
MAX_PIXEL = 1e5  # pixels from the origin: no point of an image, whatever a detector says
MAX_CARS_AT_ONCE = 128  # cars at once: the arrays stay in the processor's cache
POSE_STEPS, JOINT_STEPS, LAST_STEPS = 3, 10, 25
START_TOLERANCE = 0.02  # how far from its least cost a start may be when it is compared
MAX_LOG_LIKELIHOOD_GAP = 20.0  # a start this much less likely (log) than the best is given up
COV_ORDER = (X, Z, YAW)  # of the covariance; the coefficients follow


def _shipped() -> CarModel:
    return CarModel(load_prior().first(5))


@dataclass(frozen=True, eq=False)
class FittedCars(Rows):
    """Cars in the road frame; NaN in every column of a row without a fit."""

    shape: Float[Array, "n b"]
    """Coefficients of eq. 1."""
    yaw: Float[Array, " n"]
    """About road +y, rad, in [-pi, pi)."""
    size: Float[Array, "n 3"]
    """Length, height, width, metres."""
    base: Float[Array, "n 3"]
    """Centre of the bottom face, metres."""
    cov: Float[Array, "n s s"]
    """Covariance of (x, z, yaw, coefficients); s = b + 3."""
    residual: Float[Array, " n"]
    """About 1 for a car whose keypoints are as good as stated; the larger the worse."""
    seen: Int[Array, " n"]
    """How many keypoints were used; known without a fit, too."""
    turned_gap: Float[Array, " n"]
    """By how much the log-likelihood falls where each point is taken for its counterpart of the
    car's other end; about 0 or less: the shape does not tell front and rear apart. inf: a model
    whose points have no counterparts."""
    fits: Bool[Array, " n"]
    """Whether a car fits, and fits well enough to tell yaw and depth, perhaps turned round."""
    trusted: Bool[Array, " n"]
    """Whether it fits, and its points do not fit the car turned round nearly as well."""

    @classmethod
    def unknown(cls, n: int, coefficients: int) -> "FittedCars":
        """Rows of which nothing is known."""
        s = 3 + coefficients
        return cls(
            shape=np.full((n, coefficients), np.nan),
            yaw=np.full(n, np.nan),
            size=np.full((n, 3), np.nan),
            base=np.full((n, 3), np.nan),
            cov=np.full((n, s, s), np.nan),
            residual=np.full(n, np.nan),
            seen=np.zeros(n, np.int64),
            turned_gap=np.full(n, np.nan),
            fits=np.zeros(n, bool),
            trusted=np.zeros(n, bool),
        )

    def put(self, rows: Int[Array, " m"], found: "FittedCars") -> None:
        """Write fits into rows (while the table is being made)."""
        for column in fields(self):
            getattr(self, column.name)[rows] = getattr(found, column.name)

    @property
    def pose(self) -> Float[Array, "n 3"]:
        """The axis-angle vectors of eq. 6, in the road frame."""
        return self.yaw[:, None] * np.array([0.0, 1.0, 0.0])

    @property
    def pose_cov(self) -> Float[Array, "n c c"]:
        """The covariance of (yaw, coefficients)."""
        return self.cov[:, 2:, 2:]

    @property
    def cuboids(self) -> Cuboids:
        """The cars as boxes on the road."""
        return Cuboids(self.base, self.yaw, self.size)

    def onto(self, detections: Detections) -> Detections:
        """The detections with yaw, size, shape and covariance; NaN where the fit is not trusted.

        A car turned round is as large, so sizes are told of every car that fits.
        """
        if len(detections) != len(self):
            raise BadDetections(f"{len(self)} fits for {len(detections)} boxes: give one a box")
        columns = {"yaw": self.yaw, "shape": self.shape, "pose_cov": self.pose_cov}
        told = {name: _where(self.trusted, column) for name, column in columns.items()}
        return replace(detections, size=_where(self.fits, self.size), **told)


@dataclass(frozen=True, eq=False)
class ShapeFit:
    """Keypoints to shape, pose, size and place of cars that stand on the road."""

    model: CarModel = field(default_factory=_shipped)
    """What is known of cars: mean shape, coefficients and their deviations."""
    sigma: float = 2.0
    """Std of a keypoint at confidence 1, px, > 0; at confidence c its variance is 1 / c of that.
    More: the prior counts more."""
    min_confidence: float = 0.2
    """A point with less confidence was not seen, 0 < c <= 1; more: fewer points, fewer fits."""
    road_std: float = 0.05
    """How far a car may stand above or below the road plane, std in metres, > 0; more: less certain
    depths."""
    kernel: float = 4.0
    """Residuals beyond this many standard deviations weigh less and less, > 0; more: wrong
    keypoints pull more."""
    hypotheses: int = 4
    """How many yaws are followed, >= 1; more: fewer cars turned the wrong way round, more time."""
    max_residual: float = 1.6
    """A fit with a larger residual is not trusted, > 0; more: more fits, and more wrong ones."""
    max_yaw_std: float = 0.35
    """A fit with a larger std of its yaw is not trusted, rad, > 0; more: more fits, less exact
    ones."""
    max_depth_std: float = 0.25
    """A fit with a larger std of its depth is not trusted, share of the depth, > 0; more: more
    fits, less exact ones."""
    min_turned_gap: float = 1.5
    """A fit is not trusted whose log-likelihood falls by less than this where each point is taken
    for its counterpart of the car's other end, finite; more: fewer fits, and fewer turned round.
    1.5 keeps nine in ten of the right fits to drawn cars (`benchmarks.turned_fits`)."""

    def __post_init__(self) -> None:
        for name in ("sigma", "road_std", "kernel", "max_residual", "max_yaw_std", "max_depth_std"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise BadConfig(f"{name} {getattr(self, name):g}: give a finite number above 0")
        if not 0.0 < self.min_confidence <= 1.0:
            raise BadConfig(f"min_confidence {self.min_confidence:g}: give a share above 0, to 1")
        if not np.isfinite(self.min_turned_gap):
            raise BadConfig(f"min_turned_gap {self.min_turned_gap:g}: give a finite number")
        if self.hypotheses < 1:
            raise BadConfig(f"{self.hypotheses} hypotheses: at least one yaw must be followed")

    def __call__(
        self,
        keypoints: Float[Array, "n k 3"],
        camera: Camera,
        sigmas: Float[Array, "m 2"] | None = None,
    ) -> FittedCars:
        """The cars of keypoints u, v, confidence, in the order of the model's points.

        sigmas: std of u and v a car, pixels, in place of `sigma`; a row that is not positive
        (of a box without area) has no fit. Points that are not finite, far outside any image or
        without confidence were not seen; a car with
        fewer than four seen points has NaN everywhere and is not trusted. BadDetections for
        another number of points or of sigmas.
        """
        n, points = len(keypoints), len(self.model.basis.points)
        if keypoints.shape[1:] != (points, 3):
            raise BadDetections(
                f"keypoints of shape {keypoints.shape}: the prior has {points} points, "
                f"so give ({n}, {points}, 3): u, v, confidence"
            )
        if sigmas is None:
            sigmas = np.full((n, 2), self.sigma)
        elif len(sigmas) != n:
            raise BadDetections(f"{n} cars but {len(sigmas)} sigmas: give one row a car")
        confidence, count = self._confidence(keypoints, sigmas)
        fitted = FittedCars.unknown(n, self.model.basis.size)
        rows = np.flatnonzero(count >= MIN_KEYPOINTS)
        for start in range(0, len(rows), MAX_CARS_AT_ONCE):
            some = rows[start : start + MAX_CARS_AT_ONCE]
            fitted.put(some, self._fit(keypoints[some], confidence[some], sigmas[some], camera))
        return replace(fitted, seen=count)

    @cached_property
    def precision(self) -> Float[Array, " p"]:
        """1 / variance of each unknown's prior; 0: flat."""
        scale = self.model.scale_std
        flat_or_not = [0.0, self.road_std**-2, 0.0, 0.0, scale**-2 if scale else 0.0]
        return np.concatenate((flat_or_not, self.model.std**-2))

    @cached_property
    def free(self) -> Int[Array, " f"]:
        """The unknowns that are found: all, but the scale where the prior is in metres."""
        unknowns = np.arange(SHAPE + self.model.basis.size)
        return unknowns if self.model.scale_std else unknowns[unknowns != SCALE]

    @cached_property
    def turned(self) -> list[int] | None:
        """For each point of the model its counterpart on a car turned round; see the prior."""
        return turned_points(self.model.basis.points)

    def _confidence(
        self, keypoints: Float[Array, "n k 3"], sigmas: Float[Array, "n 2"]
    ) -> tuple[Float[Array, "n k"], Int[Array, " n"]]:
        """Confidences, 0 for points that were not seen, and the number of those that were."""
        usable = np.isfinite(keypoints[:, :, 2]) & (np.abs(keypoints[:, :, :2]) < MAX_PIXEL).all(
            axis=2
        )
        usable &= (np.isfinite(sigmas) & (sigmas > 0.0)).all(axis=1)[:, None]
        confidence = np.where(usable, keypoints[:, :, 2], 0.0)
        confidence = np.where(confidence >= self.min_confidence, np.minimum(confidence, 1.0), 0.0)
        return confidence, np.count_nonzero(confidence, axis=1)

    def _observed_points(
        self,
        keypoints: Float[Array, "n k 3"],
        confidence: Float[Array, "n k"],
        sigmas: Float[Array, "n 2"],
        camera: Camera,
    ) -> tuple[ObservedPoints, Rays]:
        """The seen points of every car, put together: those not seen cost no time."""
        most = int(np.count_nonzero(confidence, axis=1).max())
        chosen = np.argsort(-confidence, axis=1, kind="stable")[:, :most]
        conf = np.take_along_axis(confidence, chosen, axis=1)
        pixels = np.take_along_axis(keypoints[:, :, :2], chosen[:, :, None], axis=1)
        pixels = np.where(conf[:, :, None] > 0.0, pixels, 0.0)
        basis = self.model.basis
        mean = basis.mean[chosen]
        vectors = np.ascontiguousarray(
            basis.vectors.transpose(1, 2, 0)[chosen].transpose(0, 2, 3, 1)
        )
        weights = conf[:, None] / sigmas[:, :, None] ** 2
        P = camera.K @ camera.T_cam_road[:3]
        rays, centre = rays_to(pixels, camera)
        angle = np.sqrt(sigmas[:, 0] * sigmas[:, 1] / (camera.K[0, 0] * camera.K[1, 1]))
        around = Rays(rays, conf, mean, self.model.point_var[chosen], centre, angle)
        flat = (np.ascontiguousarray(part.transpose(0, 2, 1)) for part in (pixels, mean))
        return ObservedPoints(next(flat), weights, next(flat), vectors, P), around

    def _fit(
        self,
        keypoints: Float[Array, "n k 3"],
        confidence: Float[Array, "n k"],
        sigmas: Float[Array, "n 2"],
        camera: Camera,
    ) -> FittedCars:
        """Cars with enough points: scan, pose on the mean shape, pose and shape together."""
        n, seen = len(keypoints), confidence > 0.0
        observed, around = self._observed_points(keypoints, confidence, sigmas, camera)
        begin = starts(around, self.model, seen, self.hypotheses, len(self.precision))
        rows = np.repeat(np.arange(n), self.hypotheses)
        cars = begin.reshape(len(rows), -1)
        # On the mean shape a point is off by what cars differ, too.
        px_per_m = np.sqrt(camera.K[0, 0] * camera.K[1, 1]) / np.maximum(cars[:, Z], 2.0)
        blur = around.var.take(rows, axis=0) * px_per_m[:, None] ** 2
        given = observed.rows(rows)
        inflation = 1.0 + blur * given.weights.mean(axis=1)
        softened = given.weighted(given.weights / inflation[:, None])
        width = np.full(inflation.shape, self.kernel)
        pose = self.free[self.free < SHAPE]
        first = solve(softened, cars, pose, self.precision, width, POSE_STEPS, START_TOLERANCE)
        kept = self._likeliest(first, rows, seen, around.centre, 2)
        wide = self.kernel * np.sqrt(inflation[kept])
        cars, both = first.cars[kept], given.rows(kept)
        second = solve(both, cars, self.free, self.precision, wide, JOINT_STEPS, START_TOLERANCE)
        kept = self._likeliest(second, rows[kept], seen, around.centre, 1)
        cars, width = second.cars[kept], width[: len(kept)]
        last = solve(observed, cars, self.free, self.precision, width, LAST_STEPS)
        gap = np.full(n, np.inf)
        if self.turned is not None:
            swapped = keypoints[:, self.turned], confidence[:, self.turned]
            around_it, _ = self._observed_points(*swapped, sigmas, camera)
            cars = last.cars.copy()
            cars[:, YAW] += np.pi
            cars[:, SHAPE:] = 0.0
            other = solve(
                around_it, cars, self.free, self.precision, width, JOINT_STEPS, START_TOLERANCE
            )
            gap = other.cost - last.cost
        return self._result(last, np.count_nonzero(seen, axis=1), gap)

    def _likeliest(
        self,
        solved: Solved,
        rows: Int[Array, " r"],
        seen: Bool[Array, "n k"],
        centre: Float[Array, "3"],
        count: int,
    ) -> Int[Array, " s"]:
        """Which hypotheses to keep: of every car at most `count`, none that is out of the race.

        rows: the car of each hypothesis, in ascending order; so are those of the kept.
        """
        cars = solved.cars
        chance = visibility_score(
            self.model, seen[rows], cars[:, None, YAW], cars[:, None, [X, Z]], centre
        )
        score = solved.cost - chance[:, 0]
        order = np.lexsort((score, rows))
        begins = np.flatnonzero(np.diff(rows, prepend=-1))  # of each car, in `rows` and in `order`
        which = np.cumsum(np.diff(rows, prepend=-1) > 0) - 1
        rank = np.arange(len(rows)) - begins[which]
        behind = score[order] - score[order[begins]][which]
        return order[(rank == 0) | ((rank < count) & (behind < MAX_LOG_LIKELIHOOD_GAP))]

    def _result(
        self, solved: Solved, seen: Int[Array, " n"], gap: Float[Array, " n"]
    ) -> FittedCars:
        """The fitted cars as a table."""
        cars, model = solved.cars, self.model
        order = [int(np.flatnonzero(self.free == column)[0]) for column in COV_ORDER]
        shape = np.flatnonzero(self.free >= SHAPE)
        chosen = np.concatenate((order, shape)).astype(np.int64)
        cov = inverses(solved.normal)[:, chosen[:, None], chosen]
        # 2 numbers a point, of which four are spent on the pose; the priors pay for the rest.
        residual = np.sqrt(2.0 * solved.cost / np.maximum(2.0 * seen - 3.0, 1.0))
        depth_std = np.sqrt(np.maximum(cov[:, 1, 1], 0.0)) / np.abs(cars[:, Z])
        fits = np.isfinite(cov).all(axis=(1, 2)) & np.isfinite(cars).all(axis=1)
        fits &= (residual <= self.max_residual) & (cars[:, Z] > 0.0)
        fits &= (cov[:, 2, 2] <= self.max_yaw_std**2) & (depth_std <= self.max_depth_std)
        return FittedCars(
            shape=cars[:, SHAPE:],
            yaw=np.asarray(wrap_angle(cars[:, YAW])),
            size=model.size(cars[:, SHAPE:], np.exp(cars[:, SCALE])),
            base=cars[:, X : Z + 1],
            cov=cov,
            residual=residual,
            seen=seen,
            turned_gap=gap,
            fits=fits,
            trusted=fits & (gap >= self.min_turned_gap),
        )


def _where(rows: Bool[Array, " n"], column: Float[Array, "n *s"]) -> Float[Array, "n *s"]:
    """A column with NaN outside the rows."""
    return np.where(rows.reshape(-1, *[1] * (column.ndim - 1)), column, np.nan)


def no_car_fits(
    fitted: FittedCars, max_residual: float = 2.5, min_seen: int = 4
) -> Bool[Array, " n"]:
    """Which boxes hold no car, as the paper discards false detections: no car fits their points.

    Only boxes with at least `min_seen` points are judged: of the others nothing is known.
    max_residual: looser than what is asked of a trusted fit, so that a true car of which a
    detector put some points wrong is not thrown away (`benchmarks.shape_fit` prints both losses).
    """
    return (fitted.seen >= min_seen) & ~(fitted.residual <= max_residual)
