"""Box edges that are off by a part of the box's size."""

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim import draws

# Std of an edge as a fraction of the box's side: RRC's lower edges on KITTI are off by 2.7-3.1 %.
EDGE_STD = 0.03
MAX_STD = 3.0  # no edge is further off than this many std, so that no box turns inside out


def jitter_boxes(
    boxes: Float[Array, "n 4"],
    seed: int,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    level: float = 1.0,
) -> Float[Array, "n 4"]:
    """The boxes with every edge moved by a normal error, its std level * EDGE_STD of the side."""
    sides = np.tile(boxes[:, 2:] - boxes[:, :2], (1, 2))
    errors = draws.normal(seed, "jitter", ids, frames, 4).clip(-MAX_STD, MAX_STD)
    return boxes + level * EDGE_STD * sides * errors
