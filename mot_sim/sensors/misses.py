"""Cars that the detector does not see: small, hidden or cut ones, in bursts, or a whole frame."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array
from scipy.special import expit, ndtri

from mot_sim.sensors.bursts import pressure
from mot_sim.sensors.checks import require_finite, require_rates, require_sigmas, require_table
from mot_sim.sensors.memory import Memory
from mot_sim.sensors.sightings import Sightings

# Where the log-odds of being found are given; straight lines between, level outside.
VISIBLE = (0.05, 0.35, 0.65, 0.95)
HEIGHTS = (15.0, 20.0, 25.0, 35.0, 60.0, 120.0)  # pixels
CUTS = (0.0, 0.2, 0.6)


@dataclass(frozen=True)
class Misses:
    """Log-odds of being found: base + by_visible + by_height + by_cut + by_both, all tables.

    by_both: visible fraction by height, row after row: what the two do together beyond their sum.
    memory: of the latent that makes bursts. shared: the part of it that all objects of a frame
    share (glare, blur), over shared_seconds.
    """

    base: float
    by_visible: tuple[float, ...] = (0.0,) * len(VISIBLE)
    by_height: tuple[float, ...] = (0.0,) * len(HEIGHTS)
    by_cut: tuple[float, ...] = (0.0,) * len(CUTS)
    by_both: tuple[float, ...] = (0.0,) * (len(VISIBLE) * len(HEIGHTS))
    memory: Memory = field(default_factory=Memory)
    shared: float = 0.0
    shared_seconds: float = 0.0

    def __post_init__(self) -> None:
        require_finite("misses base", self.base)
        require_table("misses by_visible", VISIBLE, self.by_visible)
        require_table("misses by_height", HEIGHTS, self.by_height)
        require_table("misses by_cut", CUTS, self.by_cut)
        require_table("misses by_both", VISIBLE * len(HEIGHTS), self.by_both)
        require_rates("misses shared", self.shared)
        require_sigmas("misses shared_seconds", self.shared_seconds)

    def rates(self, sightings: Sightings, level: float = 1.0) -> Float[Array, " n"]:
        """level * the probability of going unseen, at most 1; 1 where no pixel is visible."""
        heights = hat(np.log(np.maximum(sightings.height, 1.0)), tuple(np.log(HEIGHTS)))
        visible = hat(sightings.visible, VISIBLE)
        both = np.array(self.by_both).reshape(len(VISIBLE), len(HEIGHTS))
        odds = (
            self.base
            + visible @ np.array(self.by_visible)
            + heights @ np.array(self.by_height)
            + ((visible @ both) * heights).sum(axis=1)
            + np.interp(sightings.cut, CUTS, self.by_cut)
        )
        return np.where(sightings.visible <= 0.0, 1.0, np.minimum(level * expit(-odds), 1.0))

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> tuple[Bool[Array, " n"], Float[Array, " n"]]:
        """Who goes unseen; and how well each of the others was seen, a standard normal number.

        The second couples scores to misses: low just before and after a burst.
        """
        rates = self.rates(sightings, level)
        under = pressure(
            seed, "miss", sightings.ids, sightings.frames, self.memory, step,
            self.shared, self.shared_seconds,
        )  # fmt: skip
        missed = under < rates
        ease = (under - rates) / np.maximum(1.0 - rates, 1e-12)
        return missed, ndtri(ease.clip(1e-12, 1.0 - 1e-12))


def hat(values: Float[Array, " n"], knots: tuple[float, ...]) -> Float[Array, "n k"]:
    """What each knot's number weighs in the straight line between knots; level outside."""
    return np.stack([np.interp(values, knots, row) for row in np.eye(len(knots))], axis=1)
