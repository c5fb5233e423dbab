"""A mean over seeds with its 95 % interval, clipped to what is possible."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf, sqrt

from jaxtyping import Float
from numpy import ndarray as Array

CONFIDENCE = 0.95
MIN_SEEDS = 5  # with fewer, an interval says little
UNLIMITED = (-inf, inf)


@dataclass(frozen=True)
class Interval:
    """A mean over seeds with its 95 % interval.

    Student's t: mean ± t(count - 1) * std / sqrt(count). It holds for the mean over seeds of
    this scene, not for a single run.
    """

    mean: float | None
    """The mean; None: of nothing."""
    low: float | None
    """Lower end of the interval, clipped to what is possible; None: fewer than two seeds."""
    high: float | None
    """Upper end, likewise."""
    count: int
    """Number of seeds."""

    @classmethod
    def of(cls, values: Float[Array, " n"], limits: tuple[float, float] = UNLIMITED) -> "Interval":
        """Of the values of the seeds. limits: the least and the most that a mean can be."""
        count = len(values)
        if count == 0:
            return NO_INTERVAL
        mean = float(values.mean())
        if count == 1:
            return cls(mean, None, None, 1)
        half = student(count) * float(values.std(ddof=1)) / sqrt(count)
        least, most = limits
        return cls(
            mean, min(max(mean - half, least), mean), max(min(mean + half, most), mean), count
        )

    @property
    def cells(self) -> tuple[float | None, float | None, float | None]:
        """The values of the columns X, X low and X high."""
        return self.mean, self.low, self.high

    @property
    def half(self) -> float | None:
        """Half of the interval, as it was before one of its ends was clipped."""
        if self.mean is None or self.low is None or self.high is None:
            return None
        return max(self.high - self.mean, self.mean - self.low)


NO_INTERVAL = Interval(None, None, None, 0)


def student(count: int) -> float:
    """The factor of Student's t for a mean of so many values, two or more."""
    from scipy.special import stdtrit

    return float(stdtrit(count - 1, 0.5 + 0.5 * CONFIDENCE))


def few_seeds_note(counts: Iterable[int], what: str = "seed") -> str:
    """What is to be said of intervals over so few seeds, or pairs, or drives; else nothing."""
    fewest = min((count for count in counts if count), default=MIN_SEEDS)
    if fewest >= MIN_SEEDS:
        return ""
    said = f"{fewest} {what}s: too few for an interval to mean much"
    if fewest == 1:
        said = f"1 {what}: too few for an interval"
    return f"{said}; {MIN_SEEDS} or more are better."
