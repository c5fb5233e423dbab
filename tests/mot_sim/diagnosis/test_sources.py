"""Drives whose frames are exchanged: outside nothing changes, to the last bit."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.diagnosis.sources import (
    SOURCES,
    DetectionStream,
    SourceAblation,
    active_sources,
    without,
    without_all,
)
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import drive_of
from mot_sim.simulation.sensors import (
    EFFECTS,
    Miscalibration,
    Odometry,
    Profile,
    Timing,
    find_profile,
)
from mot_sim.simulation.sensors.boxes import Border, VisiblePart
from mot_sim.simulation.sensors.misses import Confusion
from mot_sim.simulation.sensors.multiplicity import Merges, Splits
from mot_sim.simulation.sensors.quantiles import Quantiles
from mot_sim.simulation.sensors.suppression import IOU_BINS, OverlapSuppression
from tests.mot_sim.diagnosis.conftest import Crossing
from tracker.errors import UnknownName

FIRST, LAST = 8, 13
LOW = Quantiles((-3.0, 0.0))  # log-odds
RARE = ("confusion", "merges", "suppression")  # nothing of theirs may be near
AT_FULL_RATE = tuple(source for source in SOURCES if source != "frame rate")


def strong_profile() -> Profile:
    """Every effect at once, each strong enough to be seen in a short drive."""
    rrc, cues = find_profile("rrc"), find_profile("cues")
    assert rrc.misses is not None
    assert rrc.clutter is not None
    assert rrc.duplicates is not None
    return replace(
        rrc,
        confusion=Confusion(0.5, 0.5),
        misses=replace(rrc.misses, base=1.0),
        visible_part=VisiblePart(0.5),
        border=Border(300.0),
        suppression=OverlapSuppression(weakened=(1.0,) * len(IOU_BINS), log_odds=LOW),
        duplicates=replace(rrc.duplicates, seen=(0.3,) * 4),
        clutter=replace(rrc.clutter, rate=1.0),
        merges=Merges(1.0, 0.05),
        splits=Splits(0.5, 40.0),
        pose=cues.pose, keypoints=cues.keypoints, shape=cues.shape, appearance=cues.appearance,
    )  # fmt: skip


@pytest.fixture(scope="module")
def noisy(short: Crossing) -> tuple[Conditions, SourceAblation]:
    """The short crossing with every source of noise, at the full frame rate."""
    conditions = replace(
        short.conditions,
        effects=strong_profile(),
        odometry=Odometry(drift=0.1, slip=0.1, dropouts=0.2),
        timing=Timing(drops=0.2, jitter=0.01, latency=0.1),
        miscalibration=Miscalibration(vibration=0.01),
        rig=replace(short.conditions.rig, height_error=0.1),
    )
    return conditions, SourceAblation.of(conditions, short.recorded, 0)


def told(stream: DetectionStream) -> list[tuple]:
    """All that a tracker is given, frame by frame."""
    return [
        (
            frame.index, frame.time,
            *(None if column is None else column.tobytes() for column in
              vars(frame.detections).values()),
        )
        for frame in stream.until(stream.frame_count)
    ]  # fmt: skip


def rows(stream: DetectionStream) -> set[tuple]:
    """Every box with its frame and score."""
    seen = stream.log.detections
    return {
        (frame, box.tobytes(), score)
        for frame, box, score in zip(
            stream.log.frames.tolist(), seen.boxes, seen.scores.tolist(), strict=True
        )
    }


def test_every_source_is_on_and_can_be_switched_off(
    noisy: tuple[Conditions, SourceAblation],
) -> None:
    conditions, ablation = noisy
    assert active_sources(conditions) == AT_FULL_RATE
    assert tuple(ablation.off) == AT_FULL_RATE
    assert set(AT_FULL_RATE) > set(EFFECTS)


@pytest.mark.parametrize("source", AT_FULL_RATE)
def test_a_source_that_is_off_changes_only_the_frames_in_which_it_is_off(
    noisy: tuple[Conditions, SourceAblation], source: str
) -> None:
    _, ablation = noisy
    found = ablation.without(source, FIRST, LAST)
    if source in RARE:
        assert (found is None) == ablation.stream.same_as(ablation.off[source], FIRST, LAST)
        return
    assert found is not None
    if source in ablation.whole:
        assert source == "rig"
        assert found is ablation.off[source]
        return
    mine, base = told(found), told(ablation.stream)
    for part in ((0, FIRST), (LAST + 1, 99)):
        here = [[row for row in rows if part[0] <= row[0] < part[1]] for rows in (mine, base)]
        assert here[0] == here[1]
    inside = [row for row in mine if FIRST <= row[0] <= LAST]
    if source != "odometry":
        assert inside != [row for row in base if FIRST <= row[0] <= LAST]


def test_at_a_low_frame_rate_the_frames_between_come_inside(short: Crossing) -> None:
    slow = replace(short.conditions, rig=replace(short.conditions.rig, frame_rate=2.5))
    ablation = SourceAblation.of(slow, short.recorded, 0)
    assert "frame rate" in ablation.off
    found = ablation.without("frame rate", FIRST, LAST)
    assert found is not None
    assert found.frames.tolist() == [0, 4, 8, 9, 10, 11, 12, 13, 16]


def test_odometry_is_true_inside_and_as_wrong_as_before_outside(
    noisy: tuple[Conditions, SourceAblation],
) -> None:
    _, ablation = noisy
    mixed = ablation.stream.with_frames_of(ablation.off["odometry"], FIRST, LAST)

    def steps(stream: DetectionStream) -> np.ndarray:
        poses = stream.recorded.Ts_world_cam
        assert poses is not None
        return np.linalg.inv(poses[:-1]) @ poses[1:]

    found, wrong, true = steps(mixed), steps(ablation.stream), steps(ablation.off["odometry"])
    inside = slice(FIRST - 1, LAST)  # the step into frame i is row i - 1
    np.testing.assert_allclose(found[inside], true[inside], atol=1e-9)
    outside = np.ones(len(found), bool)
    outside[inside] = False
    np.testing.assert_allclose(found[outside], wrong[outside], atol=1e-9)
    assert np.abs(wrong[inside] - true[inside]).max() > 1e-3


LEVELS = {
    "misses": "misses", "jitter": "jitter", "visible_part": "jitter", "scores": "score_noise",
    "duplicates": "clutter", "clutter": "clutter", "merges": "clutter", "splits": "clutter",
    "pose": "cues", "keypoints": "cues", "shape": "cues", "appearance": "cues",
    "confusion": "misses", "suppression": "misses",
}  # fmt: skip


@pytest.mark.parametrize("effect", EFFECTS)
def test_an_effect_at_level_0_is_the_effect_switched_off(short: Crossing, effect: str) -> None:
    alone = Profile(**{effect: getattr(strong_profile(), effect)})  # type: ignore[arg-type]
    conditions = replace(short.conditions, effects=alone)
    off = SourceAblation.of(conditions, short.recorded, 0).off[effect]
    if effect == "border":
        at_zero = replace(conditions, effects=Profile(border=Border(0.0)))
    else:
        levels = replace(conditions.detector, **{LEVELS[effect]: 0.0})  # type: ignore[arg-type]
        at_zero = replace(conditions, detector=levels)
    zero = DetectionStream.of(drive_of(at_zero, short.recorded, 0).sequence)
    if effect == "misses":  # the missed boxes come after the others: another order, no other box
        assert rows(off) == rows(zero)
    else:
        assert told(off) == told(zero)


def test_without_misses_only_the_missed_boxes_come(short: Crossing) -> None:
    effects = replace(strong_profile(), merges=None)
    conditions = replace(short.conditions, effects=effects)
    ablation = SourceAblation.of(conditions, short.recorded, 0)

    more = rows(ablation.off["misses"])
    assert rows(ablation.stream) < more


def test_a_stream_with_frames_of_itself_is_itself(noisy: tuple[Conditions, SourceAblation]) -> None:
    _, ablation = noisy
    assert told(ablation.stream.with_frames_of(ablation.stream, 3, 9)) == told(ablation.stream)
    assert ablation.stream.same_as(ablation.stream, 0, 99)
    whole = ablation.stream.with_frames_of(ablation.silent, 0, ablation.stream.frame_count)
    assert told(whole) == told(ablation.silent)


def test_a_stream_is_what_the_drive_delivers(short: Crossing) -> None:
    late = replace(short.conditions, timing=Timing(drops=0.3, jitter=0.01, latency=0.2))
    sequence = drive_of(late, short.recorded, 0).sequence
    given = list(DetectionStream.of(sequence).until(99))
    for mine, theirs in zip(given, sequence, strict=True):
        assert (mine.index, mine.time) == (theirs.index, theirs.time)
        assert mine.detections.boxes.tobytes() == theirs.detections.boxes.tobytes()
        for a, b in ((mine.T_now_before, theirs.T_now_before),):
            assert a is b or np.array_equal(a, b)  # type: ignore[arg-type]


def test_a_perfect_drive_has_no_source(short: Crossing) -> None:
    perfect = replace(short.conditions, effects=Profile())
    assert active_sources(perfect) == ()
    assert without_all(perfect) == perfect
    assert active_sources(without_all(short.conditions)) == ()


def test_an_unknown_source_is_named_with_the_nearest_one(short: Crossing) -> None:
    with pytest.raises(UnknownName, match="Did you mean 'jitter'"):
        without(short.conditions, "jiter")
