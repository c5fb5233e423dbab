"""2D-2D: the overlap of the expected box with the new one."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tracker.samples import beliefs_at, pairing_of
from tracker.costs import ImageOverlap


def cost_of(expected: list[float], observed: list[float], buffer: float = 0.0) -> np.ndarray:
    """The cost of two boxes; the region is wide enough for every pair to be compared."""
    before, now = beliefs_at((0.0, 20.0), std=8.0), beliefs_at((0.0, 20.0))
    before.boxes[0], now.boxes[0] = expected, observed
    return ImageOverlap(buffer)(pairing_of(before, now))


def test_half_overlapping_boxes_cost_two_thirds() -> None:
    assert cost_of([600, 200, 640, 240], [620, 200, 660, 240]) == pytest.approx([2 / 3])


def test_the_expected_box_itself_costs_nothing() -> None:
    assert cost_of([600, 200, 640, 240], [600, 200, 640, 240]) == pytest.approx([0.0])


def test_boxes_that_only_touch_cost_everything_but_less_with_a_buffer() -> None:
    touching = ([600.0, 200, 610, 210], [610.0, 200, 620, 210])
    assert cost_of(*touching) == pytest.approx([1.0])
    # 20 x 20 boxes that share 10 x 20: 200 / 600.
    assert cost_of(*touching, buffer=0.5) == pytest.approx([2 / 3])


def test_the_buffer_grows_with_the_time_since_the_last_look() -> None:
    before, now = beliefs_at((0.0, 20.0), std=8.0), beliefs_at((0.0, 20.0))
    before.boxes[0], now.boxes[0] = [600.0, 200, 610, 210], [610.0, 200, 620, 210]
    cost = ImageOverlap(0.1, drift=1.0)
    costs = [cost(replace(pairing_of(before, now), seconds=seconds))[0] for seconds in (0.1, 0.5)]
    assert costs[0] == pytest.approx(ImageOverlap(0.1)(pairing_of(before, now))[0])
    assert costs[1] == pytest.approx(2 / 3)  # 20 x 20 boxes that share 10 x 20
