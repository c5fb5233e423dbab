"""How sure the detector says it is: less of hidden and small cars, and flickering over time."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array
from scipy.special import expit

from mot_sim.simulation.sensors.checks import (
    require_finite,
    require_rates,
    require_rising,
    require_table,
)
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals
from mot_sim.simulation.sensors.misses import (
    HEIGHT_KNOTS,
    LOG_HEIGHT_KNOTS,
    TRUNCATION_KNOTS,
    VISIBLE_KNOTS,
    truncation_growth,
)
from mot_sim.simulation.sensors.sightings import Sightings


@dataclass(frozen=True)
class ScoreNoise:
    """A latent y, the sum of all parts and noise, mapped from y_knots to log_odds.

    The map is monotone, so that the marginal distribution is free: detectors put most of their
    boxes at their highest score.
    """

    y_knots: tuple[float, ...]
    """Values of y, two or more that never fall."""
    log_odds: tuple[float, ...]
    """Log-odds of the score at each of `y_knots`, never falling; higher: surer scores."""
    by_visible: tuple[float, ...] = (0.0,) * len(VISIBLE_KNOTS)
    """Part of y at each visible fraction of VISIBLE_KNOTS."""
    by_height: tuple[float, ...] = (0.0,) * len(HEIGHT_KNOTS)
    """Part of y at each box height of HEIGHT_KNOTS, pixels."""
    by_truncation: tuple[float, ...] = (0.0,) * len(TRUNCATION_KNOTS)
    """Part of y at each truncation of TRUNCATION_KNOTS."""
    truncation_by_height: tuple[float, ...] = (0.0,) * len(TRUNCATION_KNOTS)
    """`by_truncation` grows by it times log(height / 100 px), -2 to 1, at each truncation."""
    other_kinds: float = 0.0
    """Part of y of vans and trucks; lower: less sure of them."""
    unlabelled: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Part of y of cars before their first label, after their last one, and of both in DontCare
    regions (see `Lives`); lower: less sure of them."""
    coupling: float = 0.0
    """Correlation, 0 to 1, of the noise with how nearly the object was missed; more: low scores
    just before and after misses."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How the rest of the noise is correlated over time; slower: scores flicker less."""

    def __post_init__(self) -> None:
        require_rising("scores y_knots", self.y_knots)
        require_rising("scores log_odds", self.log_odds)
        require_table("scores log_odds", self.y_knots, self.log_odds)
        require_table("scores by_visible", VISIBLE_KNOTS, self.by_visible)
        require_table("scores by_height", HEIGHT_KNOTS, self.by_height)
        require_table("scores by_truncation", TRUNCATION_KNOTS, self.by_truncation)
        require_table("scores truncation_by_height", TRUNCATION_KNOTS, self.truncation_by_height)
        require_table("scores unlabelled", (1.0, 2.0, 3.0), self.unlabelled)
        require_finite("scores other_kinds", self.other_kinds)
        require_rates("scores coupling", self.coupling)

    def mean(self, sightings: Sightings) -> Float[Array, " n"]:
        """The latent without its noise."""
        height = np.log(np.maximum(sightings.height, 1.0))
        y = np.interp(sightings.visible, VISIBLE_KNOTS, self.by_visible)
        y += np.interp(height, LOG_HEIGHT_KNOTS, self.by_height)
        if sightings.truncation.any():
            growth = np.interp(sightings.truncation, TRUNCATION_KNOTS, self.truncation_by_height)
            y += np.interp(sightings.truncation, TRUNCATION_KNOTS, self.by_truncation)
            y += growth * truncation_growth(sightings)
        if self.other_kinds != 0.0:
            y += self.other_kinds * (sightings.kinds != "Car")
        if sightings.unlabelled is not None:
            y += np.array([0.0, *self.unlabelled])[sightings.unlabelled]
        return y

    def __call__(
        self,
        sightings: Sightings,
        ease: Float[Array, " n"],
        seed: int,
        step: float,
        level: float = 1.0,
    ) -> Float[Array, " n"]:
        """Probabilities in [0, 1]: 1 - level * the model's score_shift. ease: see `Misses`."""
        if level == 0.0:
            return np.ones(len(sightings))
        own = correlated_normals(
            seed, "score", sightings.ids, sightings.frames, self.autocorrelation, step
        )[:, 0]
        noise = self.coupling * ease + np.sqrt(1.0 - self.coupling**2) * own
        odds = np.interp(self.mean(sightings) + noise, self.y_knots, self.log_odds)
        if level == 1.0:
            return expit(odds)
        return (1.0 - level * expit(-odds)).clip(0.0, 1.0)
