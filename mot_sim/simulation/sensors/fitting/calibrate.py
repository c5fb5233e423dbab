"""Fits a profile to any detections with labels."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import log

import numpy as np

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.simulation.sensors.boxes import Border
from mot_sim.simulation.sensors.detector import Detector
from mot_sim.simulation.sensors.fitting.fit_boxes import fit_jitter, fit_scores
from mot_sim.simulation.sensors.fitting.fit_false import (
    FalseCounts,
    false_counts,
    fit_clutter,
    fit_duplicates,
    handed_over_counts,
    jump_counts,
)
from mot_sim.simulation.sensors.fitting.fit_lives import (
    ALL_LIVES,
    SeenLives,
    fit_lives,
    of_lives,
    seen_lives,
)
from mot_sim.simulation.sensors.fitting.fit_misses import fit_confusion, fit_misses
from mot_sim.simulation.sensors.fitting.fit_suppression import (
    correct_suppression,
    crowded,
    fit_suppression,
)
from mot_sim.simulation.sensors.fitting.measure import (
    DetectorMeasurements,
    Found,
    LabelledDetections,
    measure,
)
from mot_sim.simulation.sensors.fitting.statistics import gap_lengths
from mot_sim.simulation.sensors.misses import Confusion, Misses
from mot_sim.simulation.sensors.profile import Profile
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.errors import BadConfig, BadDetections

MIN_MATCHES = 500  # below, the tables by size and occlusion are guesses
FIRST_SEED = 7  # of the simulations
SEEDS_PER_ROUND = 6
# Simulations in each round of correcting pooled figures: the last one decides, and one simulation
# of KITTI's ten drives has a tenth more gaps or false boxes than the next.
SEEDS_OF_ROUNDS = (SEEDS_PER_ROUND, SEEDS_PER_ROUND, 18)
DENSE_CLUTTER, DENSE_SEEDS = 2.0, 2  # false alarms a frame, to see how many of them count
GAP_EXPONENT = 1.5  # of how many gaps are too many: gaps get fewer more slowly than times grow
MAX_CLUTTER = 8.0  # false alarms a frame
KITTI_STEP_SECONDS = 0.1  # seconds between KITTI's frames

Progress = Callable[[str], None]


def fit_profile(
    drives: Sequence[LabelledDetections],
    name: str = "fitted",
    step: float = KITTI_STEP_SECONDS,
    tell: Progress = lambda _: None,
) -> Profile:
    """The profile that is likeliest to have made the drives' detections.

    tell: called with what is under way. Raises BadDetections for labels without detections,
    BadConfig for too few matches.
    """
    require_detections(drives)
    tell("matching")
    measured = measure(drives)
    matches = int(measured.found.hit.sum())
    if matches < MIN_MATCHES:
        raise BadConfig(
            f"{matches} detections match a labelled car; a profile needs at least "
            f"{MIN_MATCHES}: give more sequences, or check that labels and detections belong "
            "together"
        )
    tell("misses and box errors")
    alone = measured.found.select(~crowded(measured.found))  # what suppression takes counts once
    misses, jitter = fit_misses(alone, step), fit_jitter(measured.found, step)
    tell("scores")
    seen, scored = seen_lives(drives, step)
    scores = fit_scores(alone, misses, step, scored)
    tell("false positives")
    own = of_lives(measured.false, drives, step)
    elsewhere = replace(measured, false=measured.false.select(~own))
    profile = Profile(
        name=name,
        source=f"{matches} matches in {measured.frame_count} labelled frames",
        confusion=fit_confusion(measured.found, elsewhere.false, misses, step),
        misses=misses,
        jitter=jitter,
        border=Border(),
        scores=scores,
        duplicates=fit_duplicates(elsewhere, step),
        clutter=fit_clutter(elsewhere, step),
    )
    profile = with_lives(profile, drives, seen, step)
    profile = allow_for_jitter(profile, drives, measured, step)
    for number, seeds in enumerate(SEEDS_OF_ROUNDS, 1):
        tell(f"simulating, round {number} of {len(SEEDS_OF_ROUNDS)}")
        profile = correct_by_simulation(profile, drives, measured, step, seeds)
    return profile


def require_detections(drives: Sequence[LabelledDetections]) -> None:
    """BadDetections when there is nothing to compare."""
    labels, boxes = (
        sum(len(drive.labels) for drive in drives),
        sum(len(drive.log.frames) for drive in drives),
    )
    if not labels:
        raise BadDetections("no labels: a profile is fitted to detections of labelled drives")
    if not boxes:
        raise BadDetections(
            f"{labels} labels but no detections; name a detector whose files are there"
        )


def simulate(
    profile: Profile,
    drives: Sequence[LabelledDetections],
    seed: int,
    step: float = KITTI_STEP_SECONDS,
) -> list[LabelledDetections]:
    """The same drives, seen by the profile in place of the detector."""
    return [
        replace(drive, log=seen_in(drive, Sightings.from_labels(drive.labels), profile, own, step))
        for drive, own in zip(drives, drive_seeds(drives, seed), strict=True)
    ]


def drive_seeds(drives: Sequence[LabelledDetections], seed: int) -> range:
    """The seed of each drive in a simulation of all."""
    return range(seed * 1000, seed * 1000 + len(drives))


def seen_in(
    drive: LabelledDetections, sightings: Sightings, profile: Profile, seed: int, step: float
) -> DetectionLog:
    """What the profile gives for a labelled drive, before and after the labels too.

    sightings: of its labelled cars.
    """
    if profile.lives is not None:
        sightings = profile.lives(
            sightings, seed, drive.camera, drive.frame_count, step, drive.labels
        )
    frames = np.arange(drive.frame_count)
    return Detector(profile).sense(sightings, seed, drive.camera, step, frames).log


def with_lives(
    profile: Profile, drives: Sequence[LabelledDetections], seen: SeenLives, step: float
) -> Profile:
    """The profile with the lives of cars before and after their labels; seen: the real ones."""
    always = replace(profile, lives=ALL_LIVES)
    made = [
        each
        for k in range(SEEDS_PER_ROUND)
        for each in simulate(always, drives, FIRST_SEED + k, step)
    ]
    return replace(profile, lives=fit_lives(seen, seen_lives(made, step)[0], step))


def correct_by_simulation(
    profile: Profile,
    drives: Sequence[LabelledDetections],
    real: DetectorMeasurements,
    step: float,
    seeds: int = SEEDS_PER_ROUND,
) -> Profile:
    """Shift what is suppressed, rates of misses and false boxes, and times of misses by what a
    simulation has too many or few of.

    False alarms may lie where they do not count, and gaps end where a car's rate changes: the
    effects' own figures do not show that.
    """
    if profile.suppression is None:
        without = measured_of(replace(profile, clutter=None), drives, step, seeds)
        profile = replace(profile, suppression=fit_suppression(real, without, step))
    quiet = measured_of(replace(profile, clutter=None), drives, step, seeds)
    bare = quiet
    if profile.duplicates is not None:
        bare = measured_of(replace(profile, clutter=None, duplicates=None), drives, step, seeds)
    misses = profile.misses
    assert misses is not None
    gaps = float(np.mean([len(gap_lengths(each.found)) for each in quiet]))
    factor = _factor(gaps, float(len(gap_lengths(real.found)))) ** GAP_EXPONENT
    recall = float(np.mean([each.recall for each in quiet]))
    recall += missed_by_chance(misses, drives, real.found, step, seeds)
    misses = replace(
        misses,
        base=misses.base + _odds(real.recall) - _odds(recall),
        autocorrelation=misses.autocorrelation.slower(factor),
        flutter_autocorrelation=misses.flutter_autocorrelation.slower(factor),
    )
    suppression = profile.suppression
    if suppression is not None:
        suppression = correct_suppression(suppression, real, quiet)
    profile = replace(profile, misses=misses, suppression=suppression)
    return _correct_false(profile, drives, real, quiet, bare, step)


def _correct_false(
    profile: Profile,
    drives: Sequence[LabelledDetections],
    real: DetectorMeasurements,
    quiet: Sequence[DetectorMeasurements],
    bare: Sequence[DetectorMeasurements],
    step: float,
) -> Profile:
    """The rates of second boxes and of false alarms, and who lives beside its labels.

    quiet: simulations without false alarms; bare: without second boxes too.
    """
    wanted, with_second, without = (
        false_counts(each, drives, step) for each in ([real], quiet, bare)
    )
    lives = profile.lives
    if lives is not None:
        lives = lives.scaled(_factor(wanted.own, with_second.own))
    share = FalseCounts(0.0, 0.0, 0.0)
    if profile.clutter is not None:
        dense = replace(profile.clutter, rate=DENSE_CLUTTER)
        alone = Profile(confusion=Confusion(), clutter=dense)  # and no truck
        share = false_counts(measured_of(alone, drives, step, DENSE_SEEDS), drives, step)
    rate = 0.0 if profile.clutter is None else profile.clutter.rate
    duplicates, factor = profile.duplicates, 1.0
    if duplicates is not None:
        by_chance = without.near + share.near * rate / DENSE_CLUTTER
        over, made_over = handed_over_counts([real]), handed_over_counts(quiet)
        factor = _factor(
            wanted.near - by_chance - float(over.sum()),
            with_second.near - without.near - float(made_over.sum()),
        )
        at_jumps = np.array([duplicates.at_jumps, duplicates.at_unsure_jumps])
        if at_jumps.any():
            at_jumps *= [
                _factor(*pair) for pair in zip(over.tolist(), made_over.tolist(), strict=True)
            ]
        else:
            at_jumps = over / np.maximum(jump_counts(quiet), 1.0)
        at_jumps = np.minimum(at_jumps, 1.0).round(4)
        duplicates = replace(
            duplicates,
            seen=tuple(min(factor * each, 1.0) for each in duplicates.seen),
            missed=tuple(min(factor * each, 1.0) for each in duplicates.missed),
            at_jumps=float(at_jumps[0]),
            at_unsure_jumps=float(at_jumps[1]),
        )
    clutter = profile.clutter
    if clutter is not None:
        others = without.far + factor * (with_second.far - without.far)
        rate = max(wanted.far - others, 0.0) / max(share.far, 1e-9) * DENSE_CLUTTER
        clutter = replace(clutter, rate=min(rate, MAX_CLUTTER))
    return replace(profile, duplicates=duplicates, clutter=clutter, lives=lives)


def missed_by_chance(
    misses: Misses, drives: Sequence[LabelledDetections], found: Found, step: float, seeds: int
) -> float:
    """The part of counted cars that the simulations of `measured_of` miss beyond the rates.

    Where few cars are in view for long, the recall of ten drives varies by .0065 from seed to seed,
    and all but .001 of that are these draws. found: what is labelled in all drives.
    """
    missed = [
        misses(Sightings.from_labels(drive.labels), seed, step)[0]
        for k in range(seeds)
        for drive, seed in zip(drives, drive_seeds(drives, FIRST_SEED + k), strict=True)
    ]
    beyond = np.concatenate(missed).reshape(seeds, -1).mean(axis=0) - misses.rates(found.sightings)
    return float(beyond[found.counted].mean())


def measured_of(
    profile: Profile,
    drives: Sequence[LabelledDetections],
    step: float,
    seeds: int = SEEDS_PER_ROUND,
) -> list[DetectorMeasurements]:
    """What is measured of the profile on the drives, a simulation each."""
    return [measure(simulate(profile, drives, FIRST_SEED + k, step)) for k in range(seeds)]


def allow_for_jitter(
    profile: Profile, drives: Sequence[LabelledDetections], real: DetectorMeasurements, step: float
) -> Profile:
    """Raise the odds of being found by what jitter makes of them: boxes too bad to match.

    Simulated with and without jitter; the draws of the misses are the same in both.
    """
    hits = [
        float(
            np.mean(
                [
                    _recall(simulate(each, drives, FIRST_SEED + k, step))
                    for k in range(SEEDS_PER_ROUND)
                ]
            )
        )
        for each in (profile, replace(profile, jitter=None))
    ]
    assert profile.misses is not None
    wanted = min(real.recall * hits[1] / max(hits[0], 1e-9), 0.9999)
    shift = _odds(wanted) - _odds(real.recall)
    return replace(profile, misses=replace(profile.misses, base=profile.misses.base + shift))


def _recall(drives: Sequence[LabelledDetections]) -> float:
    return measure(drives).recall


def _odds(rate: float) -> float:
    rate = min(max(rate, 1e-4), 1.0 - 1e-4)
    return log(rate / (1.0 - rate))


def _factor(wanted: float, made: float) -> float:
    return float(np.clip((max(wanted, 0.0) + 1.0) / (max(made, 0.0) + 1.0), 0.3, 3.0))
