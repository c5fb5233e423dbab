"""What measured yaws and sizes tell of the cars behind boxes: their noise, and front for rear."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.car_filter.states import LOG_SIZE, YAW
from tracker.errors import BadConfig
from tracker.geometry import wrap_angle
from tracker.types import Detections
from tracker.types.rows import Rows

# The columns of sizes in a state, one by one.
SIZE_COLUMNS = range(LOG_SIZE.start, LOG_SIZE.stop)


@dataclass(frozen=True, eq=False)
class CarCues(Rows):
    """Yaws and sizes that were measured of cars; NaN rows: they were not."""

    yaw: Float[Array, " n"]
    """About road +y, rad."""
    yaw_var: Float[Array, " n"]
    """Its variance as the detector states it, rad^2; NaN: it does not."""
    log_size: Float[Array, "n 3"]
    """Logarithms of length, height and width, m."""

    @classmethod
    def of(cls, detections: Detections) -> "CarCues | None":
        """Those of detections; None where nothing measures yaw or size."""
        yaw, size, cov = detections.yaw, detections.size, detections.pose_cov
        if yaw is None and size is None:
            return None
        unknown = np.full(len(detections), np.nan)
        return cls(
            unknown if yaw is None else yaw,
            unknown if cov is None else cov[:, 0, 0],
            np.full((len(detections), 3), np.nan) if size is None else np.log(size),
        )


@dataclass(frozen=True)
class CueModel:
    """The noise of measured yaws and sizes; defaults fit the shipped network's on KITTI."""

    yaw_std: float = 0.1
    """Std of a yaw whose detector states none, rad; more: yaws weigh less."""
    yaw_factor: float = 1.4
    """How much larger the std of yaws is than stated; more: stated yaws weigh less."""
    yaw_floor: float = 0.03
    """What yaws are off by besides, rad; more: exact yaws weigh less."""
    turned_share: float = 0.12
    """How often front is taken for rear, so the yaw is off by half a turn, 0 to 1/2; more: the
    direction is left to motion and to the traffic."""
    hidden_turned_share: float = 0.35
    """The same where another box hides a side of the car."""
    wrong_share: float = 0.1
    """How often a yaw tells nothing at all, 0 to 1; more: yaws that do not fit count less."""
    size_std: tuple[float, float, float] = (0.12, 0.1, 0.07)
    """Stds of measured lengths, heights and widths, shares of them; more: they weigh less."""
    repetition: float = 5.0
    """How many readings of one car tell as much as one, after the first: their errors are alike.
    More: the first reading counts more against the later ones."""
    evidence: float = 0.3
    """How much of the log-likelihood of a later reading counts for the hypotheses, 0 to 1; less:
    the direction of the first reading stays longer."""

    def __post_init__(self) -> None:
        for name in ("turned_share", "hidden_turned_share"):
            if not 0.0 <= getattr(self, name) <= 0.5:
                raise BadConfig(f"{name} {getattr(self, name):g}: give a share, 0 to 0.5")
        if not 0.0 < self.wrong_share < 1.0:
            raise BadConfig(f"wrong_share {self.wrong_share:g}: give a share between 0 and 1")

    def __call__(
        self,
        means: Float[Array, "h 9"],
        covs: Float[Array, "h 9 9"],
        cues: CarCues,
        hidden: Bool[Array, " h"],
        is_first: bool,
    ) -> tuple[Float[Array, "h 9"], Float[Array, "h 9 9"], Float[Array, " h"]]:
        """Hypotheses after the cues of their cars, and what those count for each, nats.

        cues, hidden: row by row the hypotheses' own. is_first: nothing was read before.
        """
        repetition, evidence = (1.0, 1.0) if is_first else (self.repetition, self.evidence)
        means, covs, fit = means.copy(), covs.copy(), np.zeros(len(means))
        known = np.isfinite(cues.yaw).nonzero()[0]
        if len(known):
            some = means[known], covs[known], cues.select(known), hidden[known], repetition
            means[known], covs[known], fit[known] = self._yaw(*some)
            fit *= evidence
        known = np.isfinite(cues.log_size).all(axis=1).nonzero()[0]
        if len(known):
            mean, cov = means[known], covs[known]
            step = np.zeros_like(mean)
            for column, std in zip(SIZE_COLUMNS, self.size_std, strict=True):
                off = cues.log_size[known, column - LOG_SIZE.start] - mean[:, column]
                cov = _corrected(cov, step, column, off, repetition * std**2)
            means[known], covs[known] = mean + step, cov
        return means, covs, fit

    def _yaw(
        self,
        means: Float[Array, "h 9"],
        covs: Float[Array, "h 9 9"],
        cues: CarCues,
        hidden: Bool[Array, " h"],
        repetition: float,
    ) -> tuple[Float[Array, "h 9"], Float[Array, "h 9 9"], Float[Array, " h"]]:
        """Hypotheses after yaws that are right, off by half a turn, or tell nothing; how likely.

        Each hypothesis follows the yaw in the direction that it faces itself, as far as the yaw
        tells something.
        """
        var = np.where(np.isnan(cues.yaw_var), self.yaw_std**2, self.yaw_factor**2 * cues.yaw_var)
        var = repetition * (var + self.yaw_floor**2)
        total = covs[:, YAW, YAW] + var
        off = np.asarray(wrap_angle(cues.yaw - means[:, YAW]))
        turned = np.where(hidden, self.hidden_turned_share, self.turned_share)
        is_opposite = np.abs(off) > 0.5 * np.pi
        folded = np.where(is_opposite, wrap_angle(off - np.pi), off)
        share = (1.0 - self.wrong_share) * np.where(is_opposite, turned, 1.0 - turned)
        told = share * np.exp(-0.5 * folded**2 / total) / np.sqrt(2.0 * np.pi * total)
        likelihood = told + self.wrong_share / (2.0 * np.pi)
        step = np.zeros_like(means)
        # a yaw that tells something with probability p: its variance over p
        trust = np.maximum(told / likelihood, 1e-6)
        covs = _corrected(covs, step, YAW, folded, total / trust - covs[:, YAW, YAW])
        return means + step, covs, np.log(likelihood)


def _corrected(
    covs: Float[Array, "h 9 9"],
    step: Float[Array, "h 9"],
    column: int,
    off: Float[Array, " h"],
    var: Float[Array, " h"] | float,
) -> Float[Array, "h 9 9"]:
    """Covariances after a direct measurement of a column; its correction is added to `step`.

    off: the measurement less the mean.
    """
    Ph = covs[:, :, column]
    gain = Ph / (covs[:, column, column] + var)[:, None]
    step += gain * (off - step[:, column])[:, None]
    corrected: Float[Array, "h 9 9"] = covs - gain[:, :, None] * Ph[:, None, :]
    return corrected
