"""Does the testbed tell the truth? The same trackers on real drives and on made ones."""

from mot_sim.experiments.validation.agreement import TOLERANCES, Agreement, Lead, Tolerance
from mot_sim.experiments.validation.contestants import (
    OURS,
    VARIANTS,
    Contestant,
    find_contestant,
    find_contestants,
)
from mot_sim.experiments.validation.reenactment import Reenacted, reenact
from mot_sim.experiments.validation.running import Outcome, run_contestants
from mot_sim.experiments.validation.sums import METRICS
from mot_sim.experiments.validation.worlds import World, made_world, real_world, scene_worlds

__all__ = [
    "METRICS",
    "OURS",
    "TOLERANCES",
    "VARIANTS",
    "Agreement",
    "Contestant",
    "Lead",
    "Outcome",
    "Reenacted",
    "Tolerance",
    "World",
    "find_contestant",
    "find_contestants",
    "made_world",
    "real_world",
    "reenact",
    "run_contestants",
    "scene_worlds",
]
