"""The counts that every reading of CLEAR ends with, and the rates that follow from them."""

from collections.abc import Sequence
from dataclasses import MISSING, dataclass, fields
from math import log10
from typing import ClassVar

MOSTLY_TRACKED = 0.8  # of a label's frames
MOSTLY_LOST = 0.2

Number = int | float  # a count or a rate


@dataclass(frozen=True, eq=False)
class ClearCounts:
    """CLEAR counts, and their rates under the names that TrackEval gives them.

    MT, PT, ML: labels' tracks that are mostly (> 80 %), partly and less than 20 % tracked.
    Which boxes and tracks are counted is up to the rules.
    """

    RATES: ClassVar[tuple[str, ...]] = (
        "MOTA", "MOTP", "MODA", "MOTAL", "CLR_Re", "CLR_Pr", "MTR", "PTR", "MLR",
    )  # fmt: skip

    CLR_TP: int
    CLR_FN: int
    CLR_FP: int
    IDSW: int
    MT: int
    PT: int
    ML: int
    Frag: int
    MOTP_sum: float

    def accuracy(self, switches: Number) -> float:
        """1 less the misses, false positives and the given switches per label."""
        raise NotImplementedError

    def rate(self, part: Number, whole: Number) -> float:
        """A part of a whole; of nothing it is 0."""
        return part / max(1.0, whole)

    @property
    def MOTA(self) -> float:
        """1 less the misses, false positives and id switches per label."""
        return self.accuracy(self.IDSW)

    @property
    def MODA(self) -> float:
        """MOTA without the id switches."""
        return self.accuracy(0.0)

    @property
    def MOTAL(self) -> float:
        """MOTA with the logarithm of the id switches."""
        return self.accuracy(log10(self.IDSW) if self.IDSW else 0.0)

    @property
    def MOTP(self) -> float:
        """The mean overlap of the matches (intersection over union; more is better)."""
        return self.rate(self.MOTP_sum, self.CLR_TP)

    @property
    def CLR_Re(self) -> float:
        """Recall."""
        return self.rate(self.CLR_TP, self.CLR_TP + self.CLR_FN)

    @property
    def CLR_Pr(self) -> float:
        """Precision."""
        return self.rate(self.CLR_TP, self.CLR_TP + self.CLR_FP)

    @property
    def MTR(self) -> float:
        """The part of the labels' tracks that are mostly tracked."""
        return self.rate(self.MT, self.MT + self.PT + self.ML)

    @property
    def PTR(self) -> float:
        """The part of the labels' tracks that are partly tracked."""
        return self.rate(self.PT, self.MT + self.PT + self.ML)

    @property
    def MLR(self) -> float:
        """The part of the labels' tracks that are mostly lost."""
        return self.rate(self.ML, self.MT + self.PT + self.ML)

    @classmethod
    def counted(cls) -> list[str]:
        """The names of the counts, which add up over sequences."""
        return [field.name for field in fields(cls) if field.default is MISSING]

    @classmethod
    def combine(cls, parts: Sequence["ClearCounts"]) -> "ClearCounts":
        """The scores of all sequences together: counts add up."""
        return cls(**{name: sum(getattr(part, name) for part in parts) for name in cls.counted()})

    def numbers(self) -> dict[str, Number]:
        """Every score by its name."""
        return {name: getattr(self, name) for name in (*self.RATES, *self.counted())}
