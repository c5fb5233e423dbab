"""KITTI's tracking scores, in memory: CLEAR, HOTA, Identity, the kit of 2018; AB3DMOT in 3D."""

from mot_sim.metrics.clear import Clear, ClearCounts
from mot_sim.metrics.cuboid_overlap import Criterion, cuboid_iou
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
from mot_sim.metrics.motchallenge import motchallenge_scores
from mot_sim.metrics.spatial import SpatialScores, spatial_scores

__all__ = [
    "ALPHAS",
    "RULES",
    "Clear",
    "ClearCounts",
    "Criterion",
    "Devkit2018",
    "Evaluation",
    "Hota",
    "Identity",
    "Scores",
    "SpatialScores",
    "combine",
    "cuboid_iou",
    "evaluate",
    "evaluate_sequence",
    "motchallenge_scores",
    "spatial_scores",
]
