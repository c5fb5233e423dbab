"""Rows that the paper prints: quoted, not reproduced.

Sharma et al., ICRA 2018, Tables I-IV: all 21 training sequences or splits of them that are not
given, so nothing here is measured on the drives that ours are. Percentages, then counts; None
where the paper has a dash.
"""

Quoted = tuple[float | int | None, ...]

COLUMNS = (
    "MOTA", "MOTP", "CLR_Re", "CLR_Pr", "MTR", "PTR", "MLR", "CLR_TP", "CLR_FP", "IDSW", "Frag",
)  # fmt: skip
_: None = None

OVERALL: dict[str, Quoted] = {
    "CIWT": (74.38, 82.85, _, _, 49.59, 40.68, 9.80, _, _, 26, 131),
    "the paper, CIWT's split": (
        91.75, 89.90, 94.83, 98.62, 88.61, 10.39, 0.9, 9814, 137, 93, 151,
    ),
    "Deep Network Flow": (74.11, _, 84.74, 92.05, 61.73, _, _, _, _, 29, 335),
    "NOMT": (73.07, _, 85.07, 90.92, 61.73, _, _, _, _, 43, 386),
    "SSP": (67, 79, _, _, 41, _, 9, _, _, 194, 977),
    "the paper, all 21": (91.4, 89.83, 94.65, 98.47, 87.76, 10.63, 1.59, 25309, 392, 232, 423),
}  # fmt: skip
SERVER_COLUMNS = ("MOTA", "MOTP", "MTR", "MLR", "IDSW", "Frag")
SERVER: dict[str, Quoted] = {
    "CIWT": (75.39, 79.25, 49.85, 10.31, 165, 660),
    "SCEA": (75.58, 79.39, 53.08, 11.54, 104, 448),
    "MDP": (76.59, 82.10, 52.15, 13.38, 130, 387),
    "LP-SSVM": (77.63, 77.80, 56.31, 8.46, 62, 539),
    "NOMT": (78.15, 79.46, 57.23, 13.23, 31, 207),
    "MCMOT-CPD": (78.90, 82.13, 52.31, 11.69, 228, 536),
    "the paper": (84.24, 85.73, 73.23, 2.77, 468, 944),
}
ABLATION: dict[str, Quoted] = {
    f"{detector} + {cues}": (mota, *same[:6], *same[6:], switches, fragments)
    for detector, same, rows in (
        (
            "SubCNN", (82.60, 86.45, 89.29, 71.63, 24.46, 3.90, 23563, 2825),
            (
                ("appearance", 66.18, 708, 1100), ("3D-2D", 68.24, 429, 829),
                ("3D-3D", 69.36, 377, 778), ("3D-2D + appearance", 70.96, 472, 870),
                ("all", 71.52, 338, 740),
            ),
        ),
        (
            "RRC", (89.83, 94.65, 98.47, 87.76, 10.63, 1.59, 25309, 392),
            (
                ("appearance", 80.53, 2863, 3022), ("3D-2D", 86.91, 1328, 1507),
                ("3D-3D", 87.56, 1170, 1333), ("3D-2D + appearance", 89.65, 668, 849),
                ("all", 91.4, 232, 423),
            ),
        ),
    )
    for cues, mota, switches, fragments in rows
}  # fmt: skip
INTERSECTIONS: dict[str, Quoted] = {
    "2D-2D": (55.3, 86.01, 98.9648, 84.75, 100, 0, 0, 478, 86, 5, 7),
    "2D-2D + shape and pose": (57.29, 86.01, 98.9648, 84.75, 100, 0, 0, 478, 86, 1, 5),
}
