"""Each effect alone: exact at level 0, of the promised size at level 1."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.sensors import confidence, jitter_boxes, miss_probability, missed
from mot_sim.sensors.jitter import EDGE_STD, MAX_STD

COUNT = 5000
IDS, FRAMES = np.arange(COUNT) % 50, np.arange(COUNT) // 50
BOXES = np.tile([100.0, 50.0, 300.0, 150.0], (COUNT, 1))
VISIBLE = np.linspace(0.0, 1.0, COUNT)


def test_level_0_is_exact() -> None:
    assert (jitter_boxes(BOXES, 1, IDS, FRAMES, 0.0) == BOXES).all()
    assert not missed(VISIBLE, 1, IDS, FRAMES, 0.0).any()
    assert (confidence(VISIBLE, 1, IDS, FRAMES, 0.0) == 1.0).all()


def test_edges_are_off_by_their_part_of_the_side() -> None:
    errors = jitter_boxes(BOXES, 1, IDS, FRAMES) - BOXES
    np.testing.assert_allclose(errors.std(axis=0), EDGE_STD * np.array([200, 100] * 2), rtol=0.05)
    assert np.abs(errors.mean(axis=0)).max() < 0.3
    assert np.abs(np.corrcoef(errors.T) - np.eye(4)).max() < 0.06


@given(st.floats(0, 5), st.floats(0.1, 500), st.floats(0.1, 300))
def test_boxes_never_turn_inside_out(level, width, height) -> None:
    if level * EDGE_STD * MAX_STD < 0.5:
        boxes = np.tile([0.0, 0.0, width, height], (50, 1))
        noisy = jitter_boxes(boxes, 2, np.arange(50), np.zeros(50, np.int64), level)
        assert (noisy[:, 2:] > noisy[:, :2]).all()


def test_misses_follow_their_probability_and_rise_with_occlusion() -> None:
    assert miss_probability(np.array([1.0, 0.5, 0.0])).tolist() == [0.01, 0.135, 1.0]
    unseen = missed(VISIBLE, 1, IDS, FRAMES)
    for part in np.array_split(np.arange(COUNT), 5):
        expected = miss_probability(VISIBLE[part]).mean()
        assert abs(unseen[part].mean() - expected) < 4 * np.sqrt(0.25 / len(part))


@given(st.floats(0, 1), st.floats(0, 1))
def test_a_higher_level_misses_the_same_cars_and_more(a, b) -> None:
    few, many = (missed(VISIBLE, 1, IDS, FRAMES, level) for level in sorted((a, b)))
    assert (many | ~few).all()


def test_hidden_cars_have_lower_scores() -> None:
    scores = confidence(VISIBLE, 1, IDS, FRAMES)
    assert ((scores >= 0.0) & (scores <= 1.0)).all()
    assert np.median(scores[VISIBLE > 0.9]) > 0.98
    assert 0.8 < np.median(scores[(VISIBLE > 0.2) & (VISIBLE < 0.5)]) < 0.97
    assert np.median(scores[VISIBLE < 0.1]) < np.median(scores[VISIBLE > 0.5])


def test_nobody_has_no_noise() -> None:
    none, nobody = np.zeros(0), np.zeros(0, np.int64)
    assert jitter_boxes(np.zeros((0, 4)), 0, nobody, nobody).shape == (0, 4)
    assert missed(none, 0, nobody, nobody).shape == (0,)
    assert confidence(none, 0, nobody, nobody).shape == (0,)
