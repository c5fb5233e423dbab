"""The names of scores: TrackEval's and those that people use, and what their values can be."""

from math import inf

# Title, and TrackEval's name of the score.
RATES = {
    "HOTA": "HOTA",
    "DetA": "DetA",
    "AssA": "AssA",
    "MOTA": "MOTA",
    "MOTP": "MOTP",
    "IDF1": "IDF1",
    "recall": "CLR_Re",
    "precision": "CLR_Pr",
}
COUNTS = {
    "TP": "CLR_TP",
    "FP": "CLR_FP",
    "FN": "CLR_FN",
    "IDSW": "IDSW",
    "Frag": "Frag",
    "MT": "MT",
    "PT": "PT",
    "ML": "ML",
}
TITLES = {name: title for title, name in (RATES | COUNTS).items()}  # by TrackEval's name
SHARES = {"MTR": "MT %", "PTR": "PT %", "MLR": "ML %"}  # of the labels' tracks
# Other columns that hold fractions.
FRACTIONS = {*SHARES, *SHARES.values(), "score from", "share", "fall"}
# Scores that cannot exceed 1, and those of them that can be negative.
NEGATIVE_RATES = {"MOTA", "MODA", "MOTAL", "sMOTA"}
RATES_UP_TO_ONE = {
    *RATES.values(), *SHARES, *NEGATIVE_RATES, "CLR_F1", "DetRe", "DetPr", "AssRe", "AssPr",
    "LocA", "OWTA", "HOTA(0)", "LocA(0)", "HOTALocA(0)", "IDR", "IDP",
}  # fmt: skip


def title_of(name: str) -> str:
    """What people call a score; any other name as it is."""
    return TITLES.get(name, name)


def is_rate(name: str) -> bool:
    """Whether a score, or a column of this name in a file, is a fraction, shown in percent."""
    base = name.partition(" - ")[0].removesuffix(" of the others").removesuffix(" held out")
    return base in RATES or base in RATES.values() or base in FRACTIONS


def is_count(name: str) -> bool:
    """Whether a score is one of the counts that people look at."""
    return name in COUNTS or name in COUNTS.values()


def limits_of(name: str, is_difference: bool = False) -> tuple[float, float]:
    """The least and the most that a score can be, or the difference of two such scores."""
    least = -inf if name in NEGATIVE_RATES else 0.0
    most = 1.0 if name in RATES_UP_TO_ONE else inf
    return (least - most, most - least) if is_difference else (least, most)
