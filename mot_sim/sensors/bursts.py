"""Events that come in bursts: a latent with memory, thresholded at the momentary rate."""

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import ndtr

from mot_sim.sensors.memory import Memory, latent

FRAME = -1  # the id of what belongs to a frame and to no object


def pressure(
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    memory: Memory,
    step: float,
    shared: float = 0.0,
    shared_seconds: float = 0.0,
) -> Float[Array, " n"]:
    """Uniform numbers in (0, 1), correlated in time; an event is where one is below its rate.

    The marginal rate is then exact whatever the memory, also while the rate varies. shared: the
    share of the latent's variance that all objects of a frame have in common.
    """
    own = latent(seed, effect, ids, frames, memory, step)[:, 0]
    if shared > 0.0:
        every, row = np.unique(frames, return_inverse=True)
        glare = Memory((1.0,), (shared_seconds,))
        common = latent(seed, f"{effect}/frame", np.full_like(every, FRAME), every, glare, step)
        own = np.sqrt(1.0 - shared) * own + np.sqrt(shared) * common[row, 0]
    return ndtr(own)


def bursts(
    rates: Float[Array, " n"],
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    memory: Memory,
    step: float,
) -> Bool[Array, " n"]:
    """Where the event happens; no rate, no event. A higher rate has the same events and more."""
    happens = np.zeros(len(ids), bool)
    possible = np.flatnonzero(rates > 0.0)
    happens[possible] = (
        pressure(seed, effect, ids[possible], frames[possible], memory, step) < rates[possible]
    )
    return happens
