"""Which cars the detector does not see, and which vans and trucks it takes for cars."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array
from scipy.special import expit, ndtr, ndtri

from mot_sim.simulation.sensors.checks import (
    require_finite,
    require_rates,
    require_sigmas,
    require_table,
)
from mot_sim.simulation.sensors.correlated_noise import (
    Autocorrelation,
    bursts,
    correlated_normal_columns,
    with_frame_noise,
)
from mot_sim.simulation.sensors.sightings import Sightings

# Where the log-odds of being found are given; straight lines between, level outside.
VISIBLE_KNOTS = (0.05, 0.35, 0.65, 0.95)
HEIGHT_KNOTS = (15.0, 20.0, 25.0, 35.0, 60.0, 120.0)  # pixels
LOG_HEIGHT_KNOTS = np.log(HEIGHT_KNOTS)
TRUNCATION_KNOTS = (0.0, 0.2, 0.6)


@dataclass(frozen=True)
class Misses:
    """Log-odds of being found: base + by_visible + by_height + by_truncation + by_both, all tables.

    Higher log-odds mean fewer misses. Between the knots of a table run straight lines.
    """

    base: float
    """Log-odds that every object has, finite."""
    by_visible: tuple[float, ...] = (0.0,) * len(VISIBLE_KNOTS)
    """What is added at each visible fraction of VISIBLE_KNOTS."""
    by_height: tuple[float, ...] = (0.0,) * len(HEIGHT_KNOTS)
    """What is added at each box height of HEIGHT_KNOTS, pixels."""
    by_truncation: tuple[float, ...] = (0.0,) * len(TRUNCATION_KNOTS)
    """What is added at each truncation of TRUNCATION_KNOTS."""
    by_both: tuple[float, ...] = (0.0,) * (len(VISIBLE_KNOTS) * len(HEIGHT_KNOTS))
    """Visible fraction by height, row after row: what the two do together beyond their sum."""
    truncation_by_height: tuple[float, ...] = (0.0,) * len(TRUNCATION_KNOTS)
    """`by_truncation` grows by it times log(height / 100 px), -2 to 1, at each truncation."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How the noise behind a car's misses is correlated over time; slower: fewer, longer gaps."""
    flutter: tuple[float, ...] = (0.0,) * len(VISIBLE_KNOTS)
    """Share of the noise, 0 to 1 at each visible fraction, that follows `flutter_autocorrelation`
    instead: what hides a car changes."""
    flutter_autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How that share is correlated over time; slower: longer gaps of hidden cars."""
    shared: float = 0.0
    """Share of the noise that all objects of a frame have in common (glare, blur), 0 to 1; more:
    many are missed at once."""
    shared_seconds: float = 0.0
    """How long the common share lasts, seconds, >= 0; more: longer gaps of all objects."""

    def __post_init__(self) -> None:
        require_finite("misses base", self.base)
        require_table("misses by_visible", VISIBLE_KNOTS, self.by_visible)
        require_table("misses by_height", HEIGHT_KNOTS, self.by_height)
        require_table("misses by_cut", TRUNCATION_KNOTS, self.by_truncation)
        require_table("misses by_both", VISIBLE_KNOTS * len(HEIGHT_KNOTS), self.by_both)
        require_table("misses cut_by_height", TRUNCATION_KNOTS, self.truncation_by_height)
        require_table("misses flutter", VISIBLE_KNOTS, self.flutter)
        require_rates("misses shared, flutter", self.shared, *self.flutter)
        require_sigmas("misses shared_seconds", self.shared_seconds)

    def rates(self, sightings: Sightings, level: float = 1.0) -> Float[Array, " n"]:
        """level * the probability of going unseen, at most 1; 1 where no pixel is visible."""
        odds = self._between(sightings.visible, np.log(np.maximum(sightings.height, 1.0)))
        if sightings.truncation.any():
            odds += np.interp(sightings.truncation, TRUNCATION_KNOTS, self.by_truncation)
            odds += np.interp(
                sightings.truncation, TRUNCATION_KNOTS, self.truncation_by_height
            ) * truncation_growth(sightings)
        return np.where(sightings.visible <= 0.0, 1.0, np.minimum(level * expit(-odds), 1.0))

    @property
    def autocorrelations(self) -> tuple[Autocorrelation, Autocorrelation]:
        """Of what is the car's own, and of what flutters."""
        return self.autocorrelation, self.flutter_autocorrelation

    def _between(
        self, visible: Float[Array, " n"], log_height: Float[Array, " n"]
    ) -> Float[Array, " n"]:
        """The log-odds of an uncut car: straight lines between the knots, both ways."""
        v = np.interp(visible, VISIBLE_KNOTS, np.arange(len(VISIBLE_KNOTS)))
        h = np.interp(log_height, LOG_HEIGHT_KNOTS, np.arange(len(HEIGHT_KNOTS)))
        row = v.astype(np.int64).clip(max=len(VISIBLE_KNOTS) - 2)
        column = h.astype(np.int64).clip(max=len(HEIGHT_KNOTS) - 2)
        v, h = v - row, h - column
        table = self._table
        low = (1.0 - h) * table[row, column] + h * table[row, column + 1]
        high = (1.0 - h) * table[row + 1, column] + h * table[row + 1, column + 1]
        return (1.0 - v) * low + v * high

    @cached_property
    def _table(self) -> Float[Array, "v h"]:
        """The log-odds at the knots."""
        both = np.array(self.by_both).reshape(len(VISIBLE_KNOTS), len(HEIGHT_KNOTS))
        return self.base + np.array(self.by_visible)[:, None] + np.array(self.by_height) + both

    def __call__(
        self, sightings: Sightings, seed: int, step: float, level: float = 1.0
    ) -> tuple[Bool[Array, " n"], Float[Array, " n"]]:
        """Who goes unseen; and how well each of the others was seen, a standard normal number.

        The second couples scores to misses: low just before and after a burst.
        """
        rates = self.rates(sightings, level)
        under = ndtr(self._pressure(sightings, seed, step))
        missed = under < rates
        ease = (under - rates) / np.maximum(1.0 - rates, 1e-12)
        return missed, ndtri(ease.clip(1e-12, 1.0 - 1e-12))

    def _pressure(self, sightings: Sightings, seed: int, step: float) -> Float[Array, " n"]:
        """One correlated standard normal number per row; low ones are missed."""
        ids, frames = sightings.ids, sightings.frames
        own, fast = correlated_normal_columns(
            seed, "miss", ids, frames, self.autocorrelations, step
        ).T
        share = np.interp(sightings.visible, VISIBLE_KNOTS, self.flutter)
        own = np.sqrt(1.0 - share) * own + np.sqrt(share) * fast
        return with_frame_noise(own, seed, "miss", frames, self.shared, self.shared_seconds, step)


def truncation_growth(sightings: Sightings) -> Float[Array, " n"]:
    """What `truncation_by_height` is multiplied with: near cars leave the image fast."""
    return np.log(np.maximum(sightings.height, 5.0) / 100.0).clip(-2.0, 1.0)


def hat_functions(values: Float[Array, " n"], knots: tuple[float, ...]) -> Float[Array, "n k"]:
    """What each knot's number weighs in the straight line between knots; level outside."""
    return np.stack([np.interp(values, knots, row) for row in np.eye(len(knots))], axis=1)


@dataclass(frozen=True)
class Confusion:
    """The rates at which other vehicles are reported as cars."""

    van: float = 0.0
    """Rate of vans reported as cars, 0 to 1; more: more vans in the detections."""
    truck: float = 0.0
    """Rate of trucks reported as cars, 0 to 1; more: more trucks in the detections."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How verdicts are correlated over time; slower: a verdict lasts longer."""

    def __post_init__(self) -> None:
        require_rates("confusion", self.van, self.truck)

    def __call__(self, sightings: Sightings, seed: int, step: float) -> Bool[Array, " n"]:
        """Whose kind the detector reports; cars always."""
        are_cars = sightings.kinds == "Car"
        if are_cars.all():
            return np.asarray(are_cars)
        rates = np.select(
            [sightings.kinds == "Van", sightings.kinds == "Truck"], [self.van, self.truck], 0.0
        )
        frames, ids = sightings.frames, sightings.ids
        taken = bursts(rates, seed, "confusion", ids, frames, self.autocorrelation, step)
        return taken | are_cars
