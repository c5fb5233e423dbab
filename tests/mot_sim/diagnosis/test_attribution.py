"""Planted faults are blamed on their source; what is no removal is not taken for one."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.attribution import (
    PlantedJitter,
    PlantedMisses,
    PlantedOdometry,
    Spot,
    planted,
)
from mot_sim.diagnosis.attribution import (
    EITHER_SOURCE,
    NO_NOISE,
    ONE_SOURCE,
    VERDICTS,
    Attributor,
    Cause,
    Incident,
    Replays,
    incidents,
    is_kept,
    shares,
)
from mot_sim.diagnosis.sources import SourceAblation
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.following import TrackerFailed
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.metrics.breaks import Breaks, Matches
from mot_sim.simulation.sensors import Profile
from mot_sim.simulation.truth import labels
from tests.mot_sim.diagnosis.conftest import FORGETFUL, Crossing
from tests.mot_sim.diagnosis.test_findings import breaks_at

SPOT = Spot(car=4, first=14, last=22, shift=(2.5, 0.0))
ON = ("misses", "jitter")  # of the profile; the fewer, the fewer replays


def matches(*rows: tuple[int, int, int]) -> Matches:
    """Rows (frame, car, name)."""
    frames, cars, names = (np.array(column) for column in zip(*rows, strict=True))
    return Matches(frames, cars, names, frames)


@pytest.mark.parametrize(
    ("names", "kept"),
    [
        ({8: 1, 9: 1, 10: 1, 20: 1, 21: 1}, True),
        ({8: 1, 9: 1, 10: 1, 20: 2, 21: 2}, False),  # the switch is there
        ({8: 1, 9: 1, 16: 2, 20: 2}, False),  # it comes earlier
        ({8: 1, 10: 1, 20: 1, 29: 2}, False),  # it comes later
        ({8: 1, 10: 1, 20: 1, 45: 2}, True),  # another one
        ({8: 1, 10: 1}, False),  # the car is lost instead
        ({20: 1, 21: 1}, False),  # it was never had before
        ({}, False),
    ],
)
def test_a_switch_is_gone_when_the_car_keeps_one_name(names: dict[int, int], kept: bool) -> None:
    rows = [(frame, 7, name) for frame, name in names.items()]
    found = matches(*rows, (15, 8, 3)) if rows else matches((15, 8, 3))
    found = found.select(np.lexsort((found.frames, found.cars)))
    assert is_kept(found, Incident(7, 10, 20, (0,)), window=5) is kept


def test_switches_of_one_car_that_are_near_are_one_incident() -> None:
    rows = [(3, 5, 1), (12, 14, 1), (40, 41, 1), (5, 6, 2)]
    found = list(incidents(breaks_at(*((b, f, c, True, False) for b, f, c in rows)), 5))
    assert [(each.car, each.before, each.frame, each.rows) for each in found] == [
        (1, 3, 14, (0, 1)), (1, 40, 41, (2,)), (2, 5, 6, (3,)),
    ]  # fmt: skip


def quiet(crossing: Crossing) -> Conditions:
    """The crossing with a few effects of RRC at their normal level."""
    effects = crossing.conditions.effects
    kept: dict[str, Any] = {name: getattr(effects, name) for name in ON}
    return replace(crossing.conditions, effects=Profile(**kept))


def spoilt(crossing: Crossing, source: str) -> Conditions:
    """The same with one fault in one source."""
    conditions = quiet(crossing)
    kinds = {"misses": PlantedMisses, "jitter": PlantedJitter}
    if source in kinds:
        effect = planted(kinds[source], getattr(conditions.effects, source), spot=SPOT)
        changed: dict[str, Any] = {source: effect}
        return replace(conditions, effects=replace(conditions.effects, **changed))
    turn = Spot(first=14, last=15)
    return replace(
        conditions, odometry=planted(PlantedOdometry, conditions.odometry, spot=turn, angle=0.5)
    )


def switches_of(conditions: Conditions, crossing: Crossing) -> Breaks:
    """The switches under these conditions."""
    diagnosed, output = crossing.task(conditions).track()
    return Breaks.of(Matches.of(diagnosed.truth, output, 40)).switches


def judged(conditions: Conditions, crossing: Crossing, switches: Breaks) -> list[Cause]:
    """What switches hang on."""
    ablation = SourceAblation.of(conditions, crossing.recorded, 0)
    every = labels(crossing.recorded.annotations.truth)
    return Attributor(ablation, every, Replays(FORGETFUL)).attribute(switches)


@pytest.mark.parametrize("source", [*ON, "odometry"])
def test_a_planted_switch_hangs_on_its_source(crossing: Crossing, source: str) -> None:
    clean = switches_of(quiet(crossing), crossing).cars
    conditions = spoilt(crossing, source)
    switches = switches_of(conditions, crossing)
    new = switches.select(~np.isin(switches.cars, clean))
    mine = new.select(new.cars == new.cars[0])  # of one car: the fewer, the fewer replays
    causes = judged(conditions, crossing, mine)
    assert len(causes) == len(mine)
    assert {(cause.verdict, cause.sources) for cause in causes} == {(ONE_SOURCE, (source,))}


def test_a_switch_that_is_there_without_noise_is_the_trackers_own(crossing: Crossing) -> None:
    tracker = TrackerSpec("odd", "tests.mot_sim.diagnosis.odd:NewNameAtTen")
    task = replace(crossing.task(quiet(crossing), attribute=True), tracker_spec=tracker)
    found = task.run()
    at_ten = [case for case in found.cases if case.switched and case.frame == 10]
    assert at_ten
    assert {case.verdict for case in at_ten} == {NO_NOISE}
    assert {case.sources for case in at_ten} == {()}


def test_a_replay_from_a_copy_is_the_run_from_the_beginning(crossing: Crossing) -> None:
    ablation = SourceAblation.of(quiet(crossing), crossing.recorded, 0)
    changed = ablation.without("jitter", 15, 25)
    assert changed is not None
    replays = Replays(FORGETFUL)
    whole = replays.run(ablation.stream, 40, [14])
    assert 14 in replays.kept
    fresh = Replays(FORGETFUL).run(changed, 35)
    for _ in range(2):  # the copy stays as it was
        again = replays.run_from(14, changed, 35)
        assert again.boxes.tobytes() == fresh.boxes.tobytes()
        assert again.ids.tolist() == fresh.ids.tolist()
    assert replays.run(ablation.stream, 40).ids.tolist() == whole.ids.tolist()


def test_shares_of_several_sources_are_equal_parts() -> None:
    causes = [
        Cause(1, 2, 3, ONE_SOURCE, ("misses",)),
        Cause(1, 2, 4, EITHER_SOURCE, ("misses", "jitter")),
        Cause(1, 2, 5, NO_NOISE),
    ]
    assert shares(causes) == {"misses": 1.5, "jitter": 0.5}
    assert {cause.verdict for cause in causes} <= set(VERDICTS)


def test_a_tracker_that_fails_is_named_with_the_frame(crossing: Crossing) -> None:
    tracker = TrackerSpec("odd", "tests.mot_sim.diagnosis.odd:FailsAtFive")
    with pytest.raises(TrackerFailed, match=r"tracker odd failed in frame 5 of crossing/0: .*five"):
        replace(crossing.task(), tracker_spec=tracker).run()


@pytest.mark.parametrize(
    ("word", "is_late"), [("default", False), ("default:associate=window", True)]
)
def test_a_tracker_that_decides_later_sees_the_drive_to_its_end(
    crossing: Crossing, word: str, is_late: bool
) -> None:
    ablation = SourceAblation.of(quiet(crossing), crossing.recorded, 0)
    replays = Replays(TrackerSpec.parse(word))
    replays.run(ablation.stream, 6)
    assert replays.is_late is is_late
    attributor = Attributor(ablation, labels(crossing.recorded.annotations.truth), replays)
    assert attributor.window_of(Incident(4, 11, 12, (0,))) == (1, 22, 39 if is_late else 32)
