"""Two views of the same points: the rotation between them and the direction of the motion.

A point with rays b (before) and n (now), both of depth 1, keeps n . (d x R b) = 0 with the
rotation R and the unit translation d of T_now_before. A first solution comes from OpenCV's USAC
with a seed of its own; then all points are weighed (Cauchy) by Sampson's distance.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.ego.rotations import rotation_of

MAX_ROUNDS = 8
MIN_CURVATURE = 1e-12


@dataclass(frozen=True, eq=False)
class Relative:
    """A motion up to its length."""

    R: Float[Array, "3 3"]
    """Rotation of T_now_before."""
    direction: Float[Array, "3"]
    """Unit vector of its translation, camera frame of now."""
    tangents: Float[Array, "3 2"]
    """Two unit vectors across the direction, one per column."""
    cov: Float[Array, "5 5"]
    """Covariance of (direction along the two tangents, left rotation vector), rad."""
    agreeing: Bool[Array, " n"]
    """Which points fit."""
    spread: float
    """What they miss by, in units of rays with depth 1."""


def relative_motion(
    before: Float[Array, "n 3"], now: Float[Array, "n 3"], noise: float, seed: int = 1
) -> Relative | None:
    """The motion between rays of the same points; None where no essential matrix fits.

    noise: standard deviation of a ray (a pixel's, divided by the focal length).
    """
    start = _essential(before, now, 2.5 * noise, seed)
    return None if start is None else _refine(*start, before, now, noise)


def turn_alone(
    before: Float[Array, "n 3"], now: Float[Array, "n 3"], noise: float
) -> tuple[Float[Array, "3 3"], float]:
    """The rotation that alone explains the points best, and the median of what it misses by."""
    b = before / np.linalg.norm(before, axis=1, keepdims=True)
    n = now / np.linalg.norm(now, axis=1, keepdims=True)
    R, weights = np.eye(3), np.ones(len(b))
    missed = np.zeros(len(b))
    for _ in range(MAX_ROUNDS):
        U, _, Vt = np.linalg.svd((n * weights[:, None]).T @ b)
        R = U @ np.diag([1.0, 1.0, float(np.sign(np.linalg.det(U @ Vt)))]) @ Vt
        missed = np.linalg.norm(n - b @ R.T, axis=1)
        weights = 1.0 / (1.0 + (missed / noise) ** 2)
    return R, float(np.median(missed))


def _essential(
    before: Float[Array, "n 3"], now: Float[Array, "n 3"], threshold: float, seed: int
) -> tuple[Float[Array, "3 3"], Float[Array, "3"]] | None:
    """R and d by USAC. (OpenCV 5 finds nothing when it is given pixels and K: hence rays.)"""
    if len(before) < 8:
        return None
    parameters = cv2.UsacParams()
    parameters.threshold, parameters.confidence = threshold, 0.999
    parameters.maxIterations, parameters.randomGeneratorState = 1000, seed
    eye = np.eye(3)
    b, n = np.ascontiguousarray(before[:, :2]), np.ascontiguousarray(now[:, :2])
    E, mask = cv2.findEssentialMat(b, n, eye, eye, None, None, parameters)
    if E is None or mask is None or E.shape != (3, 3) or not np.isfinite(E).all():
        return None
    first, second, d = cv2.decomposeEssentialMat(E)
    R = first if np.trace(first) > np.trace(second) else second  # no half turns between frames
    return R, _towards(R, d[:, 0], b[mask[:, 0] > 0], n[mask[:, 0] > 0])


def _towards(
    R: Float[Array, "3 3"],
    d: Float[Array, "3"],
    before: Float[Array, "n 2"],
    now: Float[Array, "n 2"],
) -> Float[Array, "3"]:
    """d or -d: points in front of the camera move along d, in the image from R b on."""
    turned = before @ R[:, :2].T + R[:, 2]
    start = turned[:, :2] / turned[:, 2:]
    along = ((now - start) * (d[:2] - start * d[2])).sum(axis=1)
    return d if np.sign(along).sum() >= 0.0 else -d


def _refine(
    R: Float[Array, "3 3"],
    d: Float[Array, "3"],
    before: Float[Array, "n 3"],
    now: Float[Array, "n 3"],
    noise: float,
) -> Relative | None:
    """Gauss and Newton on Sampson's distances of all points, Cauchy weights."""
    size, settled = np.inf, 0.01 * noise
    for left in range(MAX_ROUNDS, -1, -1):
        misses, jacobian, tangents = _sampson(R, d, before, now)
        weights = 1.0 / (1.0 + (misses / noise) ** 2)
        curvature = jacobian.T @ (jacobian * weights[:, None]) + MIN_CURVATURE * np.eye(5)
        if not left or size < settled:
            break
        step = -np.linalg.solve(curvature, jacobian.T @ (weights * misses))
        d = d + tangents @ step[:2]
        d, R = d / np.linalg.norm(d), rotation_of(step[2:]) @ R
        size = float(np.abs(step).max())
    if not (np.isfinite(R).all() and np.isfinite(d).all()):
        return None
    spread = float(np.sqrt((weights * misses**2).sum() / max(weights.sum(), MIN_CURVATURE)))
    cov = np.linalg.inv(curvature) * max(spread, 0.1 * noise) ** 2
    return Relative(R, d, tangents, cov, np.abs(misses) < 3.0 * noise, spread)


def _sampson(
    R: Float[Array, "3 3"],
    d: Float[Array, "3"],
    before: Float[Array, "n 3"],
    now: Float[Array, "n 3"],
) -> tuple[Float[Array, " n"], Float[Array, "n 5"], Float[Array, "3 2"]]:
    """Sampson's distances, their derivatives by (d's tangents, left rotation), the tangents."""
    turned = before @ R.T
    line_now, line_turned = np.cross(d, turned), np.cross(now, d)
    line_before = line_turned @ R
    length = np.sqrt((line_now[:, :2] ** 2).sum(axis=1) + (line_before[:, :2] ** 2).sum(axis=1))
    length += MIN_CURVATURE
    across = np.cross(d, np.eye(3)[np.argmin(np.abs(d))])
    across /= np.linalg.norm(across)
    tangents = np.stack((across, np.cross(d, across)), axis=1)
    jacobian = np.hstack((np.cross(turned, now) @ tangents, np.cross(turned, line_turned)))
    return (now * line_now).sum(axis=1) / length, jacobian / length[:, None], tangents
