"""PCK, confidences, the wanted maps, the plan."""

import numpy as np
import pytest

from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.augment import AugmentedCrops, exact_crops
from mot_sim.training.curve import curve_picture
from mot_sim.training.loss import target_maps
from mot_sim.training.plan import TrainingPlan
from mot_sim.training.scores import score_keypoints
from tests.mot_sim.training.made_up import made_up
from tracker.errors import BadConfig, UnknownName
from tracker.shape import decode

VISIBLE, HIDDEN = int(KeypointVisibility.VISIBLE), int(KeypointVisibility.SELF_OCCLUDED)


def test_a_keypoint_is_right_within_a_tenth_of_the_longer_side() -> None:
    true = np.zeros((1, 4, 2))
    found = np.array([[(0.0, 0.0, 1.0), (9.9, 0.0, 1.0), (8.0, 8.0, 1.0), (0.0, 0.0, 1.0)]])
    states = np.array([[VISIBLE, VISIBLE, VISIBLE, HIDDEN]], np.uint8)
    judged = score_keypoints(found, true, states, np.array([100.0]))
    assert judged.right.tolist() == [[True, True, False, False]]
    assert judged.pck == pytest.approx(2 / 3)


def test_confidences_that_are_the_truth_are_no_doubt() -> None:
    rng = np.random.default_rng(0)
    confidence = rng.uniform(size=(4000, 5))
    seen = rng.uniform(size=confidence.shape) < confidence
    found = np.dstack((np.zeros((4000, 5, 2)), confidence))
    states = np.where(seen, VISIBLE, HIDDEN).astype(np.uint8)
    judged = score_keypoints(found, np.zeros((4000, 5, 2)), states, np.ones(4000))
    assert judged.doubt < 0.02
    assert judged.claimed[:, 2].sum() == 20_000
    boasting = score_keypoints(
        found + (0.0, 0.0, 0.3), np.zeros((4000, 5, 2)), states, np.ones(4000)
    )
    assert boasting.doubt > 0.2


def test_nobody_is_judged_without_keypoints() -> None:
    nothing = score_keypoints(np.zeros((0, 36, 3)), np.zeros((0, 36, 2)), np.zeros((0, 36), np.uint8),
                    np.zeros(0))  # fmt: skip
    assert np.isnan(nothing.pck)
    assert nothing.doubt == 0.0


def test_wanted_maps_decode_to_the_keypoints_they_were_made_from() -> None:
    shown = exact_crops(made_up(4))
    chances, seen = target_maps(shown, 16)
    assert chances.sum(axis=2) == pytest.approx(1.0)
    assert (chances[~seen][:, -1] == 1.0).all()
    odds = np.log(np.maximum(chances[:, :, :-1], 1e-12)) - np.log(
        np.maximum(chances[:, :, -1:], 1e-3)
    )
    found = decode(odds.reshape(4, 36, 16, 16).astype(np.float32))
    off = np.hypot(*(found[:, :, :2] - shown.keypoints)[seen].T)
    assert off.max() < 0.15 / 16  # of the crop: a seventh of a cell
    assert found[seen][:, 2].min() > 0.9
    assert found[~seen][:, 2].max() < 0.01


def test_a_keypoint_outside_the_crop_is_wanted_nowhere() -> None:
    shown = AugmentedCrops(
        np.zeros((1, 64, 64, 3), np.uint8), np.full((1, 36, 2), np.nan),
        np.full((1, 36), KeypointVisibility.TRUNCATED, np.uint8),
    )  # fmt: skip
    chances, seen = target_maps(shown, 16)
    assert not seen.any()
    assert (chances[0, :, -1] == 1.0).all()
    assert np.isfinite(chances).all()


@pytest.mark.parametrize(
    ("knobs", "told"),
    [
        ({"crops": 0}, "nothing to train with"),
        ({"epochs": 0}, "nothing to train with"),
        ({"crops": 10}, "do not fill a batch of 64"),
        ({"batch": 7}, "even number"),
        ({"rate": 2.0}, "rate 2"),
    ],
)
def test_a_plan_that_cannot_be_is_refused(knobs: dict[str, float], told: str) -> None:
    with pytest.raises(BadConfig) as caught:
        TrainingPlan(**knobs)  # type: ignore[arg-type]
    assert told in str(caught.value)


def test_a_size_that_nobody_knows_is_refused() -> None:
    with pytest.raises(UnknownName, match="shipped, small"):
        TrainingPlan(size="shiped")


def test_a_plan_counts_its_steps() -> None:
    plan = TrainingPlan(crops=100, epochs=3, batch=64)
    assert (plan.steps_an_epoch, plan.steps) == (3, 9)


def test_a_curve_is_drawn_a_panel_a_column() -> None:
    rows = [{"epoch": float(i), "loss": 2.0 / (i + 1), "pck": 0.1 * i} for i in range(4)]
    picture = curve_picture(rows)
    assert picture.shape[1] == 2 * curve_picture([{"epoch": 1.0, "loss": 1.0}]).shape[1]
    assert (picture != 255).any()
