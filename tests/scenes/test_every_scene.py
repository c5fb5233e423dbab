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
def take(request) -> Rollout:
    return Rollout.of(find_scene(request.param, frames=FRAMES), 3)


def test_nobody_touches_anybody(take) -> None:
    for world in take.traffic_states:
        assert len(collisions(world)) == 0, f"{take.scene.name} at {world.time:g} s"


def test_the_same_seed_gives_the_same_traffic_and_another_seed_another(take) -> None:
    again = record_scene_traffic(find_scene(take.scene.name, frames=FRAMES), 3)
    assert again.checksum == take.traffic.checksum
    other = record_scene_traffic(find_scene(take.scene.name, frames=FRAMES), 4)
    assert (other.checksum == take.traffic.checksum) == (take.scene.name in SCRIPTED)


def test_cars_are_seen_and_nobody_jumps(take) -> None:
    truth = annotate(take.traffic_states[::12], take.scene_meshes, take.scenery_in).truth
    assert (truth.pixels > 0).sum() >= 2
    traffic = take.traffic
    step = np.hypot(np.diff(traffic.x, axis=0), np.diff(traffic.y, axis=0))
    there = traffic.present[1:] & traffic.present[:-1]
    assert (step[there] <= 0.1 * 45.0).all()


def test_cars_of_one_model_have_its_size(take) -> None:
    for shape, size in zip(
        take.scene_meshes.vehicles.shapes, take.scene_meshes.vehicles.size, strict=True
    ):
        np.testing.assert_allclose(np.ptp(shape.vertices, axis=0), size, atol=1e-9)
