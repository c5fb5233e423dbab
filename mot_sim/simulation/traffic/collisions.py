"""Who touches whom: pairs of rectangles that overlap."""

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.simulation.traffic.traffic_state import TrafficState, outline


def colliding_pairs(poses: Float[Array, "n 3"], size: Float[Array, "n 3"]) -> Int[Array, "p 2"]:
    """Rows i < j of cars at poses x, y, heading whose footprints share some area."""
    reach = 0.5 * np.hypot(size[:, 0], size[:, 2])
    apart = np.hypot(*(poses[:, None, :2] - poses[None, :, :2]).transpose(2, 0, 1))
    near = np.argwhere(np.triu(apart < reach[:, None] + reach[None], k=1))
    if not len(near):
        return near
    corners = outline(poses, size)
    first, second = corners[near[:, 0]], corners[near[:, 1]]
    touch = ~(_is_apart(first, second) | _is_apart(second, first))
    return near[touch]


def collisions(world: TrafficState) -> Int[Array, "p 2"]:
    """Ids of the cars of a world that overlap, the smaller id first; -1 is the ego car."""
    poses = np.column_stack((world.x, world.y, world.heading))
    pairs = colliding_pairs(np.vstack((world.ego, poses)), np.vstack((world.ego_size, world.size)))
    return np.concatenate(([-1], world.ids))[pairs]


def _is_apart(first: Float[Array, "p 4 2"], second: Float[Array, "p 4 2"]) -> Bool[Array, " p"]:
    """Whether a side of the first rectangle separates it from the second."""
    sides = np.stack((first[:, 1] - first[:, 0], first[:, 2] - first[:, 1]), axis=1)
    own = np.einsum("psk,pck->psc", sides, first)
    other = np.einsum("psk,pck->psc", sides, second)
    gap = (other.min(axis=2) >= own.max(axis=2)) | (own.min(axis=2) >= other.max(axis=2))
    return gap.any(axis=1)
