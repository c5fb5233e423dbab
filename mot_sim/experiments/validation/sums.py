"""Scores of many choices of drives at once: what adds up over drives, and the scores of the sums.

`combine` makes a `Scores` for one choice of drives; resampling needs thousands. The scores here
are the same numbers.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.metrics import Scores
from mot_sim.metrics.hota import ALPHAS
from tracker.errors import BadConfig, UnknownName

COUNTS = ("CLR_TP", "CLR_FN", "CLR_FP", "IDSW")
IDENTITY = ("IDTP", "IDFN", "IDFP")
METRICS = ("MOTA", "HOTA", "IDF1", "IDSW")
PLAIN = len(COUNTS) + len(IDENTITY)


def addends(scores: Sequence[Scores]) -> Float[Array, "d q"]:
    """What adds up, a row a drive. Raises BadConfig for scores without HOTA or identities."""
    rows = []
    for each in scores:
        if each.hota is None or each.identity is None:
            raise BadConfig("scores without HOTA or identity: score by the rules trackeval")
        plain = [getattr(each.clear, name) for name in COUNTS]
        plain += [getattr(each.identity, name) for name in IDENTITY]
        hota = each.hota
        by_alpha = (hota.HOTA_TP, hota.HOTA_FN, hota.HOTA_FP, hota.AssA * hota.HOTA_TP)
        rows.append(np.concatenate((plain, *by_alpha)))
    return np.array(rows, float)


def score_of_sums(sums: Float[Array, "*c q"], metric: str) -> Float[Array, "*c"]:
    """The score of each row of sums: MOTA, HOTA, IDF1 as parts of 1, IDSW as a number.

    Raises UnknownName for another metric.
    """
    found, missed, false, switches, id_found, id_missed, id_false = np.moveaxis(
        sums[..., :PLAIN], -1, 0
    )
    if metric == "IDSW":
        return switches
    if metric == "MOTA":
        return (found - false - switches) / np.maximum(found + missed, 1.0)
    if metric == "IDF1":
        return id_found / np.maximum(id_found + 0.5 * (id_missed + id_false), 1.0)
    if metric != "HOTA":
        raise UnknownName.of("metric", metric, METRICS)
    shape = (*sums.shape[:-1], 4, len(ALPHAS))
    hits, misses, wrong, alike = np.moveaxis(sums[..., PLAIN:].reshape(shape), -2, 0)
    detection = hits / np.maximum(hits + misses + wrong, 1.0)
    association = alike / np.maximum(hits, 1.0)
    return np.sqrt(detection * association).mean(axis=-1)
