"""Calibration: planted parameters come back, and too little to go by is refused."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.simulation.sensors import Autocorrelation, Profile, Sightings
from mot_sim.simulation.sensors.fitting.calibrate import (
    fit_profile,
    measured_of,
    missed_by_chance,
    simulate,
)
from mot_sim.simulation.sensors.fitting.fit_boxes import fit_jitter
from mot_sim.simulation.sensors.fitting.fit_false import (
    handed_over,
    handed_over_counts,
    jump_counts,
)
from mot_sim.simulation.sensors.fitting.fit_report import curves, fit_lines, fit_picture
from mot_sim.simulation.sensors.fitting.measure import LabelledDetections, measure
from mot_sim.simulation.sensors.fitting.statistics import Distance, gap_lengths, ks_distance, lagged
from mot_sim.simulation.sensors.fitting.tetrachoric import (
    both_below,
    correlation_of,
    nearest_autocorrelation,
)
from mot_sim.simulation.sensors.jitter import EDGES, EdgeNoise, Jitter
from mot_sim.simulation.sensors.misses import Confusion, Misses
from mot_sim.simulation.sensors.scores import ScoreNoise
from tests.mot_sim.simulation.sensors.sights import CAMERA
from tracker.errors import BadConfig, BadDetections
from tracker.types import Detections, Tracks

SLOW = Autocorrelation((1.0,), (1.2,))
PLANTED = Profile(
    confusion=Confusion(),
    misses=Misses(2.0, (-3.0, -2.0, -1.0, 0.0), autocorrelation=SLOW),
    jitter=Jitter(
        EdgeNoise(0.02, bias=0.01, autocorrelation=SLOW),
        EdgeNoise(0.03, bias_pixels=0.6, autocorrelation=SLOW),
        EdgeNoise(0.04, autocorrelation=SLOW),
        EdgeNoise(0.03, autocorrelation=SLOW),
        vertical=0.5,
    ),
    scores=ScoreNoise((-4.0, 4.0), (-2.0, 6.0), autocorrelation=SLOW),
)


def labels(cars: int = 60, frames: int = 150) -> Tracks:
    """Cars in a row, of three occlusion levels and several heights."""
    ids, times = np.tile(np.arange(cars), frames), np.repeat(np.arange(frames), cars)
    height = 30.0 + 4.0 * (ids % 10)
    left, top = 20.0 * ids, 40.0 + 90.0 * (ids % 3)
    return Tracks(
        times,
        ids,
        np.stack((left, top, left + 1.6 * height, top + height), axis=1).clip(0.0, 1200.0),
        kinds=np.full(len(ids), "Car", dtype="<U8"),
        truncation=np.zeros(len(ids), np.int64),
        occlusion=ids // 3 % 3,
    )


def empty() -> DetectionLog:
    return DetectionLog(np.zeros(0, np.int64), Detections.empty())


@pytest.fixture(scope="module")
def drives() -> list[LabelledDetections]:
    bare = [LabelledDetections(labels(), empty(), 150, CAMERA) for _ in range(2)]
    return simulate(PLANTED, bare, 5)


@pytest.fixture(scope="module")
def fitted(drives) -> Profile:
    return fit_profile(drives)


def test_planted_rates_come_back(drives, fitted) -> None:
    assert fitted.misses is not None
    sightings = Sightings.from_labels(labels(frames=1))
    model, planted = fitted.misses.rates(sightings), PLANTED.misses.rates(sightings)
    for level in (0.95, 0.65, 0.35):
        rows = sightings.visible == level
        assert model[rows].mean() == pytest.approx(planted[rows].mean(), abs=0.06)


def test_planted_box_errors_and_memories_come_back(fitted) -> None:
    assert fitted.jitter is not None
    for name in EDGES:
        part, planted = getattr(fitted.jitter, name), getattr(PLANTED.jitter, name)
        assert part.spread * part.shape(np.array([1.0]))[0] == pytest.approx(
            planted.spread, rel=0.2
        )
        assert part.bias == pytest.approx(planted.bias, abs=0.005)
        assert part.autocorrelation.correlation(0.1) == pytest.approx(np.exp(-0.1 / 1.2), abs=0.06)
    assert fitted.misses.autocorrelation.correlation(0.1) == pytest.approx(
        np.exp(-0.1 / 1.2), abs=0.06
    )


def test_a_planted_share_of_unsure_boxes_comes_back(drives) -> None:
    bare = [replace(each, log=empty()) for each in drives]
    unsure = replace(PLANTED, jitter=replace(PLANTED.jitter, unsure_own=0.5))
    assert fit_jitter(measure(simulate(unsure, bare, 5)).found, 0.1).unsure_own == pytest.approx(
        0.5, abs=0.1
    )
    assert fit_jitter(measure(drives).found, 0.1).unsure_own < 0.1


def test_what_chance_adds_to_the_misses_of_simulations_is_known(drives) -> None:
    found = measure(drives).found
    rates = PLANTED.misses.rates(found.sightings)[found.counted]
    blind = Profile(misses=PLANTED.misses)
    made = np.mean([each.recall for each in measured_of(blind, drives, 0.1, 2)])
    by_chance = missed_by_chance(PLANTED.misses, drives, found, 0.1, 2)
    assert abs(by_chance) > 1e-4
    assert made + by_chance == pytest.approx(1.0 - rates.mean(), abs=1e-9)


def test_what_is_fitted_looks_like_what_it_was_fitted_to(drives, fitted) -> None:
    real = measure(drives)
    made = measure([each for seed in range(3) for each in simulate(fitted, drives, seed)])
    distance = Distance.between(made, real)
    assert distance.gaps < 0.15
    assert distance.edges < 0.08
    assert distance.scores < 0.15
    assert distance.recall < 0.05
    lines = fit_lines(real, made)
    assert {"recall", "gaps in 1000 frames"} <= {line.what for line in lines}
    assert fit_picture(curves(real, made)).shape == (900, 1260, 3)


def test_a_detector_of_nothing_false_has_no_ghosts(fitted) -> None:
    assert fitted.clutter is None


def test_too_few_matches_are_refused_with_the_number_that_is_needed(drives) -> None:
    few = drives[0].log
    short = replace(drives[0], log=DetectionLog(few.frames[:50], few.detections.select(slice(50))))
    with pytest.raises(BadConfig, match=r"match a labelled car; a profile needs at least 500"):
        fit_profile([short])


def test_labels_without_detections_are_refused() -> None:
    with pytest.raises(BadDetections, match="9000 labels but no detections"):
        fit_profile([LabelledDetections(labels(), empty(), 150, CAMERA)])
    with pytest.raises(BadDetections, match="no labels"):
        fit_profile([])


def test_sheppards_integral_is_right() -> None:
    a, b = np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.5, 1.0])
    np.testing.assert_allclose(both_below(a, b, 0.5)[0], 1.0 / 3.0)  # 1/4 + asin(.5) / 2 pi
    rng = np.random.default_rng(0)
    x, z = rng.normal(size=(2, 400_000))
    y = 0.7 * x + np.sqrt(0.51) * z
    assert both_below(a, b, 0.7)[1] == pytest.approx(np.mean((x < -1.0) & (y < 0.5)), abs=0.003)


def test_a_latent_correlation_is_found_again() -> None:
    rng = np.random.default_rng(1)
    x, z = rng.normal(size=(2, 20_000))
    y = 0.8 * x + 0.6 * z
    rates = np.full(20_000, 0.1)
    limit = -1.2815515655446004
    assert correlation_of(rates, rates, x < limit, y < limit) == pytest.approx(0.8, abs=0.04)
    assert np.isnan(correlation_of(rates[:0], rates[:0], x[:0] < 0, y[:0] < 0))


def test_a_mixture_of_memories_is_found_again() -> None:
    true = Autocorrelation((0.4, 0.6), (0.12, 4.0))
    times = [0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 4.0]
    found = nearest_autocorrelation(times, [true.correlation(t) for t in times], [1.0] * 7)
    np.testing.assert_allclose(
        [found.correlation(t) for t in times], [true.correlation(t) for t in times], atol=0.01
    )


def test_figures_by_hand() -> None:
    first, second = lagged(np.array([1, 1, 1, 2]), np.array([0, 1, 3, 1]), 1)
    assert (first.tolist(), second.tolist()) == ([0], [1])
    assert ks_distance(np.array([0.0, 1.0]), np.array([1.0, 2.0])) == 0.5
    assert ks_distance(np.zeros(0), np.ones(2)) == 1.0


def test_a_gap_is_what_lies_between_two_sightings() -> None:
    one = labels(1, 8)
    rows = np.array([1, 2, 5, 6])  # not found in 0, 3, 4, 7
    log = DetectionLog(rows, Detections(one.boxes[rows], np.ones(4)))
    assert gap_lengths(measure([LabelledDetections(one, log, 8, CAMERA)]).found).tolist() == [2]


def test_boxes_that_jump_and_twins_are_reported() -> None:
    one = labels(1, 11)
    boxes = one.boxes.copy()
    boxes[5] += [8.0, 0.0, 8.0, 0.0]  # there and back: two changes of ten
    twin = boxes[8:9] + [12.0, 0.0, 12.0, 0.0]
    log = DetectionLog(
        np.insert(one.frames, 9, 8), Detections(np.insert(boxes, 9, twin, 0), np.ones(12))
    )
    measured = measure([LabelledDetections(one, log, 11, CAMERA)])
    told = {line.what: line.real for line in fit_lines(measured, measured)}
    assert told["boxes that jump: IoU below 0.8"] == pytest.approx(0.2)
    assert told["boxes that jump: IoU below 0.7"] == 0.0
    assert told["twins of 1000 right boxes"] == pytest.approx(1000.0 / 11.0)


def test_twins_that_a_tracker_may_take_for_the_car_are_told_from_the_others() -> None:
    one = LabelledDetections(labels(1, 9), empty(), 9, CAMERA)
    boxes = one.labels.boxes.copy()
    boxes[4:] += [10.0, 0.0, 10.0, 0.0]  # it jumps
    twins = np.array([boxes[1] + [0.0, 0.0, 0.0, 9.0], boxes[3]])  # beside it, left behind
    frames, scores = np.array([*range(9), 1, 4]), np.array([1.0] * 4 + [0.8] * 5 + [0.9] * 2)
    order = np.argsort(frames, kind="stable")
    both = Detections(np.concatenate((boxes, twins)), scores).select(order)
    measured = measure([replace(one, log=DetectionLog(frames[order], both))])
    assert handed_over(measured).tolist() == [False, True]
    assert handed_over_counts([measured]).tolist() == [0.0, 1.0]
    assert jump_counts([measured]).tolist() == [0.0, 1.0]
