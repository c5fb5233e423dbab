"""Levenberg-Marquardt over all cars at once: robust keypoints, Gaussian priors.

The cost of a car is a negative log-likelihood: 1/2 sum rho(e^2) + 1/2 (theta - theta0)^T D
(theta - theta0), with e a point's distance in standard deviations and rho(e^2) = c^2 log(1 +
e^2 / c^2) (Cauchy): points that are far off pull ever less. Weights are re-made every step.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.shape.projection import MIN_POINT_DEPTH, ObservedPoints, residuals

MIN_STEP = 1e-4  # of a last step; in standard deviations of the result, 1 % of one
FIRST_DAMPING, MIN_DAMPING, MAX_DAMPING = 1e-4, 1e-9, 1e8


@dataclass(frozen=True, eq=False)
class Solved:
    """What `solve` found, one row per car."""

    cars: Float[Array, "n p"]
    """The unknowns, in the order of `tracker.shape.projection`."""
    cost: Float[Array, " n"]
    """Negative log-likelihood of each car, see above."""
    normal: Float[Array, "n f f"]
    """Gauss-Newton Hessian of the free unknowns."""


@dataclass(frozen=True, eq=False)
class _Point:
    """The cost at some cars, its gradient and its Hessian."""

    cost: Float[Array, " n"]
    gradient: Float[Array, "n f"]
    normal: Float[Array, "n f f"]


def _evaluate(
    observed: ObservedPoints,
    cars: Float[Array, "n p"],
    free: Int[Array, " f"],
    precision: Float[Array, " p"],
    kernel: Float[Array, "n k"],
) -> _Point:
    """Cost, gradient and Hessian; the cost of a car with a seen point behind the camera is inf."""
    off, jacobian, depth = residuals(observed, cars, free)
    squares = (observed.weights * off * off).sum(axis=1)
    width = kernel * kernel
    excess = squares / width
    prior = precision[free] * cars[:, free]
    cost = 0.5 * (width * np.log1p(excess)).sum(axis=1)
    cost += 0.5 * (prior * cars[:, free]).sum(axis=1)
    behind = (depth < MIN_POINT_DEPTH) & (observed.weights[:, 0] > 0.0)
    cost[behind.any(axis=1)] = np.inf
    root = np.sqrt(observed.weights / (1.0 + excess)[:, None])
    n, f = len(cars), len(free)
    jacobian *= root[:, None]
    J = jacobian.reshape(n, f, off[0].size if n else 0)
    gradient = (J @ (off * root).reshape(n, J.shape[2], 1))[:, :, 0] + prior
    normal = J @ J.transpose(0, 2, 1)
    normal[:, np.arange(f), np.arange(f)] += precision[free]
    return _Point(cost, gradient, normal)


def solve(
    observed: ObservedPoints,
    cars: Float[Array, "n p"],
    free: Int[Array, " f"],
    precision: Float[Array, " p"],
    kernel: Float[Array, "n k"],
    steps: int,
    smallest: float = MIN_STEP,
) -> Solved:
    """The cars of least cost near the given ones, moving only their `free` unknowns.

    precision: 1 / variance of each unknown's prior around 0 (0: flat). kernel: c of every point.
    A car is finished after a step that was to lower its cost by less than `smallest`, or after
    `steps` of them; whoever is finished costs nothing any more.
    """
    cars = cars.copy()
    point = _evaluate(observed, cars, free, precision, kernel)
    cost, normal = point.cost, point.normal
    rows, damping = np.arange(len(cars)), np.full(len(cars), FIRST_DAMPING)
    for _ in range(steps):
        if not len(rows):
            break
        step, gain = _damped_step(point, damping)
        tried = cars[rows]
        tried[:, free] -= step
        new = _evaluate(observed, tried, free, precision, kernel)
        better = new.cost <= point.cost
        cars[rows[better]] = tried[better]
        cost[rows[better]] = new.cost[better]
        normal[rows[better]] = new.normal[better]
        point = _taken(point, new, better)
        damping = np.where(better, damping * 0.1, np.maximum(damping, 1e-6) * 30.0)
        damping = np.maximum(damping, MIN_DAMPING)
        goes_on = (~better | (gain > smallest)) & (damping < MAX_DAMPING)
        if not goes_on.all():
            rows, damping, kernel = rows[goes_on], damping[goes_on], kernel[goes_on]
            observed = observed.rows(np.flatnonzero(goes_on))
            point = _Point(point.cost[goes_on], point.gradient[goes_on], point.normal[goes_on])
    return Solved(cars, cost, normal)


def inverses(normal: Float[Array, "n f f"]) -> Float[Array, "n f f"]:
    """The covariances that belong to Hessians; huge where the points tell nothing."""
    diagonal = np.sqrt(np.maximum(np.diagonal(normal, axis1=1, axis2=2), 1e-12))
    scales = diagonal[:, :, None] * diagonal[:, None]
    # In units of the diagonal a singular matrix is told from a merely lopsided one.
    return np.linalg.inv(normal / scales + 1e-13 * np.eye(normal.shape[1])) / scales


def _damped_step(
    point: _Point, damping: Float[Array, " n"]
) -> tuple[Float[Array, "n f"], Float[Array, " n"]]:
    """The step to subtract, and by how much it should lower the cost."""
    diagonal = np.arange(point.normal.shape[1])
    matrix = point.normal.copy()
    matrix[:, diagonal, diagonal] *= 1.0 + damping[:, None]
    matrix[:, diagonal, diagonal] += 1e-12
    step = np.linalg.solve(matrix, point.gradient[:, :, None])[:, :, 0]
    return step, 0.5 * (step * point.gradient).sum(axis=1)


def _taken(old: _Point, new: _Point, better: Bool[Array, " n"]) -> _Point:
    """The new point where it is better."""
    if better.all():
        return new
    return _Point(
        np.where(better, new.cost, old.cost),
        np.where(better[:, None], new.gradient, old.gradient),
        np.where(better[:, None, None], new.normal, old.normal),
    )
