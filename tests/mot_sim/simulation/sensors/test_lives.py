"""Cars live before and after their labels: as many as the shares say, where they would be."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.simulation.sensors import Sightings
from mot_sim.simulation.sensors.fitting.calibrate import simulate
from mot_sim.simulation.sensors.fitting.fit_lives import ALL_LIVES, fit_lives, of_lives, seen_lives
from mot_sim.simulation.sensors.fitting.measure import LabelledDetections, measure
from mot_sim.simulation.sensors.lives import LIFE_SECONDS, NONE, Lives, extrapolated, share_at
from mot_sim.simulation.sensors.profile import Profile, profile_lines, read_profile
from tests.mot_sim.simulation.sensors.sights import CAMERA
from tracker.errors import BadConfig
from tracker.types import Detections, Tracks

FIRST, LAST, FRAMES, STEP = 20, 29, 50, 0.1
SHARES = (0.8, 0.6, 0.4, 0.4, 0.4, 0.2, 0.2, 0.2, 0.0, 0.0)


def labels(cars: int = 200) -> Tracks:
    """Cars that are labelled in frames 20 to 29 and go 2 pixels to the right a frame."""
    frames, ids = np.repeat(np.arange(FIRST, LAST + 1), cars), np.tile(np.arange(cars), 10)
    left, top = 100.0 + 2.0 * frames + 90.0 * (ids % 10), 100.0 + 60.0 * (ids // 10 % 4)
    boxes = np.stack((left, top, left + 40.0, top + 40.0), axis=1)
    return Tracks(frames, ids, boxes, kinds=np.full(len(ids), "Car", "<U8"))


def test_cars_go_on_as_they_moved() -> None:
    lags, rows = extrapolated(Sightings.from_labels(labels(1)), CAMERA, FRAMES, STEP)
    assert set(lags.tolist()) == {*range(-16, 0), *range(1, 17)}
    assert (rows.frames == np.where(lags < 0, FIRST + lags, LAST + lags)).all()
    assert rows.boxes[:, 0] == pytest.approx(100.0 + 2.0 * rows.frames)
    assert (rows.boxes[:, 3] == 140.0).all()


def test_nobody_lives_outside_the_drive_or_the_image() -> None:
    known = labels(1)
    lags, _ = extrapolated(Sightings.from_labels(known), CAMERA, LAST + 3, STEP)
    assert lags.max() == 2
    near_border = known.boxes - [150.0, 0.0, 150.0, 0.0]  # enters the image in frame 7
    near_border[:, 0] = near_border[:, 0].clip(0.0)
    rows = extrapolated(
        Sightings.from_labels(replace(known, boxes=near_border)), CAMERA, FRAMES, STEP
    )[1]
    assert rows.frames.min() == 7


def test_as_many_live_as_the_shares_say() -> None:
    sightings = Sightings.from_labels(labels())
    with_lives = Lives(SHARES, NONE)(sightings, 3, CAMERA, FRAMES, STEP)
    assert (np.diff(with_lives.frames) >= 0).all()
    count = np.bincount(with_lives.frames, minlength=FRAMES)
    assert count[LAST + 1 :].sum() == 0
    for frames_before in (1, 3, 6, 8):
        share = share_at(SHARES, np.array([frames_before * STEP]))[0]
        assert count[FIRST - frames_before] / 200 == pytest.approx(share, abs=0.1)
    again = Lives(SHARES, NONE)(sightings, 3, CAMERA, FRAMES, STEP)
    assert (again.ids == with_lives.ids).all()


def test_who_is_in_a_dont_care_region_has_shares_of_its_own() -> None:
    cars = labels(40)
    region = Tracks(
        np.array([FIRST - 1]), np.array([-1]), np.array([[0.0, 0.0, 2000.0, 150.0]]),
        kinds=np.array(["DontCare"]), scores=None,
    )  # fmt: skip
    both = Tracks.concatenate([cars, region])
    ones = (1.0,) * len(LIFE_SECONDS)
    rows = Lives(before_dont_care=ones)(Sightings.from_labels(cars), 3, CAMERA, FRAMES, STEP, both)
    early = rows.select(rows.frames < FIRST)
    assert set(early.frames.tolist()) == {FIRST - 1}
    assert (early.boxes[:, 3] <= 200.0).all()  # the upper row of cars
    assert len(early) == 10
    alone = Lives(before_dont_care=ones)(Sightings.from_labels(cars), 3, CAMERA, FRAMES, STEP)
    assert len(alone) == len(cars)


def test_planted_lives_come_back() -> None:
    drive = LabelledDetections(
        labels(30), DetectionLog(np.zeros(0, np.int64), Detections.empty()), FRAMES, CAMERA
    )
    planted = Profile(lives=Lives(SHARES, SHARES))
    real = simulate(planted, [drive] * 6, 1, STEP)
    made = simulate(replace(planted, lives=ALL_LIVES), [drive] * 6, 2, STEP)
    fitted = fit_lives(seen_lives(real, STEP)[0], seen_lives(made, STEP)[0], STEP)
    assert fitted.before == pytest.approx(SHARES, abs=0.15)
    assert fitted.after == pytest.approx(SHARES, abs=0.15)
    false = measure(real).false
    assert len(false) > 0
    assert of_lives(false, real, STEP).all()


def test_lives_stand_in_a_profile(tmp_path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("\n".join(profile_lines(Profile(lives=Lives(SHARES, NONE)))))
    assert read_profile(path).lives == Lives(SHARES, NONE)


@pytest.mark.parametrize("shares", [SHARES[:-1], (1.1, *SHARES[1:]), SHARES[::-1]])
def test_impossible_shares_are_refused(shares: tuple[float, ...]) -> None:
    with pytest.raises(BadConfig, match="lives before"):
        Lives(before=shares)


def test_shares_end_with_the_last_time() -> None:
    assert share_at((1.0,) * len(LIFE_SECONDS), np.array([0.05, 1.6, 1.61])).tolist() == [1, 1, 0]
