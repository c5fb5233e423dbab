"""Measured yaws and sizes in the car filter: against filterpy's, and front taken for rear."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from tests.tracker.samples import LEVEL, outlines
from tracker import Frame, Tracker
from tracker.car_filter import CarCues, CarStates, CueModel
from tracker.errors import BadConfig
from tracker.types import Cuboids, Detections

STATE = np.array([1.0, 0.0, 20.0, 0.3, 6.0, *np.log([4.0, 1.5, 1.7]), 0.1])
SEEN = np.zeros(1, bool)


def cues_of(yaw: float = np.nan, size: tuple[float, ...] = (np.nan,) * 3) -> CarCues:
    found = CarCues.of(Detections.of([[0, 0, 9, 9]], yaw=np.array([yaw]), size=np.array([size])))
    assert found is not None
    return found


def read(
    model: CueModel,
    means: np.ndarray,
    covs: np.ndarray,
    cues: CarCues,
    hidden: np.ndarray,
    is_first: bool,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What the model makes of cars of one hypothesis each."""
    states = CarStates(means[:, None], covs[:, None], np.zeros((len(means), 1)))
    after, told = model(states, cues, hidden, is_first)
    return after.means[:, 0], after.covs[:, 0], told[:, 0]


def test_sizes_are_measurements_of_a_linear_filter() -> None:
    model, rng = CueModel(), np.random.default_rng(3)
    root = rng.normal(size=(9, 9)) * 0.2
    kalman = KalmanFilter(dim_x=9, dim_z=3)
    kalman.x, kalman.P = STATE.copy(), root @ root.T + 0.01 * np.eye(9)
    size = (4.4, 1.6, 1.8)
    means, covs, fit = read(model, STATE[None], kalman.P[None], cues_of(size=size), SEEN, False)
    kalman.update(
        np.log(size), R=model.repetition * np.diag(np.square(model.size_std)), H=np.eye(9)[5:8]
    )
    np.testing.assert_allclose(means[0], kalman.x, atol=1e-12)
    np.testing.assert_allclose(covs[0], kalman.P, atol=1e-12)
    assert fit[0] == 0.0


def test_a_yaw_that_surely_tells_something_is_a_measurement_of_a_linear_filter() -> None:
    model = CueModel(wrong_share=1e-9)
    kalman = KalmanFilter(dim_x=9, dim_z=1)
    kalman.x, kalman.P = STATE.copy(), 0.04 * np.eye(9)
    kalman.P[0, 3] = kalman.P[3, 0] = 0.01
    covs = kalman.P.copy()[None]
    kalman.update(0.4, R=model.yaw_std**2 + model.yaw_floor**2, H=np.eye(9)[3:4])
    for yaw in (0.4, 0.4 - np.pi):  # front for rear: the hypothesis stays in its own direction
        means, after, _ = read(model, STATE[None], covs, cues_of(yaw), SEEN, True)
        np.testing.assert_allclose(means[0], kalman.x, atol=1e-6)
        np.testing.assert_allclose(after[0], kalman.P, atol=1e-6)


def test_a_direction_is_as_much_likelier_as_front_is_taken_for_front() -> None:
    model = CueModel(wrong_share=1e-9, turned_share=0.1, hidden_turned_share=0.4)
    means, covs = np.tile(STATE, (2, 1)), np.tile(0.01 * np.eye(9), (2, 1, 1))
    means[1, 3] -= np.pi
    for hidden, odds in ((False, 9.0), (True, 1.5)):
        cues = cues_of(0.3).select(np.zeros(2, np.int64))
        for is_first, power in ((True, 1.0), (False, model.evidence)):
            *_, fit = read(model, means, covs, cues, np.full(2, hidden), is_first)
            assert np.exp(fit[0] - fit[1]) == pytest.approx(odds**power, rel=1e-6)


def test_a_yaw_that_fits_no_way_at_all_changes_little() -> None:
    means, covs = STATE[None], 0.001 * np.eye(9)[None]
    after, cov, _ = read(CueModel(), means, covs, cues_of(0.3 + np.pi / 2), SEEN, True)
    np.testing.assert_allclose(after, means, atol=1e-4)
    np.testing.assert_allclose(cov, covs, atol=1e-4)


@pytest.mark.unchecked  # many frames of one shape
def test_a_parked_car_faces_us_once_its_yaw_says_so() -> None:
    """By its side of the road it would face our way."""
    car = Cuboids(np.array([[3.5, 0.0, 15.0]]), np.array([np.pi / 2]), np.array([[4.4, 1.6, 1.8]]))
    box, headings = outlines(car, LEVEL), []
    for cues in ({}, {"yaw": car.yaw, "size": car.size}, {"yaw": np.array([np.nan])}):
        tracker = Tracker.default(LEVEL)
        for index in range(4):
            found = Detections.of(box, **cues)
            rows = tracker.step(Frame(index, 0.1 * index, found, np.eye(4)))
        assert rows.cuboids is not None
        headings.append(rows.cuboids.yaw[0])
        if "size" in cues:
            np.testing.assert_allclose(rows.cuboids.size, car.size, rtol=0.06)
    assert headings[1] == pytest.approx(np.pi / 2, abs=0.1)
    assert np.cos(headings[0] + np.pi / 2) > 0.7
    assert headings[2] == headings[0]


@pytest.mark.parametrize(
    "settings", [{"turned_share": 0.6}, {"hidden_turned_share": -0.1}, {"wrong_share": 0.0}]
)
def test_shares_that_are_none_are_refused(settings: dict[str, float]) -> None:
    with pytest.raises(BadConfig, match=next(iter(settings))):
        CueModel(**settings)
