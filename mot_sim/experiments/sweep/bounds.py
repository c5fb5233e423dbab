"""What a score must reach: at least for what is better when it is more, at most for the others."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import isnan

from mot_sim.metrics import evaluate_sequence
from mot_sim.metrics.spatial import spatial_scores
from mot_sim.tables import COUNTS, RATES, is_rate
from tracker import Tracks
from tracker.errors import BadConfig, UnknownName

# Scores that are better when they are less.
LESS_IS_BETTER = {
    "CLR_FP", "CLR_FN", "IDSW", "Frag", "ML", "MLR", "FP_per_frame", "IDFP", "IDFN",
    "HOTA_FP", "HOTA_FN",
    # of cuboids
    "centre_median", "centre_p90", "radial_median", "lateral_median", "vertical_median",
    "length_error", "height_error", "width_error", "speed_error", "parked_over_1mps",
    "parked_drift", "heading_known_brier",
}  # fmt: skip
# What the names of further such scores begin with.
LESS_IS_BETTER_BEGINNINGS = ("heading_over_",)
# Scores that are neither: one cannot want more or less of them.
UNBOUNDED_SCORES = {
    "PT", "PTR", "CLR_Frames", "MOTP_sum", "matched_rows", "heading_known", "heading_known_true"
}  # fmt: skip
UNBOUNDED_ENDINGS = ("_inside_1_sigma", "_inside_2_sigma", "_nees")  # ideal is in between


@dataclass(frozen=True)
class Bound:
    """A score and the value that is still good enough."""

    metric: str
    """TrackEval's name of the score."""
    value: float
    """The limit: the most that is allowed for a score of LESS_IS_BETTER, else the least. Rates are
    shares, at most 1."""

    @property
    def is_upper(self) -> bool:
        """Whether the score may not be larger; otherwise it may not be smaller."""
        base = self.metric.partition("@")[0]
        if base == "MOTP":  # of distances in metres
            return self.metric.endswith("m")
        return base in LESS_IS_BETTER or base.startswith(LESS_IS_BETTER_BEGINNINGS)

    @property
    def is_spatial(self) -> bool:
        """Whether it is a score of cuboids."""
        return self.metric in _spatial_names()

    @property
    def word(self) -> str:
        """`at most` or `at least`."""
        return "at most" if self.is_upper else "at least"

    def holds(self, score: float) -> bool:
        """Whether a score is good enough."""
        return score <= self.value if self.is_upper else score >= self.value


@lru_cache(maxsize=1)
def _known() -> dict[str, str]:
    """TrackEval's name of every score that can be bounded, by name and title in small letters.

    Those of cuboids have names of their own.
    """
    scores = [*evaluate_sequence(Tracks.empty(), Tracks.empty(), 1).numbers(), *_spatial_names()]
    found = {name.lower(): name for name in scores if _can_be_bounded(name)}
    titles = {title.lower(): name for title, name in (RATES | COUNTS).items()}
    return found | {title: name for title, name in titles.items() if name not in UNBOUNDED_SCORES}


@lru_cache(maxsize=1)
def _spatial_names() -> tuple[str, ...]:
    """The names of the scores of cuboids."""
    return tuple(spatial_scores(Tracks.empty(), Tracks.empty(), 1).numbers())


def _can_be_bounded(name: str) -> bool:
    """Whether one can want more, or less, of a score."""
    base = name.partition("@")[0]
    return base not in UNBOUNDED_SCORES and not base.endswith(UNBOUNDED_ENDINGS)


def bounds_of(wanted: Mapping[str, float | int]) -> tuple[Bound, ...]:
    """Bounds by the names of scores: mota, idsw, fp, CLR_FP, mota3d@2m, ... in small letters or
    large.

    Raises UnknownName, and BadConfig for no bound at all and for a rate above 1.
    """
    known = _known()
    if not wanted:
        raise BadConfig("no bound: give some, for example mota=0.8, idsw=2")
    found = []
    for name, value in wanted.items():
        if name.lower() not in known:
            if not _can_be_bounded(name):
                raise BadConfig(
                    f"bound {name}: neither more nor less of it is better; bound an error instead, "
                    "for example centre_median or heading_known_brier"
                )
            raise UnknownName.of("score", name, _titles(known))
        if isinstance(value, bool) or not isinstance(value, int | float) or isnan(value):
            raise BadConfig(f"bound {name} = {value!r}: give a number")
        bound = Bound(known[name.lower()], float(value))
        if is_rate(bound.metric) and value > 1.0:
            raise BadConfig(f"bound {name} = {value:g}: rates are fractions, {value / 100.0:g}?")
        found.append(bound)
    return tuple(found)


def _titles(known: Mapping[str, str]) -> Iterable[str]:
    """The names that people use."""
    return [title.lower() for title in RATES | COUNTS if title.lower() in known]


__all__ = ["LESS_IS_BETTER", "Bound", "bounds_of"]
