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
# Scores of cuboids that are fractions; with a criterion behind an @: `MOTA3D@2m`.
SPATIAL_RATES = {
    "sAMOTA", "AMOTA", "MOTA3D", "HOTA3D", "DetA3D", "AssA3D", "LocA3D", "within_2m",
    "cuboid_known", "parked_over_1mps",
}  # fmt: skip
SPATIAL_RATE_BEGINNINGS = ("heading_over_", "heading_known")
# Other columns that hold fractions.
FRACTIONS = {*SHARES, *SHARES.values(), "score from", "share", "fall"}
# Scores that cannot exceed 1, and those of them that can be negative.
NEGATIVE_RATES = {"MOTA", "MODA", "MOTAL", "sMOTA", "AMOTA", "MOTA3D"}
RATES_UP_TO_ONE = {
    *RATES.values(), *SHARES, *NEGATIVE_RATES, *SPATIAL_RATES, "CLR_F1", "DetRe", "DetPr", "AssRe",
    "AssPr", "LocA", "OWTA", "HOTA(0)", "LocA(0)", "HOTALocA(0)", "IDR", "IDP",
}  # fmt: skip


def title_of(name: str) -> str:
    """What people call a score; any other name as it is."""
    return TITLES.get(name, name)


def is_rate(name: str) -> bool:
    """Whether a score, or a column of this name in a file, is a fraction, shown in percent."""
    base = name.partition(" - ")[0].removesuffix(" of the others").removesuffix(" held out")
    base, _, criterion = base.partition("@")
    if base == "MOTP" and criterion.endswith("m"):
        return False  # metres
    is_spatial = base in SPATIAL_RATES or base.startswith(SPATIAL_RATE_BEGINNINGS)
    return is_spatial or base in RATES or base in RATES.values() or base in FRACTIONS


def is_count(name: str) -> bool:
    """Whether a score is one of the counts that people look at."""
    base = name.partition("@")[0]
    return base in COUNTS or base in COUNTS.values()


def limits_of(name: str, is_difference: bool = False) -> tuple[float, float]:
    """The least and the most that a score can be, or the difference of two such scores."""
    base = name.partition("@")[0]
    least = -inf if base in NEGATIVE_RATES else 0.0
    is_share = base in RATES_UP_TO_ONE or base.startswith(SPATIAL_RATE_BEGINNINGS)
    most = 1.0 if is_share and not (base == "MOTP" and name.endswith("m")) else inf
    return (least - most, most - least) if is_difference else (least, most)
