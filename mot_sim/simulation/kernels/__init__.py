"""Compiled inner loops of the truth and the renderer; `tracker.kernels` loads them."""

PACKAGE = "mot_sim.simulation.kernels"

__all__ = ["PACKAGE"]
