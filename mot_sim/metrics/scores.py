"""What a set of rules says: the families of scores of one sequence, or of several together."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mot_sim.metrics.counts import ClearCounts, Number
from mot_sim.metrics.hota import ALPHAS, Hota
from mot_sim.metrics.identity import Identity
from tracker.errors import BadConfig, UnknownName


@dataclass(frozen=True, eq=False)
class Scores:
    """All scores of one sequence, or of several together; `scores["HOTA"]` is one plain number.

    clear: `Clear` or `Devkit2018`. hota, identity: None where the rules do not know them. Names
    are TrackEval's.
    """

    clear: ClearCounts
    hota: Hota | None = None
    identity: Identity | None = None

    def __getitem__(self, name: str) -> Number:
        """One score by its name; of those that vary with alpha, the mean."""
        numbers = self.numbers()
        if name not in numbers:
            raise UnknownName.of("score", name, numbers)
        return numbers[name]

    def numbers(self) -> dict[str, Number]:
        """Every score by its name; of those that vary with alpha, the mean."""
        families = (self.hota, self.clear, self.identity)
        return {
            name: number
            for family in families
            if family is not None
            for name, number in family.numbers().items()
        }

    def as_dict(self) -> dict[str, Any]:
        """Every score as a plain number, and under `by_alpha` lists over HOTA's alphas."""
        if self.hota is None:
            return dict(self.numbers())
        return self.numbers() | {"by_alpha": {"alpha": ALPHAS.tolist()} | self.hota.by_alpha()}


def combine(parts: Sequence[Scores]) -> Scores:
    """The scores of several sequences together, as TrackEval's COMBINED_SEQ.

    Counts add up; rates are taken of the sums. One sequence without labels or output may
    score other rates combined than alone, as in TrackEval (see `Clear`). Raises BadConfig
    for nothing, and for scores of different rules.
    """
    families = {(type(part.clear), part.hota is None, part.identity is None) for part in parts}
    if len(families) != 1:
        raise BadConfig(
            f"{len(parts)} scores of {len(families)} kinds cannot be combined: "
            "give at least one sequence, and score all by the same rules"
        )
    clears = [part.clear for part in parts]
    hotas = [part.hota for part in parts if part.hota is not None]
    identities = [part.identity for part in parts if part.identity is not None]
    return Scores(
        clear=type(clears[0]).combine(clears),
        hota=Hota.combine(hotas) if hotas else None,
        identity=Identity.combine(identities) if identities else None,
    )
