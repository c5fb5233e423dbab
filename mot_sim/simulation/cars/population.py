"""A seeded population of cars, its mean and its principal components: where eq. 1 comes from.

`python -m mot_sim.simulation.cars.build` writes the two files that are shipped: the mesh basis of the
fleet and the keypoint prior of the tracker. They share their coefficients.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array
from scipy.linalg import eigh

from mot_sim.simulation.cars.body import half_keypoints, half_points
from mot_sim.simulation.cars.design import BODIES, SHARES, draw_designs
from mot_sim.simulation.random_numbers import named_stream

SHIPPED_FLEET = Path(__file__).with_name("fleet.npz")
SEED = 2018
CARS = 1600
COMPONENTS = 20  # the most coefficients that a fleet may use
KEYPOINT_SHARE = 0.5  # how much the keypoints count against all points of the mesh


@dataclass(frozen=True, eq=False)
class Components:
    """Mean and principal components of the left halves of cars, and where the bodies lie.

    mean, vectors: `half_points`, metres. std: of each coefficient. body_means, body_roots: mean
    and a root of the covariance of the coefficients of every body, in the order of BODIES.
    """

    mean: Float[Array, "h 3"]
    vectors: Float[Array, "b h 3"]
    std: Float[Array, " b"]
    body_means: Float[Array, "m b"]
    body_roots: Float[Array, "m b b"]


ARRAYS = ("mean", "vectors", "std", "body_means", "body_roots")  # what the file holds


def population(
    count: int = CARS, seed: int = SEED
) -> tuple[Float[Array, "n h 3"], Int[Array, " n"]]:
    """The left halves of `count` cars and the number of each one's body in BODIES.

    A function of the seed alone. The bodies come in fixed shares.
    """
    halves, bodies = [], []
    for number, body in enumerate(BODIES):
        cars = round(count * SHARES[body])
        designs = draw_designs(body, cars, named_stream(seed, f"designs of {body}"))
        halves.append(half_points(designs))
        bodies.append(np.full(cars, number))
    return np.concatenate(halves), np.concatenate(bodies)


def components(halves: Float[Array, "n h 3"], bodies: Int[Array, " n"]) -> Components:
    """The principal components over points and keypoints jointly.

    Points and keypoints are weighted so that the keypoints make up KEYPOINT_SHARE of the
    population's variance. The signs are fixed: the coordinate that moves most moves
    towards +.
    """
    mean = halves.mean(axis=0)
    offsets = (halves - mean).reshape(len(halves), -1)
    marks = (half_keypoints(halves)[:, :18] - half_keypoints(mean)[:18]).reshape(len(halves), -1)
    weight = np.sqrt((offsets**2).sum() / (marks**2).sum() * KEYPOINT_SHARE / (1 - KEYPOINT_SHARE))
    joint = np.concatenate((offsets, weight * marks), axis=1)
    order = joint.shape[1]
    values, axes = eigh(
        joint.T @ joint / len(halves), subset_by_index=(order - COMPONENTS, order - 1)
    )
    # Coefficients have the unit of a root mean square shift of the points.
    scores = joint @ axes[:, ::-1] / np.sqrt(order / 3)
    std = np.sqrt(values[::-1] / (order / 3))
    vectors = scores.T @ offsets / (len(halves) * std[:, None] ** 2)
    sign = np.sign(vectors[np.arange(COMPONENTS), np.abs(vectors).argmax(axis=1)])
    lambdas, vectors = scores * sign, vectors * sign[:, None]
    means = np.stack([lambdas[bodies == body].mean(axis=0) for body in range(len(BODIES))])
    roots = np.stack(
        [np.linalg.cholesky(np.cov(lambdas[bodies == body].T)) for body in range(len(BODIES))]
    )
    return Components(mean, vectors.reshape(COMPONENTS, -1, 3), std, means, roots)
