"""Makes the three shipped files: `python -m mot_sim.simulation.cars.build`, after a change of the design.

One population gives both the mesh basis of the fleet and the keypoint prior of the tracker, so
the same coefficients mean the same car in both.
"""

from pathlib import Path
from typing import Any

import numpy as np

from mot_sim.simulation.cars.body import authors_keypoints, whole
from mot_sim.simulation.cars.coarse import LEVELS, SHIPPED_COARSE, simplify
from mot_sim.simulation.cars.population import (
    ARRAYS,
    SHIPPED_FLEET,
    Components,
    components,
    population,
)
from mot_sim.simulation.cars.topology import topology
from tracker.shape import KEYPOINTS, SHIPPED_PRIOR, ShapeBasis, save_prior

AT_EDGE = 1e-6  # metres
DECIMALS = 6  # micrometres: what differs between processors stays below


def build_components() -> Components:
    """The components of the population, rounded as they are shipped."""
    exact = components(*population())
    return Components(*(np.round(getattr(exact, name), DECIMALS) + 0.0 for name in ARRAYS))


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
    reaches_out = (shapes - low < AT_EDGE) | (high - shapes < AT_EDGE)
    locked = reaches_out.any(axis=(0, 2))  # so that sizes stay exact
    arrays: dict[str, Any] = {}
    for count in LEVELS:
        level = simplify(shapes, shared.faces, shared.parts, locked, count)
        arrays |= {f"faces{count}": level.faces, f"origins{count}": level.origins}
    return arrays


def build_files(
    fleet_path: Path = SHIPPED_FLEET,
    prior_path: Path = SHIPPED_PRIOR,
    coarse_path: Path = SHIPPED_COARSE,
) -> None:
    """Write the files."""
    fleet = build_components()
    np.savez_compressed(fleet_path, **{name: getattr(fleet, name) for name in ARRAYS})
    save_prior(keypoint_prior(fleet), prior_path)
    np.savez_compressed(coarse_path, **coarse_arrays(fleet))


if __name__ == "__main__":
    build_files()
