"""What a camera sees of a scene."""

import numpy as np
import pytest

from mot_sim.simulation.cars import Models
from mot_sim.simulation.scene import Rollout, Scene
from mot_sim.simulation.scene_figures import LabelFigures, figures_of, figures_of_rollout
from mot_sim.simulation.traffic import Route, Script, Scripted

FRAMES = 10


def scene_of(*cars: Script, ego: Script | None = None) -> Scene:
    def traffic(models: Models) -> Scripted:
        return Scripted(cars, ego or Script(Route([(0.0, 0.0), (90.0, 0.0)]), [(0.0, 0.0)]))

    return Scene("small", traffic, FRAMES)


def parked(x: float, y: float, dx: float = 1.0, dy: float = 0.0) -> Script:
    return Script(Route([(x, y), (x + dx, y + dy)]), [(0.0, 0.0)])


def test_cars_in_sight_are_counted_by_how_they_stand() -> None:
    figures = figures_of_rollout(
        Rollout.of(scene_of(parked(15.0, 0.0), parked(20.0, 5.0, 0.0, 1.0)), 0)
    )
    assert figures.cars == 2.0
    assert figures.turned == 0.5
    assert figures.occluded == 0.0
    assert figures.ids == pytest.approx(2 / (FRAMES / 10 / 60))
    assert figures.yaw_rate == 0.0


def test_a_hidden_car_is_occluded_and_a_far_one_does_not_count() -> None:
    hidden = figures_of_rollout(
        Rollout.of(scene_of(parked(12.0, 0.0, 0.0, 1.0), parked(20.0, 1.2)), 0)
    )
    assert hidden.occluded == pytest.approx(0.5)
    far = figures_of_rollout(Rollout.of(scene_of(parked(90.0, 0.0)), 0))
    assert (far.cars, far.occluded, far.turned, far.ids) == (0.0, 0.0, 0.0, 0.0)


def test_the_fastest_turn_is_the_ego_cars() -> None:
    ego = Script(Route([(0.0, 0.0), (6.0, 0.0), (6.0, 40.0)], radius=3.0), [(0.0, 6.0)])
    figures = figures_of_rollout(Rollout.of(scene_of(ego=ego), 0))
    assert figures.yaw_rate == pytest.approx(np.degrees(2.0), rel=0.01)


def test_figures_are_means_over_seeds_and_progress_is_told_by_frame() -> None:
    told = []
    figures = figures_of(scene_of(parked(15.0, 0.0)), (0, 1), lambda: told.append(1))
    assert figures.cars == 1.0
    assert len(told) == 2 * FRAMES


def test_figures_of_labels_are_of_those_that_are_scored() -> None:
    levels = np.array([0, 2, 2, 3, 0])
    truncated = np.array([False, False, False, False, True])
    heights, pixels = np.array([40.0, 20.0, 40.0, 9.0, 9.0]), np.array([900, 300, 600, 0, 5])
    found = LabelFigures.of(levels, truncated, heights, pixels)
    assert (found.level_2, found.level_3) == (0.4, 0.2)
    assert found.low == found.low_and_hidden == pytest.approx(1 / 3)
    assert (found.pixels_1, found.pixels_50) == (306.0, 600.0)
    none = LabelFigures.of(*(each[:0] for each in (levels, truncated, heights, pixels)))
    assert (none.low, np.isnan(none.pixels_50)) == (0.0, True)
