"""What was planted to be suppressed comes back from counts of pairs, and is shown."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.simulation.sensors import Autocorrelation, Profile
from mot_sim.simulation.sensors.fitting.calibrate import simulate
from mot_sim.simulation.sensors.fitting.fit_boxes import quantiles_with_ties
from mot_sim.simulation.sensors.fitting.fit_report import fit_lines
from mot_sim.simulation.sensors.fitting.fit_suppression import (
    correct_suppression,
    crowded,
    fit_suppression,
    recall_behind,
)
from mot_sim.simulation.sensors.fitting.measure import LabelledDetections, measure
from mot_sim.simulation.sensors.misses import Misses
from mot_sim.simulation.sensors.quantiles import Quantiles
from mot_sim.simulation.sensors.scores import ScoreNoise
from mot_sim.simulation.sensors.suppression import IOU_BINS, OverlapSuppression
from tests.mot_sim.simulation.sensors.sights import CAMERA
from tracker.types import Detections, Tracks

FRAMES, STEP = 100, 0.1
CUT = (0.0,) * 6 + (0.8,) * 3 + (0.0,) * 6  # between .5 and .6
PLANTED = Profile(
    misses=Misses(3.0),
    scores=ScoreNoise((-4.0, 4.0), (2.0, 6.0)),
    suppression=OverlapSuppression(
        CUT, (0.0, 0.0, 0.0, 1.0, 0.0), Quantiles((0.0, 1.0)), Autocorrelation((1.0,), (0.5,))
    ),
)
FREE = replace(PLANTED, suppression=None)


@pytest.fixture(scope="module")
def bare() -> LabelledDetections:
    """Twelve pairs of cars, a quarter of them with an IoU of .43, .54, .67 each, and one of 0."""
    ids, frames = np.tile(np.arange(24), FRAMES), np.repeat(np.arange(FRAMES), 24)
    apart = np.array([40.0, 30.0, 20.0, 100.0])[ids // 2 % 4]
    left = 100.0 * (ids // 2) + apart * (ids % 2)
    top = np.where(ids % 2 == 0, 150.0, 149.0) + 60.0 * (ids // 2 % 2)
    boxes = np.stack((left, top, left + 100.0, top + 50.0), axis=1)
    labels = Tracks(frames, ids, boxes, kinds=np.full(len(ids), "Car", "<U8"))
    log = DetectionLog(np.zeros(0, np.int64), Detections.empty())
    wide = replace(CAMERA, image_size=(1400, 375))
    return LabelledDetections(labels, log, FRAMES, wide)


def measured(profile: Profile, bare: LabelledDetections, seed: int):
    return measure(simulate(profile, [bare], seed))


@pytest.fixture(scope="module")
def real(bare: LabelledDetections):
    return measured(PLANTED, bare, 1)


def test_planted_rates_come_back(bare, real) -> None:
    found = fit_suppression(real, [measured(FREE, bare, seed) for seed in (2, 3)], STEP)
    assert found is not None
    by_iou = np.array(found.dropped).reshape(len(IOU_BINS), -1)[:, -1]
    assert by_iou == pytest.approx([0.0, 0.0, 0.8, 0.0, 0.0], abs=0.12)
    assert found.weakened == pytest.approx([0.0, 0.0, 0.0, 1.0, 0.0], abs=0.1)
    assert found.log_odds.values[0] == pytest.approx(0.0, abs=0.1)
    assert found.autocorrelation.correlation(0.1) > 0.5


def test_what_is_left_is_corrected(bare, real) -> None:
    mild = replace(PLANTED.suppression, dropped=(0.0,) * 6 + (0.4,) * 3 + (0.0,) * 6)
    made = [measured(replace(PLANTED, suppression=mild), bare, 2)]
    dropped = correct_suppression(mild, real, made).dropped
    assert dropped[7] == pytest.approx(0.7, abs=0.1)  # at most half of what was left
    assert dropped[3] == 0.0


def test_too_few_pairs_tell_nothing(bare, real) -> None:
    lonely = replace(bare, labels=bare.labels.select(bare.labels.ids % 2 == 0))
    assert fit_suppression(real, [measured(FREE, lonely, 2)], STEP) is None


def test_the_report_shows_pairs_and_recall_behind(bare, real) -> None:
    lines = {line.what: line for line in fit_lines(real, measured(FREE, bare, 2))}
    assert (
        lines["of these both scores above 0.9"].real < lines["of these both scores above 0.9"].made
    )
    behind = lines["recall, 0.5-0.6 IoU with a nearer one"]
    assert behind.real == pytest.approx(0.95 * (1.0 - 0.8 / 2.0), abs=0.06)  # either is the weaker
    assert behind.made == pytest.approx(0.95, abs=0.05)
    counts = [count for count, _ in recall_behind(real.found, (0.3, 0.4, 0.5, 0.6, 0.7))]
    assert counts == [0, 3 * FRAMES, 3 * FRAMES, 3 * FRAMES]
    assert crowded(real.found).mean() == 0.75


def test_tied_scores_stay_tied() -> None:
    values = np.concatenate((np.full(500, 5.8), np.full(300, 5.7), np.linspace(0.0, 5.0, 200)))
    probabilities, quantiles = quantiles_with_ties(values)
    made = np.interp((np.arange(1000) + 0.5) / 1000, probabilities, quantiles)
    assert (made == 5.8).sum() == 500
    assert (made == 5.7).sum() == 300
    assert made[:180] == pytest.approx(values[800:980], abs=0.1)
