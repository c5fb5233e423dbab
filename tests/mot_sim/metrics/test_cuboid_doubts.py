"""Mistakes that scores alone do not tell: another frame, the centre for the bottom, h w l."""

import numpy as np
import pytest

from mot_sim.metrics.cuboid_doubts import doubts_of_cuboids
from mot_sim.metrics.cuboid_errors import CuboidErrors, cuboid_errors
from tests.mot_sim.metrics.cuboid_cases import scene, two_cars
from tracker.types import Cuboids, Tracks

FRAMES = 12


def errors_with(frames: int = FRAMES, **columns: object) -> CuboidErrors:
    """The labels' own cuboids, with some of their columns changed by functions."""
    truth = scene(two_cars(frames))
    cuboids = truth.cuboids
    assert cuboids is not None
    changed = {name: change(getattr(cuboids, name)) for name, change in columns.items()}  # type: ignore[operator]
    return cuboid_errors(truth, truth.replaced(cuboids=cuboids.replaced(**changed)), frames)


def test_sound_cuboids_raise_no_doubt() -> None:
    assert doubts_of_cuboids(errors_with()) == []
    assert doubts_of_cuboids(errors_with(base=lambda base: base + [0.0, 0.2, 3.0])) == []


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ({"base": lambda base: base[:, [2, 0, 1]]}, "x right, y down, z forward"),
        ({"base": lambda base: base - [0.0, 0.75, 0.0]}, "bottom face, not of the centre"),
        ({"size": lambda size: size[:, [1, 0, 2]]}, "columns are h w l"),
    ],
)
def test_a_likely_mistake_is_named(columns: dict, told: str) -> None:
    (doubt,) = doubts_of_cuboids(errors_with(**columns))
    assert told in doubt


def test_places_that_are_all_unknown_are_named() -> None:
    errors = errors_with()
    (doubt,) = doubts_of_cuboids(errors.replaced(centre=errors.centre * np.nan))
    assert "says where its car stands" in doubt


def test_of_a_few_rows_nothing_is_said() -> None:
    assert doubts_of_cuboids(errors_with(2, base=lambda base: base + 99.0)) == []
    nothing = cuboid_errors(Tracks.empty().replaced(cuboids=Cuboids.empty()), Tracks.empty(), 1)
    assert doubts_of_cuboids(nothing) == []
