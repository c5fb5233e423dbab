"""Events that come in bursts: a latent with memory, thresholded at the momentary rate."""

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import ndtr

from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normals

FRAME = -1  # the id of what belongs to a frame and to no object


def with_frame_noise(
    own: Float[Array, " n"],
    seed: int,
    effect: str,
    frames: Int[Array, " n"],
    shared: float,
    seconds: float,
    step: float,
) -> Float[Array, " n"]:
    """Latents of which a share of the variance is the frame's and lasts some seconds."""
    if shared == 0.0:
        return own
    every, row = np.unique(frames, return_inverse=True)
    nobody = np.full_like(every, FRAME)
    common = correlated_normals(
        seed, f"{effect}/frame", nobody, every, Autocorrelation((1.0,), (seconds,)), step
    )
    return np.sqrt(1.0 - shared) * own + np.sqrt(shared) * common[row, 0]


def bursts(
    rates: Float[Array, " n"],
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    memory: Autocorrelation,
    step: float,
) -> Bool[Array, " n"]:
    """Where the event happens; no rate, no event. A higher rate has the same events and more.

    The marginal rate is exact whatever the memory, also while the rate varies.
    """
    happens = np.zeros(len(ids), bool)
    possible = np.flatnonzero(rates > 0.0)
    if len(possible):
        x = correlated_normals(seed, effect, ids[possible], frames[possible], memory, step)[:, 0]
        happens[possible] = ndtr(x) < rates[possible]
    return happens
