"""How well made drives foretell scores on real ones: differences, ranks, and the leader's lead."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array
from scipy.stats import kendalltau, spearmanr

from mot_sim.experiments.validation.sums import addends, score_of_sums
from mot_sim.metrics import Scores
from mot_sim.tables import Interval

COUNTED = "IDSW"  # a count, where less is better; the others are rates
RESAMPLES = 300  # of the drives, for the intervals of the ranks
MIN_BOOTSTRAP_DRIVES = 5  # with fewer, resampled drives say little
MAX_SPLITS = 126  # of the drives in halves, evenly chosen where there are more
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Tolerance:
    """How far made scores may be from real ones."""

    near: float
    """What most rows must be within: a part of 1 for rates, of the real count for IDSW."""
    far: float
    """What all rows must be within."""
    slack: float = 0.0
    """Differences up to this are within every limit."""


TOLERANCES: dict[str, Tolerance] = {
    "MOTA": Tolerance(0.010, 0.015),
    "HOTA": Tolerance(0.015, 0.020),
    "IDF1": Tolerance(0.015, 0.020),
    "IDSW": Tolerance(0.25, 0.35, 5.0),
}


@dataclass(frozen=True)
class Lead:
    """How far the best of ours is ahead of the best guest."""

    leader: str
    """The best of all, ours or a guest."""
    ours: str
    """The best of ours."""
    guest: str
    """The best guest."""
    points: float
    """Ours before the guest's, in the metric's unit; > 0: ours is better, for counts too."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """Real scores beside made ones. Rows are trackers in the order of `names`."""

    names: tuple[str, ...]
    """The trackers."""
    guests: frozenset[str]
    """Those of them that are other people's."""
    real: Mapping[str, Sequence[Scores]]
    """Scores of each real drive, by tracker."""
    made: Mapping[str, Mapping[str, Sequence[Scores]]]
    """Scores of each made drive, by tracker, then by the world's name (a seed)."""
    same_drives: bool = True
    """Whether drive i of a made world re-enacts real drive i."""

    @cached_property
    def worlds(self) -> tuple[str, ...]:
        """Names of the made worlds."""
        return tuple(self.made[self.names[0]])

    @cached_property
    def drive_count(self) -> int:
        """Number of real drives."""
        return len(self.real[self.names[0]])

    @cached_property
    def _real_addends(self) -> Float[Array, "n d q"]:
        return np.array([addends(self.real[name]) for name in self.names])

    @cached_property
    def _made_addends(self) -> Float[Array, "n s e q"]:
        return np.array(
            [[addends(self.made[name][world]) for world in self.worlds] for name in self.names]
        )

    def real_scores(self, metric: str) -> Float[Array, " n"]:
        """All real drives together, a value a tracker."""
        return score_of_sums(self._real_addends.sum(axis=1), metric)

    def made_scores(self, metric: str) -> Float[Array, "n s"]:
        """All drives of each made world together, a column a world."""
        return score_of_sums(self._made_addends.sum(axis=2), metric)

    def differences(self, metric: str) -> list[Interval]:
        """Made less real, the mean over the worlds with its interval, a tracker after the other."""
        apart = self.made_scores(metric) - self.real_scores(metric)[:, None]
        return [Interval.of(row) for row in apart]

    def within(self, metric: str, far: bool = False) -> Float[Array, " n"]:
        """By tracker, whether the made scores (mean) are within the limit: 1 or 0."""
        limits, real = TOLERANCES[metric], self.real_scores(metric)
        apart = np.abs(self.made_scores(metric).mean(axis=1) - real)
        share = limits.far if far else limits.near
        allowed = np.maximum(share * real, limits.slack) if metric == COUNTED else share
        return (apart <= allowed + 1e-12).astype(float)

    def rank_correlation(self, metric: str, kind: str = "spearman") -> float:
        """Of real scores with made ones (mean over the worlds); kind: spearman or kendall."""
        return correlation(self.real_scores(metric), self.made_scores(metric).mean(axis=1), kind)

    def rank_interval(self, metric: str) -> Interval:
        """Spearman's correlation, and the middle 95 % of what resampled drives give.

        NO_INTERVAL's ends where there are fewer than MIN_BOOTSTRAP_DRIVES drives.
        """
        value = self.rank_correlation(metric)
        if self.drive_count < MIN_BOOTSTRAP_DRIVES:
            return Interval(value, None, None, self.drive_count)
        random, count = np.random.default_rng(0), self.drive_count
        times = random.multinomial(count, [1.0 / count] * count, RESAMPLES).astype(float)
        real = score_of_sums(np.einsum("rd,ndq->rnq", times, self._real_addends), metric)
        if self.same_drives:
            sums = np.einsum("rd,nsdq->rnsq", times, self._made_addends)
            made = score_of_sums(sums, metric).mean(axis=2)
        else:
            worlds = len(self.worlds)
            often = random.multinomial(worlds, [1.0 / worlds] * worlds, RESAMPLES) / worlds
            made = often @ self.made_scores(metric).T
        found = [correlation(one, other) for one, other in zip(real, made, strict=True)]
        low, high = np.nanquantile(found, [0.5 - CONFIDENCE / 2, 0.5 + CONFIDENCE / 2])
        return Interval(value, min(float(low), value), max(float(high), value), RESAMPLES)

    def ceiling(self, metric: str) -> float | None:
        """What one half of the real drives says of the other: the median of Spearman's correlation.

        None for fewer than MIN_BOOTSTRAP_DRIVES drives.
        """
        count = self.drive_count
        if count < MIN_BOOTSTRAP_DRIVES:
            return None
        splits = [half for half in combinations(range(count), count // 2) if 0 in half or count % 2]
        chosen = np.linspace(0, len(splits) - 1, min(len(splits), MAX_SPLITS)).astype(int)
        inside = np.zeros((len(chosen), count))
        for row, place in enumerate(chosen.tolist()):
            inside[row, list(splits[place])] = 1.0
        one, other = (
            score_of_sums(np.einsum("rd,ndq->rnq", half, self._real_addends), metric)
            for half in (inside, 1.0 - inside)
        )
        found = [correlation(*pair) for pair in zip(one, other, strict=True)]
        return float(np.median(found))

    def leads(self, metric: str) -> tuple[Lead, Lead] | None:
        """On real and on made drives; None without a guest or without one of ours."""
        if not self.guests or len(self.guests) == len(self.names):
            return None
        made = self.made_scores(metric).mean(axis=1)
        return self._lead(metric, self.real_scores(metric)), self._lead(metric, made)

    def _lead(self, metric: str, scores: Float[Array, " n"]) -> Lead:
        better = -scores if metric == COUNTED else scores
        is_guest = np.array([name in self.guests for name in self.names])
        ours = int(np.argmax(np.where(is_guest, -np.inf, better)))
        guest = int(np.argmax(np.where(is_guest, better, -np.inf)))
        leader = self.names[int(np.argmax(better))]
        return Lead(
            leader, self.names[ours], self.names[guest], float(better[ours] - better[guest])
        )


def correlation(
    one: Float[Array, " n"], other: Float[Array, " n"], kind: str = "spearman"
) -> float:
    """Of two rankings; NaN where all are alike in one of them."""
    if np.ptp(one) == 0.0 or np.ptp(other) == 0.0:
        return float("nan")
    measure = spearmanr if kind == "spearman" else kendalltau
    return float(measure(one, other).statistic)
