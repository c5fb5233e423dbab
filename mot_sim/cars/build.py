"""Makes the two shipped files: `python -m mot_sim.cars.build`, after a change of the design.

One population gives both the mesh basis of the fleet and the keypoint prior of the tracker, so
the same coefficients mean the same car in both.
"""

from pathlib import Path

import numpy as np

from mot_sim.cars.body import authors_keypoints
from mot_sim.cars.population import ARRAYS, SHIPPED_FLEET, Components, components, population
from tracker.shape import KEYPOINTS, SHIPPED_PRIOR, ShapeBasis, save_prior

DECIMALS = 6  # micrometres: what differs between processors stays below


def build() -> Components:
    """The components of the population, rounded as they are shipped."""
    exact = components(*population())
    return Components(*(np.round(getattr(exact, name), DECIMALS) + 0.0 for name in ARRAYS))


def keypoint_prior(fleet: Components) -> ShapeBasis:
    """The keypoints of the same cars, with the same coefficients."""
    mean, vectors = authors_keypoints(fleet.mean), authors_keypoints(fleet.vectors)
    return ShapeBasis(KEYPOINTS, mean, vectors, fleet.std)


def main(fleet_path: Path = SHIPPED_FLEET, prior_path: Path = SHIPPED_PRIOR) -> None:
    """Write both files."""
    fleet = build()
    np.savez_compressed(fleet_path, **{name: getattr(fleet, name) for name in ARRAYS})
    save_prior(keypoint_prior(fleet), prior_path)


if __name__ == "__main__":
    main()
