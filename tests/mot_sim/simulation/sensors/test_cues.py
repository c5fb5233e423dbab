"""Yaw, size, keypoints, shape, descriptors."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.cues import AppearanceNoise, Keypoints, Pose, Shape
from tests.mot_sim.simulation.sensors.sights import STEP, by_object, crowd, lag_one
from tracker.errors import BadConfig

SLOW = Autocorrelation((1.0,), (1.0,))


def test_yaw_is_off_with_memory_and_some_cars_stand_the_wrong_way_round() -> None:
    sightings = crowd(500, 60)
    yaw, size = Pose(0.1, flips=0.1, size=0.05, autocorrelation=SLOW, flip_autocorrelation=SLOW)(
        sightings, 1, STEP
    )
    turned = np.abs(yaw - 0.3) > 1.5
    assert turned.mean() == pytest.approx(0.1, abs=0.02)
    assert (yaw - 0.3)[~turned].std() == pytest.approx(0.1, rel=0.05)
    assert lag_one(by_object(turned.astype(float), 500)) > 0.6
    assert np.log(size / [4.0, 1.5, 1.8]).std() == pytest.approx(0.05, rel=0.05)
    exact = Pose(0.1, flips=0.1, size=0.05)(sightings, 1, STEP, 0.0)
    assert (exact[0] == 0.3).all()
    assert (exact[1] == [4.0, 1.5, 1.8]).all()


def test_keypoints_are_off_by_their_state_missed_and_swapped() -> None:
    plain = crowd(300, 20)
    points = np.tile(np.arange(36.0)[:, None] * [2.0, 1.0], (len(plain), 1, 1))
    states = np.tile(np.repeat([0, 1, 2, 3], 9).astype(np.uint8), (len(plain), 1))
    sightings = replace(plain, keypoints=points, keypoint_states=states)
    noise = Keypoints((0.01, 0.02, 0.04, 0.08), (0.0, 0.1, 0.2, 0.5), autocorrelation=SLOW)
    seen = noise(sightings, 1, STEP)
    assert seen is not None
    off = (seen[..., :2] - points) / 120.0
    for state, spread, missing in ((0, 0.01, 0.0), (1, 0.02, 0.1), (3, 0.08, 0.5)):
        assert np.nanstd(off[states == state]) == pytest.approx(spread, rel=0.05)
        lost = np.isnan(off[states == state]).mean()
        assert lost == pytest.approx(missing, abs=0.02)
    swapped = Keypoints(flips=1.0)(sightings, 1, STEP)
    assert swapped is not None
    assert (swapped[:, :18, :2] == points[:, 18:]).all()
    exact = noise(sightings, 1, STEP, 0.0)
    assert exact is not None
    assert (exact[..., :2] == points).all()
    assert noise(plain, 1, STEP) is None


def test_shape_is_worse_far_away_and_nearer_to_the_mean_when_hidden() -> None:
    coefficients = np.ones((4000, 3))
    near, far = (replace(crowd(200, 20, depth=z), shape=coefficients) for z in (10.0, 40.0))
    noise = Shape(0.1, 1.0, 0.5)
    spreads = [np.std(noise(each, 1, STEP)) for each in (near, far)]
    np.testing.assert_allclose(spreads, [0.1, 0.4], rtol=0.05)
    hidden = replace(crowd(200, 20, visible=0.2), shape=coefficients)
    assert np.mean(noise(hidden, 1, STEP)) == pytest.approx(0.6, abs=0.02)
    assert noise(near, 1, STEP, 0.0) is near.shape
    assert noise(crowd(), 1, STEP) is None
    timid = Shape(pull=0.75, stated=0.2)
    np.testing.assert_allclose(timid(near, 1, STEP), 0.25)
    np.testing.assert_allclose(timid(near, 1, STEP, 0.5), 0.625)
    np.testing.assert_allclose(timid.stated_std(near, 0.5), 0.1)
    np.testing.assert_allclose(noise.stated_std(far), noise.std(far))


def test_a_car_keeps_its_look_and_look_alikes_share_theirs() -> None:
    sightings = crowd(100, 3)
    exact = AppearanceNoise(32)(sightings, 1, STEP)
    np.testing.assert_allclose(np.linalg.norm(exact, axis=1), 1.0)
    assert (exact[:100] == exact[200:]).all()
    assert np.abs(exact[:50] @ exact[50:100].T).mean() < 0.3
    pairs = AppearanceNoise(32, alike=2)(sightings, 1, STEP)
    assert (pairs[0:100:2] == pairs[1:100:2]).all()
    noisy = AppearanceNoise(32, noise=0.5, view=0.3, autocorrelation=SLOW)(sightings, 1, STEP)
    same = (noisy[:100] * noisy[200:]).sum(axis=1).mean()
    assert np.abs(noisy[:50] @ noisy[50:100].T).mean() + 0.3 < same < 1.0
    assert (AppearanceNoise(32, noise=0.5, view=0.3)(sightings, 1, STEP, 0.0) == exact).all()
    np.testing.assert_allclose(AppearanceNoise(32, unit=0.5)(sightings, 1, STEP), 2.0 * exact)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Pose(-0.1),
        lambda: Pose(flips=2.0),
        lambda: Keypoints((0.1,)),
        lambda: Keypoints(flips=-1.0),
        lambda: Shape(-1.0),
        lambda: Shape(pull=1.5),
        lambda: Shape(stated=-0.1),
        lambda: AppearanceNoise(0),
        lambda: AppearanceNoise(unit=0.0),
    ],
)
def test_what_no_sensor_does_is_refused(make) -> None:
    with pytest.raises(BadConfig):
        make()
