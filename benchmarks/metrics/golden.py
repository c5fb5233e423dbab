"""The golden scores in the tests: TrackEval's own numbers for some cases, in one small file."""

import json
from pathlib import Path

import numpy as np

GOLDEN_FILE = Path(__file__).parents[2] / "tests" / "golden" / "metrics_trackeval.json"
COLUMNS = [
    "HOTA", "DetA", "AssA", "LocA", "OWTA", "HOTA(0)", "MOTA", "MOTP", "MOTAL",
    "CLR_FP", "IDSW", "Frag", "MT", "PT", "IDF1", "IDTP",
]  # fmt: skip
RANDOM_KEPT = 20  # seeds 0..19 hold every kind of blank; the rest shows in "combined"


def bless(references: dict[str, dict[str, dict]]) -> int:
    """Write the file anew from TrackEval's scores; its size in bytes.

    Rows of a world that was not compared this time stay as they are.
    """
    rows: dict[str, list[float]] = {}
    if GOLDEN_FILE.exists():
        old = json.loads(GOLDEN_FILE.read_text())["rows"]
        rows = {name: row for name, row in old.items() if name.split("/")[0] not in references}
    for world, trackers in references.items():
        for tracker, reference in trackers.items():
            scores = {**reference["sequences"], "combined": reference["combined"]}
            for name, families in scores.items():
                if not name.startswith("random-") or int(name[-3:]) < RANDOM_KEPT:
                    rows[f"{world}/{tracker}/{name}"] = numbers(families)
    lines = [f'"{name}": {json.dumps(row)}' for name, row in rows.items()]
    about = "TrackEval 1.3.0; rewritten by benchmarks.metrics.compare_trackeval --bless"
    head = f'"about": "{about}",\n"columns": {json.dumps(COLUMNS)},\n"rows": {{\n'
    GOLDEN_FILE.write_text("{\n" + head + ",\n".join(lines) + "\n}\n}\n")
    return GOLDEN_FILE.stat().st_size


def numbers(families: dict[str, dict]) -> list[float]:
    """The chosen scores; means where there are alphas. Twelve decimals: beyond any tolerance."""
    scores = {name: value for family in families.values() for name, value in family.items()}
    means = [float(np.mean(scores[name])) for name in COLUMNS]
    return [int(mean) if mean == int(mean) else round(mean, 12) for mean in means]
