"""Cars that the detector does not see: seldom in the open, nearly always when hidden."""

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim import draws

# RRC misses 1 % of KITTI's fully visible cars, 2 % of the partly and 20 % of the largely occluded
# ones (measured on six of the given sequences); this rule: 1, 5 and 28 % at .9, .65 and .35.
MISS_RATE = 0.01


def miss_probability(visible: Float[Array, " n"], level: float = 1.0) -> Float[Array, " n"]:
    """level * (MISS_RATE + (1 - visible)^3), at most 1: at level 1 a half-hidden car .135."""
    return np.minimum(level * (MISS_RATE + (1.0 - visible) ** 3), 1.0)


def missed(
    visible: Float[Array, " n"],
    seed: int,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    level: float = 1.0,
) -> Bool[Array, " n"]:
    """Which cars go unseen. A higher level misses the same cars and more."""
    chance = draws.uniform(seed, "miss", ids, frames)[:, 0]
    return np.asarray(chance < miss_probability(visible, level))
