"""A prior made ready for fitting: visibility, size, metres on the road."""

import numpy as np
import pytest

from mot_sim.simulation.cars import load_fleet
from tests.tracker.shape.drawn import MODEL
from tracker.errors import BadConfig
from tracker.shape import KEYPOINTS_14, CarModel, ShapeBasis, load_prior, metric
from tracker.shape.model import DIRECTION_BINS, MEAN_SIZE

NAMES = MODEL.basis.points


def seen_from(degrees: float) -> dict[str, float]:
    """The visible share of each point, from a direction counted from ahead towards the right."""
    row = MODEL.visibility[int(degrees / 360.0 * DIRECTION_BINS)]
    return dict(zip(NAMES, row.tolist(), strict=True))


def test_from_the_right_all_right_points_are_seen_and_no_left_one() -> None:
    for name, share in seen_from(90.0).items():
        assert (share > 0.9) if name.startswith("right") else (share < 0.1)


def test_from_behind_both_taillights_are_seen_and_neither_headlight_nor_wheel() -> None:
    seen = seen_from(180.0)
    for side in ("left", "right"):
        assert seen[f"{side}_taillight"] > 0.9
        assert seen[f"{side}_headlight"] < 0.2
        assert seen[f"{side}_front_wheel"] < 0.2


def test_visibility_is_mirrored_with_the_car() -> None:
    mirrored = [
        NAMES.index(
            name.replace("left", "RIGHT").replace("right", "left").replace("RIGHT", "right")
        )
        for name in NAMES
    ]
    np.testing.assert_allclose(MODEL.visibility[::-1][:, mirrored], MODEL.visibility, atol=1e-9)


def test_sizes_are_those_of_the_fleet_within_centimetres() -> None:
    fleet = load_fleet(5)
    shape = fleet.sample(1, np.arange(100)).coefficients
    off = MODEL.size(shape, np.ones(100)) - fleet.size(shape)
    assert (np.abs(off) < [0.2, 0.03, 0.03]).all()
    np.testing.assert_allclose(fleet.size(np.zeros((1, 5)))[0], MEAN_SIZE, atol=1e-3)


def test_a_centred_prior_in_another_scale_comes_back_to_metres_on_the_road() -> None:
    ours = load_prior(points=KEYPOINTS_14).first(3)
    theirs = ShapeBasis(
        ours.points, 0.2 * (ours.mean - ours.mean.mean(axis=0)), 0.2 * ours.vectors, None
    )
    found = metric(theirs)
    np.testing.assert_allclose(found.mean, ours.mean, atol=1e-9)
    np.testing.assert_allclose(found.vectors, ours.vectors, atol=1e-9)
    assert found.std is not None
    assert ours.std is not None
    # The shipped cars vary in twenty ways: at least by these three.
    assert (found.std > 0.99 * ours.std).all()
    CarModel(found)


def test_known_deviations_are_kept() -> None:
    ours = load_prior().first(3)
    np.testing.assert_array_equal(metric(ours).std, ours.std)


def test_priors_that_cannot_be_fitted_are_refused() -> None:
    basis = load_prior().first(2)
    centred = ShapeBasis(basis.points, basis.mean + (0.0, 9.0, 0.0), basis.vectors, basis.std)
    for bad in (
        centred,
        basis.scaled(0.2),
        ShapeBasis(basis.points, basis.mean, basis.vectors, None),
        ShapeBasis(basis.points, basis.mean, basis.vectors, np.zeros(2)),
    ):
        with pytest.raises(BadConfig, match=r"metric"):
            CarModel(bad)
    with pytest.raises(BadConfig, match="scale_std"):
        CarModel(basis, scale_std=1.0)
    strange = ShapeBasis(("a", "b"), basis.mean[:2], basis.vectors[:, :2], basis.std)
    with pytest.raises(BadConfig, match="0 of the prior's points"):
        metric(strange)


def test_a_prior_of_unknown_points_has_no_margin() -> None:
    basis = load_prior().first(2)
    renamed = ShapeBasis(tuple(f"p{i}" for i in range(36)), basis.mean, basis.vectors, basis.std)
    np.testing.assert_array_equal(CarModel(renamed).margin, np.zeros(3))
