"""Ghosts and scores."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logit

from mot_sim.simulation.sensors.clutter import Clutter
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.scores import ScoreNoise
from tests.mot_sim.simulation.sensors.sights import (
    CAMERA,
    STEP,
    by_object,
    crowd,
    lag_one,
    sightings_of,
)
from tracker.errors import BadConfig

GHOSTS = Clutter(0.5, Autocorrelation((0.5, 0.5), (0.0, 0.5)))
EVERY = np.arange(4000)
LINEAR = ScoreNoise((-8.0, 8.0), (-8.0, 8.0), autocorrelation=Autocorrelation((1.0,), (1.0,)))


def test_ghosts_come_at_their_rate_at_any_frame_rate() -> None:
    for step in (0.1, 0.05):
        false_alarms = GHOSTS(EVERY, 1, CAMERA, step)
        counts = np.bincount(false_alarms.frames, minlength=len(EVERY))
        assert counts.mean() == pytest.approx(0.5, abs=0.06)
        assert counts[:200].mean() == pytest.approx(0.5, abs=0.25)  # from the first frame on


def test_half_of_the_ghosts_live_for_half_a_second() -> None:
    for step in (0.1, 0.05):
        false_alarms = GHOSTS(EVERY, 1, CAMERA, step)
        now = set(zip(false_alarms.ids.tolist(), false_alarms.frames.tolist(), strict=True))
        lag = round(0.5 / step)
        stay = np.mean([(i, f + lag) in now for i, f in now])
        assert stay == pytest.approx(0.5 * np.exp(-1.0), abs=0.03)


def test_some_frames_have_the_ghosts_of_all_frames() -> None:
    whole, some = GHOSTS(EVERY, 1, CAMERA, STEP), GHOSTS(np.array([70, 71, 90]), 1, CAMERA, STEP)
    same = whole.select(np.isin(whole.frames, [70, 71, 90]))
    assert same.ids.tolist() == some.ids.tolist()
    assert (same.boxes == some.boxes).all()
    assert (same.scores == some.scores).all()


def test_ghosts_stand_on_the_road_and_in_the_image() -> None:
    false_alarms = GHOSTS(EVERY, 1, CAMERA, STEP)
    tall = false_alarms.boxes[:, 3] - false_alarms.boxes[:, 1]
    assert (false_alarms.boxes >= 0.0).all()
    assert (false_alarms.boxes <= CAMERA.far_corner).all()
    assert np.corrcoef(tall, false_alarms.boxes[:, 3])[0, 1] > 0.9  # larger ones are nearer: lower


def test_level_0_and_no_frames_have_no_ghosts() -> None:
    assert not len(GHOSTS(EVERY, 1, CAMERA, STEP, 0.0))
    assert not len(GHOSTS(EVERY[:0], 1, CAMERA, STEP))


def test_scores_flicker_with_their_memory_and_keep_their_distribution() -> None:
    sightings = crowd(500, 80)
    scores = LINEAR(sightings, np.zeros(len(sightings)), 1, STEP)
    odds = by_object(logit(scores), 500)
    assert odds.std() == pytest.approx(1.0, abs=0.03)
    assert lag_one(odds) == pytest.approx(np.exp(-0.1), abs=0.02)


def test_hidden_and_nearly_missed_cars_have_low_scores() -> None:
    shy = ScoreNoise((-8.0, 8.0), (-8.0, 8.0), (-3.0, -2.0, -1.0, 0.0), coupling=0.6)
    open_cars, hidden = crowd(visible=0.95), crowd(visible=0.35)
    ease = np.linspace(-2.0, 2.0, len(open_cars))
    scores = shy(open_cars, ease, 1, STEP)
    assert np.median(shy(hidden, ease, 1, STEP)) < np.median(scores)
    assert np.corrcoef(logit(scores), ease)[0, 1] > 0.5


def test_level_0_is_sure_and_higher_levels_doubt_more() -> None:
    sightings = crowd(50, 20)
    ease = np.zeros(len(sightings))
    assert (LINEAR(sightings, ease, 1, STEP, 0.0) == 1.0).all()
    half, full, more = (LINEAR(sightings, ease, 1, STEP, level) for level in (0.5, 1.0, 2.0))
    np.testing.assert_allclose(1.0 - half, 0.5 * (1.0 - full))
    assert (more <= full).all()
    assert (more >= 0.0).all()


@pytest.mark.parametrize(
    "make",
    [
        lambda: Clutter(-0.1),
        lambda: Clutter(100.0),
        lambda: ScoreNoise((0.0, 1.0), (1.0, 0.0)),
        lambda: ScoreNoise((0.0, 1.0), (0.0, 1.0), coupling=2.0),
    ],
)
def test_what_no_detector_does_is_refused(make) -> None:
    with pytest.raises(BadConfig):
        make()


def test_trucks_cut_cars_and_cars_beside_their_labels_have_lower_scores() -> None:
    less = ScoreNoise(
        (-8.0, 8.0), (-8.0, 8.0), by_truncation=(0.0, -1.0, -2.0),
        truncation_by_height=(0.0, 0.0, 1.0), other_kinds=-3.0, unlabelled=(-1.0, -2.0, -3.0),
    )  # fmt: skip

    def mean(**more) -> float:
        return float(less.mean(sightings_of([0], [0], height=100.0, **more))[0])

    assert mean() == 0.0
    assert mean(kind="Van") == -3.0
    assert mean(cut=0.2) == -1.0
    assert float(less.mean(sightings_of([0], [0], height=200.0, cut=0.6))[0]) == pytest.approx(
        -2.0 + np.log(2.0)
    )
    rows = replace(sightings_of([0, 1, 2, 3], [0, 0, 0, 0]), unlabelled=np.arange(4))
    assert less.mean(rows).tolist() == [0.0, -1.0, -2.0, -3.0]
    with pytest.raises(BadConfig, match="give 3"):
        replace(less, unlabelled=(0.0,))
