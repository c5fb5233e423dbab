"""Where in the space of its axes a design looks: grids, one axis at a time, or drawn points."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import exp, inf, log

from mot_sim.experiments.sweep.paths import Level, parse_level
from mot_sim.simulation import random_numbers
from tracker.errors import BadConfig

DESIGN_MODES = ("grid", "one_at_a_time", "random")
Point = dict[str, Level]  # levels by axis; an axis that is absent keeps its own value


@dataclass(frozen=True)
class Range:
    """Levels between two ends, from which a random design draws.

    Raises BadConfig unless `low` < `high`, both finite.
    """

    low: float
    """The lowest level, finite; above 0 for a logarithmic range."""
    high: float
    """The highest level, finite, above `low`."""
    log: bool = False
    """Whether levels are spread evenly in their logarithm instead of in their value."""

    def __post_init__(self) -> None:
        if not -inf < self.low < self.high < inf or (self.log and self.low <= 0.0):
            above = ", above 0 for a logarithmic one" if self.log else ""
            raise BadConfig(f"range {self.low:g}..{self.high:g}: give low below high{above}")

    def at(self, share: float) -> float:
        """The level below which so much of the range lies."""
        if self.log:
            return exp(log(self.low) + share * (log(self.high) - log(self.low)))
        return self.low + share * (self.high - self.low)


Levels = Sequence[Level] | Range


def points_of(
    axes: Mapping[str, Levels], mode: str, samples: int, whole: Mapping[str, bool]
) -> tuple[Point, ...]:
    """The points of a design, in order. whole: of each axis, whether it takes whole numbers only.

    random: a Latin hypercube; every axis has its own stream, so that one more axis leaves the
    levels of the others as they are.
    """
    listed = {axis: list(levels) for axis, levels in axes.items() if not isinstance(levels, Range)}
    if mode == "grid":
        return tuple(dict(zip(listed, levels, strict=True)) for levels in product(*listed.values()))
    if mode == "one_at_a_time":
        return tuple({axis: level} for axis, levels in listed.items() for level in levels)
    columns: dict[str, list[Level]] = {}
    for axis, levels in axes.items():
        rng = random_numbers.named_stream(0, f"design/{axis}")
        shares = (rng.permutation(samples) + rng.random(samples)) / samples
        columns[axis] = [_level(levels, share, whole[axis]) for share in shares.tolist()]
    return tuple(
        dict(zip(columns, levels, strict=True)) for levels in zip(*columns.values(), strict=True)
    )


def _level(levels: Levels, share: float, whole: bool) -> Level:
    """The level that lies so far into a range or a list."""
    if isinstance(levels, Range):
        return round(levels.at(share)) if whole else levels.at(share)
    return levels[min(int(share * len(levels)), len(levels) - 1)]


def require_levels(axis: str, levels: Levels, mode: str) -> None:
    """Raise BadConfig for an axis without levels, with one twice, or of another mode."""
    if isinstance(levels, Range):
        if mode != "random":
            raise BadConfig(f"axis {axis} is a range: give levels, or a random design (--random N)")
        return
    if isinstance(levels, str) or not levels:
        raise BadConfig(f"axis {axis} has no levels: write --axis {axis}=0,0.5,1")
    if len(set(levels)) < len(levels):
        raise BadConfig(f"axis {axis}: {list(levels)} holds a level twice")


def parse_axes(texts: Iterable[str]) -> dict[str, Levels]:
    """All axes with their levels. Raises BadConfig for one that is given twice."""
    found: dict[str, Levels] = {}
    for text in texts:
        name, levels = parse_axis(text)
        if name in found:
            raise BadConfig(f"--axis {text}: {name} is one already; give all its levels at once")
        found[name] = levels
    return found


def parse_axis(text: str) -> tuple[str, Levels]:
    """An axis with its levels from NAME=LEVEL,LEVEL,..., or NAME=LOW..HIGH[ log]."""
    name, equals, rest = (part.strip() for part in text.partition("="))
    words = [word.strip() for word in rest.split(",")]
    if not (name and equals) or not all(words):
        raise BadConfig(f"--axis {text}: write NAME=LEVEL,LEVEL,... or NAME=LOW..HIGH")
    low, dots, high = rest.removesuffix(" log").partition("..")
    if not dots:
        return name, tuple(parse_level(word) for word in words)
    try:
        return name, Range(float(low), float(high), rest.endswith(" log"))
    except ValueError:
        raise BadConfig(f"--axis {text}: {low} and {high} are no numbers") from None
