"""What holds for every scene of the register: nobody collides, seeds matter, cars are seen."""

import numpy as np
import pytest

from mot_sim.simulation.registry import SCENES, find_scene
from mot_sim.simulation.scene import Rollout, record_scene_traffic
from mot_sim.simulation.traffic import collisions
from mot_sim.simulation.truth import annotate

FRAMES = 20
SCRIPTED = ("crossing",)  # the same traffic for every seed


@pytest.fixture(scope="module", params=sorted(SCENES))
def rollout(request) -> Rollout:
    return Rollout.of(find_scene(request.param, frames=FRAMES), 3)


def test_nobody_touches_anybody(rollout) -> None:
    for state in rollout.traffic_states:
        assert len(collisions(state)) == 0, f"{take.scene.name} at {world.time:g} s"


def test_the_same_seed_gives_the_same_traffic_and_another_seed_another(rollout) -> None:
    again = record_scene_traffic(find_scene(rollout.scene.name, frames=FRAMES), 3)
    assert again.checksum == rollout.traffic.checksum
    other = record_scene_traffic(find_scene(rollout.scene.name, frames=FRAMES), 4)
    assert (other.checksum == rollout.traffic.checksum) == (rollout.scene.name in SCRIPTED)


def test_cars_are_seen_and_nobody_jumps(rollout) -> None:
    truth = annotate(rollout.traffic_states[::12], rollout.scene_meshes, rollout.scenery_in).truth
    assert (truth.pixels > 0).sum() >= 2
    traffic = rollout.traffic
    step = np.hypot(np.diff(traffic.x, axis=0), np.diff(traffic.y, axis=0))
    there = traffic.present[1:] & traffic.present[:-1]
    assert (step[there] <= 0.1 * 45.0).all()


def test_cars_of_one_model_have_its_size(rollout) -> None:
    for shape, size in zip(
        rollout.scene_meshes.vehicles.shapes, rollout.scene_meshes.vehicles.size, strict=True
    ):
        np.testing.assert_allclose(np.ptp(shape.vertices, axis=0), size, atol=1e-9)


def test_drivers_err_and_our_car_tilts_in_a_live_scene_where_that_is_asked_for() -> None:
    plain, shaken = (
        record_scene_traffic(find_scene("street", frames=4, wander=level, bumps=level), 3)
        for level in (0.0, 1.0)
    )
    assert plain.tilt is None
    assert shaken.tilt is not None
    assert np.abs(shaken.tilt).max() > 0.0
    assert np.abs(shaken.y[-1] - plain.y[-1]).max() > 0.05
