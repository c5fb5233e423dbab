"""How sure the detector says it is: less of hidden cars."""

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim import draws

# The scores of RRC as probabilities, on KITTI: .99 and more for most cars, less than .93 for one
# in twenty of the largely occluded ones. Doubt varies by a factor of e^SPREAD (one std).
DOUBT = 0.01
HIDDEN_DOUBT = 0.15
SPREAD = 0.7


def confidence(
    visible: Float[Array, " n"],
    seed: int,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    level: float = 1.0,
) -> Float[Array, " n"]:
    """Probabilities in [0, 1]: 1 - level * (DOUBT + HIDDEN_DOUBT * (1 - visible)^2) * noise."""
    noise = np.exp(SPREAD * draws.normal(seed, "score", ids, frames)[:, 0])
    doubt = level * (DOUBT + HIDDEN_DOUBT * np.square(1.0 - visible)) * noise
    return (1.0 - doubt).clip(0.0, 1.0)
