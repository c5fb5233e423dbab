"""What of the truth a KITTI label file says."""

import numpy as np

from mot_sim.simulation.truth import labels
from tests.mot_sim.simulation.truth.states import state_of, truth_of


def test_small_and_far_cars_are_dont_care_and_the_others_keep_their_rows() -> None:
    truth = truth_of(state_of((20.0, 0.0, 0.0), (75.0, 8.0, 0.0), (95.0, -6.0, 0.0)))
    labelled = labels(truth)
    assert labelled.kinds is not None
    assert labelled.kinds.tolist() == ["Car", "DontCare", "DontCare"]
    assert labelled.ids.tolist() == [0, -1, -1]
    assert labelled.cuboids is not None
    assert np.isnan(labelled.cuboids.base[1:]).all()
    assert np.isfinite(labelled.cuboids.base[0]).all()
    assert labelled.occlusion is not None
    assert labelled.occlusion.tolist() == [0, -1, -1]


def test_a_far_car_that_nobody_sees_has_no_label() -> None:
    truth = truth_of(state_of((12.0, 0.0, np.pi / 2), (90.0, 0.0, 0.0), size=(4.4, 1.9, 1.8)))
    assert truth.pixels[1] == 0
    assert labels(truth).ids.tolist() == [0]


def test_a_near_car_that_nobody_sees_keeps_its_id() -> None:
    truth = truth_of(state_of((12.0, 0.0, np.pi / 2), (30.0, 0.0, 0.0), size=(4.4, 1.9, 1.8)))
    assert truth.pixels[1] == 0
    labelled = labels(truth)
    assert labelled.ids.tolist() == [0, 1]
    assert labelled.occlusion is not None
    assert labelled.occlusion.tolist() == [0, 3]


def test_no_truth_has_no_labels() -> None:
    assert len(labels(truth_of(state_of()))) == 0
