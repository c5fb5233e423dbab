"""What measured yaws and sizes tell of the cars behind boxes: their noise, and front for rear."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.car_filter.states import MIN_LOG_WEIGHT, CarStates
from tracker.errors import BadConfig
from tracker.kernels import Kernel
from tracker.types import Detections
from tracker.types.rows import Rows

READ_CUES = Kernel("tracker.kernels.car_cues", "read_cues")


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
        self, states: CarStates, cues: CarCues, hidden: Bool[Array, " n"], is_first: bool
    ) -> tuple[CarStates, Float[Array, "n k"]]:
        """Cars after these cues of theirs, and what those count for each hypothesis, nats.

        Each hypothesis follows the yaw in the direction that it faces itself, as far as the yaw
        tells something: it is right, off by half a turn, or wrong. hidden: whether another box
        hides a side of the car. is_first: nothing was read before.
        """
        repetition, evidence = (1.0, 1.0) if is_first else (self.repetition, self.evidence)
        out = np.empty(states.means.shape), np.empty(states.covs.shape)
        told = np.empty(states.log_weights.shape)
        before = states.means, states.covs, states.log_weights, MIN_LOG_WEIGHT
        seen = cues.yaw, cues.yaw_var, cues.log_size, hidden
        READ_CUES(*before, *seen, *self._noise, repetition, evidence, *out, told, np.empty(18))
        return CarStates(*out, states.log_weights), told

    @cached_property
    def _noise(self) -> tuple[Float[Array, "2"], Float[Array, "4"], Float[Array, "3"]]:
        """Shares of turned yaws, what else is known of yaws, variances of sizes."""
        of_yaws = self.yaw_std**2, self.yaw_factor**2, self.yaw_floor**2, self.wrong_share
        turned = self.turned_share, self.hidden_turned_share
        return np.array(turned), np.array(of_yaws), np.array([std**2 for std in self.size_std])
