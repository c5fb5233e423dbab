"""What the network is asked for: the cell of each keypoint that is seen, or that it is not seen."""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float32
from numpy import ndarray as Array

from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.augment import AugmentedCrops
from mot_sim.training.pytorch import load_torch

TARGET_STD_CELLS = 0.8  # cells: the standard deviation of the wanted map around a keypoint


def target_maps(
    shown: AugmentedCrops, cells: int
) -> tuple[Float32[Array, "n k c"], Bool[Array, "n k"]]:
    """The wanted chance of each of cells x cells cells, and then that of `not seen`.

    A visible keypoint is a small hill, any other is not seen; the second: which are visible.
    """
    seen = shown.states == KeypointVisibility.VISIBLE
    at = np.where(seen[:, :, None], shown.keypoints, 0.5) * cells - 0.5
    off = np.arange(cells) - at[:, :, :, None]
    hills = np.exp(-0.5 * (off / TARGET_STD_CELLS) ** 2)
    hills /= hills.sum(axis=3, keepdims=True)
    maps = hills[:, :, 1, :, None] * hills[:, :, 0, None, :] * seen[:, :, None, None]
    flat = maps.reshape(*seen.shape, cells * cells)
    chances = np.concatenate((flat, ~seen[:, :, None]), axis=2)
    return chances.astype(np.float32), seen


def keypoint_loss(every: list[Any], chances: Any) -> Any:
    """Cross-entropy of the maps of every stack, a keypoint; `not seen` has the log odds 0."""
    torch = load_torch()
    total = 0.0
    for maps in every:
        flat = maps.float().flatten(2)
        odds = torch.cat((flat, torch.zeros_like(flat[:, :, :1])), 2)
        total = total - (chances * odds.log_softmax(2)).sum(2).mean()
    return total / len(every)
