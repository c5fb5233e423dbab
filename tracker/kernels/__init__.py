"""Compiled inner loops, and how they are loaded: nothing compiles before it is first called.

A module here holds functions for numba, each with one signature (`kernel`), and imports nothing of
the tracker's but its neighbours. The typed functions of other rooms call them through a `Kernel`.
"""

from tracker.kernels.loading import (
    Kernel,
    Warmed,
    cache_folder,
    folders_in_use,
    load,
    modules_of,
    warm,
)

__all__ = [
    "Kernel",
    "Warmed",
    "cache_folder",
    "folders_in_use",
    "load",
    "modules_of",
    "warm",
]
