"""The shipped files are what the documented command makes."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.simulation.cars.build import (
    FLEET_ARRAYS,
    POPULATION_COUNT,
    build_files,
    keypoint_prior,
    population,
)
from mot_sim.simulation.cars.design import BODIES
from mot_sim.simulation.cars.fleet import load_fleet, read_fleet
from tracker.shape import KEYPOINTS, load_prior


def test_the_population_is_a_function_of_its_seed() -> None:
    first, bodies = population(40, 1)
    again, _ = population(40, 1)
    other, _ = population(40, 2)
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()
    assert len(first) == len(bodies)
    assert set(bodies) <= set(range(len(BODIES)))
    assert POPULATION_COUNT >= 1000


@pytest.mark.slow
def test_the_shipped_files_are_those_of_the_population(tmp_path: Path) -> None:
    build_files(tmp_path / "fleet.npz", tmp_path / "prior.npz", tmp_path / "coarse.npz")
    made, shipped = read_fleet(tmp_path / "fleet.npz", 20), load_fleet(20)
    for name in FLEET_ARRAYS:
        ours, theirs = getattr(made.components, name), getattr(shipped.components, name)
        np.testing.assert_allclose(ours, theirs, atol=2e-4)
    prior = load_prior(tmp_path / "prior.npz", KEYPOINTS)
    np.testing.assert_allclose(prior.vectors, load_prior(points=KEYPOINTS).vectors, atol=2e-4)
    np.testing.assert_array_equal(prior.mean, keypoint_prior(made.components).mean)
