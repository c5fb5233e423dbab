"""Builds the shipped files: `python -m mot_sim.simulation.cars.build`, after a change of design.

A seeded population of cars, its mean and its principal components: where eq. 1 comes from. One
population gives both the mesh basis of the fleet and the keypoint prior of the tracker, so the
same coefficients mean the same car in both.
"""

from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Int, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.cars.coarse import LEVEL_DISTANCES, SHIPPED_COARSE, simplify
from mot_sim.simulation.cars.design import BODIES, BODY_SHARES, draw_designs
from mot_sim.simulation.cars.finish import SHIPPED_OPENNESS, openness_of
from mot_sim.simulation.cars.fleet import FLEET_ARRAYS, MAX_COEFFICIENTS, SHIPPED_FLEET, Components
from mot_sim.simulation.cars.topology import (
    authors_keypoints,
    half_keypoints,
    half_points,
    topology,
    whole,
)
from mot_sim.simulation.random_numbers import named_stream
from tracker.shape import KEYPOINTS, SHIPPED_PRIOR, ShapeBasis, save_prior

POPULATION_SEED = 2018
POPULATION_COUNT = 1600
KEYPOINT_SHARE = 0.5  # how much the keypoints count against all points of the mesh
AT_EDGE_METRES = 1e-6  # metres
DECIMALS = 6  # micrometres: what differs between processors stays below


def population(
    count: int = POPULATION_COUNT, seed: int = POPULATION_SEED
) -> tuple[Float[Array, "n h 3"], Int[Array, " n"]]:
    """The left halves of `count` cars and the number of each one's body in BODIES.

    A function of the seed alone. The bodies come in fixed shares.
    """
    halves, bodies = [], []
    for number, body in enumerate(BODIES):
        cars = round(count * BODY_SHARES[body])
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
    from scipy.linalg import eigh

    mean = halves.mean(axis=0)
    offsets = (halves - mean).reshape(len(halves), -1)
    marks = (half_keypoints(halves)[:, :18] - half_keypoints(mean)[:18]).reshape(len(halves), -1)
    weight = np.sqrt((offsets**2).sum() / (marks**2).sum() * KEYPOINT_SHARE / (1 - KEYPOINT_SHARE))
    joint = np.concatenate((offsets, weight * marks), axis=1)
    order = joint.shape[1]
    values, axes = eigh(
        joint.T @ joint / len(halves), subset_by_index=(order - MAX_COEFFICIENTS, order - 1)
    )
    # Coefficients have the unit of a root mean square shift of the points.
    scores = joint @ axes[:, ::-1] / np.sqrt(order / 3)
    std = np.sqrt(values[::-1] / (order / 3))
    vectors = scores.T @ offsets / (len(halves) * std[:, None] ** 2)
    sign = np.sign(vectors[np.arange(MAX_COEFFICIENTS), np.abs(vectors).argmax(axis=1)])
    lambdas, vectors = scores * sign, vectors * sign[:, None]
    means = np.stack([lambdas[bodies == body].mean(axis=0) for body in range(len(BODIES))])
    roots = np.stack(
        [np.linalg.cholesky(np.cov(lambdas[bodies == body].T)) for body in range(len(BODIES))]
    )
    return Components(mean, vectors.reshape(MAX_COEFFICIENTS, -1, 3), std, means, roots)


def build_components() -> Components:
    """The components of the population, rounded as they are shipped."""
    exact = components(*population())
    return Components(*(np.round(getattr(exact, name), DECIMALS) + 0.0 for name in FLEET_ARRAYS))


def keypoint_prior(fleet: Components) -> ShapeBasis:
    """The keypoints of the same cars, with the same coefficients."""
    mean, vectors = authors_keypoints(fleet.mean), authors_keypoints(fleet.vectors)
    return ShapeBasis(KEYPOINTS, mean, vectors, fleet.std)


def coarse_arrays(fleet: Components) -> dict[str, Any]:
    """The coarser meshes, for the mean cars of all bodies at once."""
    shared = topology()
    halves = fleet.mean + np.tensordot(fleet.body_means, fleet.vectors, axes=1)
    shapes = whole(halves)
    low, high = shapes.min(axis=1, keepdims=True), shapes.max(axis=1, keepdims=True)
    reaches_out = (shapes - low < AT_EDGE_METRES) | (high - shapes < AT_EDGE_METRES)
    locked = reaches_out.any(axis=(0, 2))  # so that sizes stay exact
    arrays: dict[str, Any] = {}
    for count in LEVEL_DISTANCES:
        level = simplify(shapes, shared.faces, shared.parts, locked, count)
        arrays |= {f"faces{count}": level.faces, f"origins{count}": level.origins}
    return arrays


def mean_openness(fleet: Components) -> UInt8[Array, " v"]:
    """How much light each point of the mean car gets, 255 = all; of the shared mesh's points."""
    vertices = whole(fleet.mean)
    found = openness_of(vertices, topology().faces, np.ptp(vertices, axis=0))
    found = 0.5 * (found + found[_twins()])
    return np.round(255.0 * found.clip(0.0, 1.0)).astype(np.uint8)


def _twins() -> Int[Array, " v"]:
    """For each point of the mesh the one on the other side; itself on the middle plane."""
    shared, count = topology(), len(topology().twins)
    twins = np.arange(count)
    right = np.flatnonzero(shared.on_right)
    twins[right], twins[shared.twins[right]] = shared.twins[right], right
    return twins


def build_files(
    fleet_path: Path = SHIPPED_FLEET,
    prior_path: Path = SHIPPED_PRIOR,
    coarse_path: Path = SHIPPED_COARSE,
    openness_path: Path = SHIPPED_OPENNESS,
) -> None:
    """Write the files."""
    fleet = build_components()
    np.savez_compressed(fleet_path, **{name: getattr(fleet, name) for name in FLEET_ARRAYS})
    save_prior(keypoint_prior(fleet), prior_path)
    np.savez_compressed(coarse_path, **coarse_arrays(fleet))
    np.savez_compressed(openness_path, openness=mean_openness(fleet))


if __name__ == "__main__":
    build_files()
