"""Doors of the effects: numbers that no noise can have are refused, with value and cure."""

from collections.abc import Sequence
from itertools import pairwise
from math import isfinite

from tracker.errors import BadConfig


def require_rates(what: str, *rates: float) -> None:
    """BadConfig unless every rate is a probability."""
    for rate in rates:
        if not 0.0 <= rate <= 1.0:
            raise BadConfig(f"{what}: a rate of {rate:g}; rates lie in [0, 1]")


def require_sigmas(what: str, *sigmas: float) -> None:
    """BadConfig unless every spread (or duration, or level) is finite and not negative."""
    for sigma in sigmas:
        if not (isfinite(sigma) and sigma >= 0.0):
            raise BadConfig(f"{what}: {sigma:g}; spreads and levels are finite, 0 (none) or more")


def require_finite(what: str, *numbers: float) -> None:
    """BadConfig unless every number is finite."""
    for number in numbers:
        if not isfinite(number):
            raise BadConfig(f"{what}: {number:g} is not finite")


def require_table(what: str, knots: Sequence[float], values: Sequence[float]) -> None:
    """BadConfig unless there is a finite value for every knot."""
    if len(knots) != len(values):
        raise BadConfig(
            f"{what}: {len(values)} numbers; give {len(knots)}, one for each of {knots}"
        )
    require_finite(what, *values)


def require_rising(what: str, values: Sequence[float], least: int = 2) -> None:
    """BadConfig unless the numbers are finite, enough, and never fall (quantiles)."""
    require_finite(what, *values)
    if len(values) < least or any(b < a for a, b in pairwise(values)):
        raise BadConfig(f"{what}: {list(values)}: give {least} numbers or more that never fall")
