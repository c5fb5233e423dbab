"""How strongly two thresholded normal latents are correlated, from the counts of their events."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.optimize import brentq, nnls
from scipy.special import ndtr, ndtri

from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlation_after
from tracker.types import Rows

LEGENDRE_NODES, LEGENDRE_WEIGHTS = np.polynomial.legendre.leggauss(20)
MIN_CORRELATION = -0.5
MAX_CORRELATION = 0.995
ROUGH_SECONDS = (0.0, 0.12, 0.4, 1.2, 4.0, 15.0)  # seconds: what a latent is mixed of
SMOOTH_SECONDS = (0.12, 0.25, 0.5, 1.2)  # seconds: of its smooth parts
MAX_PAIRS = 20_000  # more tell nothing new and cost time


def both_below(
    a: Float[Array, " n"], b: Float[Array, " n"], correlation: float
) -> Float[Array, " n"]:
    """P(x < a, y < b) of standard normal x, y (Sheppard's integral, by Gauss and Legendre)."""
    half = 0.5 * np.arcsin(correlation)
    angle = half * (LEGENDRE_NODES + 1.0)
    sine, cosine = np.sin(angle), np.cos(angle)
    square = (a**2 + b**2)[:, None]
    exponent = -(square - 2.0 * (a * b)[:, None] * sine) / (2.0 * cosine**2)
    return ndtr(a) * ndtr(b) + half / (2.0 * np.pi) * (np.exp(exponent) @ LEGENDRE_WEIGHTS)


def correlation_of(
    a_rates: Float[Array, " n"],
    b_rates: Float[Array, " n"],
    a: Bool[Array, " n"],
    b: Bool[Array, " n"],
) -> float:
    """The latents' correlation at which as many pairs have ONE of both events; NaN without pairs.

    a_rates, b_rates: the probability of each event, a row a pair. Counting changes (and not
    pairs with both) makes the number of bursts come out even where the rates are a little off.
    """
    rates = np.stack((a_rates, b_rates)).clip(1e-9, 1.0 - 1e-9)
    changes = float((a != b).sum())
    if rates.shape[1] > MAX_PAIRS:
        chosen = np.linspace(0, rates.shape[1] - 1, MAX_PAIRS).astype(int)
        changes *= MAX_PAIRS / rates.shape[1]
        rates = rates[:, chosen]
    x, y = ndtri(rates)
    total = float(rates.sum())

    def excess(correlation: float) -> float:
        return total - 2.0 * float(both_below(x, y, correlation).sum()) - changes

    if not len(x):
        return float("nan")
    if excess(MAX_CORRELATION) >= 0.0:
        return MAX_CORRELATION
    if excess(MIN_CORRELATION) <= 0.0:
        return MIN_CORRELATION
    return float(brentq(excess, MIN_CORRELATION, MAX_CORRELATION, xtol=1e-3))


@dataclass(frozen=True, eq=False)
class RatedEvents(Rows):
    """Events and their known rates: one row per object and frame."""

    happens: Bool[Array, " n"]
    """Whether the event happens."""
    rates: Float[Array, " n"]
    """Probability at which it does, 0 to 1."""
    ids: Int[Array, " n"]
    """The object."""
    frames: Int[Array, " n"]
    """The frame."""

    def latent_correlation(self, first: Int[Array, " k"], second: Int[Array, " k"]) -> float:
        """Of the latents of pairs of rows; NaN without pairs."""
        rates, happens = self.rates, self.happens
        return correlation_of(rates[first], rates[second], happens[first], happens[second])


def nearest_autocorrelation(
    seconds: Sequence[float | int],
    correlations: Sequence[float],
    weights: Sequence[float | int],
    longest: float = ROUGH_SECONDS[-1],
    smooth: bool = False,
) -> Autocorrelation:
    """The mixture of autocorrelations, none over `longest`, with the nearest autocorrelation.

    smooth: it may have smooth parts.
    """
    known = np.isfinite(correlations)
    t, rho = np.array(seconds)[known], np.array(correlations)[known]
    weight = np.sqrt(np.array(weights, dtype=float)[known])
    weight = weight / max(weight.sum(), 1e-9)
    parts = [(tau, False) for tau in ROUGH_SECONDS if tau <= longest]
    parts += [(tau, True) for tau in SMOOTH_SECONDS if smooth and tau <= longest]
    design = np.array([[correlation_after(each, *part) for part in parts] for each in t.tolist()])
    design = design.reshape(len(t), len(parts))
    whole = 100.0 * np.ones((1, len(parts)))  # the shares add up to 1
    shares, _ = nnls(
        np.concatenate((design * weight[:, None], whole)), np.append(rho * weight, 100.0)
    )
    shares = np.round(shares / shares.sum(), 4)
    shares[np.argmax(shares)] += 1.0 - shares.sum()
    rows = np.flatnonzero(shares > 0.0).tolist()
    kinds = tuple(float(parts[row][1]) for row in rows)
    return Autocorrelation(
        tuple(shares[rows].tolist()),
        tuple(parts[row][0] for row in rows),
        kinds if any(kinds) else (),
    )
