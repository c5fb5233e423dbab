"""KITTI's 2D tracking scores for cars, in memory: CLEAR, HOTA, Identity, and the kit of 2018."""

from mot_sim.metrics.clear import Clear, ClearCounts
from mot_sim.metrics.devkit2018 import Devkit2018
from mot_sim.metrics.evaluation import (
    RULES,
    Evaluation,
    Scores,
    combine,
    evaluate,
    evaluate_sequence,
)
from mot_sim.metrics.hota import ALPHAS, Hota
from mot_sim.metrics.identity import Identity

__all__ = [
    "ALPHAS",
    "RULES",
    "Clear",
    "ClearCounts",
    "Devkit2018",
    "Evaluation",
    "Hota",
    "Identity",
    "Scores",
    "combine",
    "evaluate",
    "evaluate_sequence",
]
