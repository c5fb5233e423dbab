"""Rays against triangles, one ray at a time: an oracle that knows nothing of cars."""

import numpy as np


def hits(
    triangles: np.ndarray, origin: np.ndarray, direction: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How far along the ray it meets triangles, and which (Moller and Trumbore)."""
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(direction, second)
    determinant = (first * across).sum(axis=1)
    usable = np.abs(determinant) > 1e-12
    scale = 1.0 / np.where(usable, determinant, 1.0)
    offset = origin - triangles[:, 0]
    u = (offset * across).sum(axis=1) * scale
    turned = np.cross(offset, first)
    v = (direction * turned).sum(axis=1) * scale
    depth = (second * turned).sum(axis=1) * scale
    met = np.flatnonzero(usable & (u >= 0) & (v >= 0) & (u + v <= 1) & (depth > 0))
    met = met[np.argsort(depth[met])]
    return depth[met], met
