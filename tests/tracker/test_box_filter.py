"""The filter of boxes learns how noisy they are."""

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, beliefs_at
from tracker.box_filter import BoxFilter, Gains
from tracker.lifecycle import ActiveTracks

DT = 0.1


def tracks(boxes: np.ndarray, innovations: np.ndarray | None = None, hits: int = 99):
    """Tracks that are expected in these boxes, last seen one frame ago."""
    n = len(boxes)
    beliefs = beliefs_at(*[(2.0 * i, 20.0) for i in range(n)])
    beliefs.boxes[:] = boxes
    off = np.full((n, 4), np.nan) if innovations is None else innovations
    ones, seen = np.ones(n), np.full(n, hits)
    return ActiveTracks(np.arange(n), beliefs, DT * ones, seen, ones, off, np.nan * ones)


def run(noise: float, walk: float, frames: int = 400, n: int = 6) -> tuple[Gains, float, float]:
    """Boxes that walk at random and are measured with noise; gains, and rms raw and filtered."""
    rng = np.random.default_rng(3)
    truth = np.tile([400.0, 150.0, 500.0, 230.0], (n, 1))
    shift = np.array([1.0, 1.0, 1.0, 1.0])
    box_filter, learned = BoxFilter(), BoxFilter().start()
    expected, before, raw, filtered = truth.copy(), None, [], []
    for frame in range(frames):
        truth = truth + walk * rng.normal(size=(n, 1)) * shift
        seen = truth + noise * rng.normal(size=(n, 1)) * shift
        expected, before, learned = box_filter(
            learned, tracks(expected, before, frame + 1), seen, DT, LEVEL
        )
        if frame > frames // 2:
            raw.append(seen - truth)
            filtered.append(expected - truth)
    return learned, float(np.std(raw)), float(np.std(filtered))


def test_with_noisy_boxes_the_gain_falls_and_the_boxes_become_better() -> None:
    learned, raw, filtered = run(noise=4.0, walk=1.0)
    assert learned.gains[2, 0] < 0.4  # the optimum of this walk and noise is .22
    assert filtered < 0.65 * raw


def test_with_exact_boxes_the_gain_rises_to_the_new_box() -> None:
    learned, _, _ = run(noise=0.0, walk=2.0)
    assert learned.gains[2, 0] > 0.95


def test_sizes_without_a_car_keep_the_gain_to_start_from() -> None:
    learned, _, _ = run(noise=4.0, walk=1.0, frames=50)
    np.testing.assert_array_equal(learned.gains[:2], 0.8)
    np.testing.assert_array_equal(learned.pairs[:2], 0.0)


def test_the_filtered_box_lies_between_expected_and_new() -> None:
    expected = np.array([[400.0, 150.0, 500.0, 230.0]])
    new = expected + 10.0
    boxes, innovations, _ = BoxFilter()(BoxFilter().start(), tracks(expected), new, DT, LEVEL)
    np.testing.assert_allclose(boxes, expected + 8.0)
    np.testing.assert_allclose(innovations, [[10.0 / 80.0, 10.0 / 80.0, 0.0, 0.0]], atol=1e-12)


def test_after_a_gap_the_new_box_is_believed_more() -> None:
    expected = np.array([[400.0, 150.0, 500.0, 230.0]])
    waiting = tracks(expected)
    waiting.time_since_update[:] = 3 * DT
    boxes, innovations, _ = BoxFilter()(BoxFilter().start(), waiting, expected + 10.0, DT, LEVEL)
    np.testing.assert_allclose(boxes, expected + 10.0 * (1.0 - 0.2**3))
    assert np.isnan(innovations).all()


@pytest.mark.parametrize("new", [[0.0, 150, 90, 230], [1150.0, 150, 1241, 230]])
def test_a_box_cut_by_the_border_is_taken_as_it_is(new) -> None:
    expected, seen = np.array([new]) + 7.0, np.array([new])
    boxes, innovations, _ = BoxFilter()(BoxFilter().start(), tracks(expected), seen, DT, LEVEL)
    np.testing.assert_allclose(boxes, seen)
    assert np.isnan(innovations).all()


def test_nobody_and_no_time_are_no_error() -> None:
    start = BoxFilter().start()
    none = np.zeros((0, 4))
    assert BoxFilter()(start, ActiveTracks.empty(), none, DT, LEVEL).boxes.shape == (0, 4)
    box = np.array([[400.0, 150.0, 500.0, 230.0]])
    assert np.isfinite(BoxFilter()(start, tracks(box), box, 0.0, LEVEL).boxes).all()
