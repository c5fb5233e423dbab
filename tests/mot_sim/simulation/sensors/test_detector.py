"""The effects put together: exact without noise, independent streams, provenance, live steps."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.simulation.sensors import Detector, Sightings, find_profile
from mot_sim.simulation.sensors.cues import Pose
from mot_sim.simulation.sensors.detector import Sensed
from mot_sim.simulation.sensors.jitter import EDGES
from mot_sim.simulation.sensors.profile import PROFILES, Profile
from tests.mot_sim.simulation.sensors.sights import CAMERA, STEP, crowd, sightings_of
from tests.mot_sim.simulation.truth.states import RIG, state_of, truth_of
from tracker.errors import BadConfig, UnknownName
from tracker.types import Tracks

LOUD = find_profile("pointrcnn")
ALONE = replace(LOUD, suppression=None)  # a car's detections depend on no other car


def uncoupled() -> Profile:
    """The same without what ties effects: boxes that go by scores, and are left at jumps."""
    jitter, duplicates = ALONE.jitter, ALONE.duplicates
    assert jitter is not None
    assert duplicates is not None
    sure = {name: replace(getattr(jitter, name), unsure=0.0) for name in EDGES}
    return replace(
        ALONE,
        jitter=replace(jitter, unsure_own=0.0, **sure),
        duplicates=replace(duplicates, at_jumps=0.0, at_unsure_jumps=0.0),
    )


UNCOUPLED = uncoupled()


def rows(sensed: Sensed, source: str = "object") -> dict[tuple[int, int], tuple[float, ...]]:
    """Box and score by frame and id, of detections of one source."""
    log, origin = sensed.log, sensed.provenance
    return {
        (int(frame), int(number)): (*box, score)
        for frame, number, box, score, kind in zip(
            log.frames,
            origin.ids,
            log.detections.boxes.tolist(),
            log.detections.scores.tolist(),
            origin.sources,
            strict=True,
        )
        if kind == source
    }


@pytest.mark.parametrize(
    "exact",
    [Detector("perfect"), Detector(LOUD, jitter=0.0, misses=0.0, score_noise=0.0, clutter=0.0)],
)
def test_a_detector_without_noise_gives_the_exact_boxes_bit_by_bit(exact) -> None:
    truth = truth_of(state_of((15.0, 0.0, 0.0), (22.0, 4.0, 0.0)))
    log = exact(truth, 5, RIG.camera)
    assert log.detections.boxes.tobytes() == truth.tracks.boxes.tobytes()
    assert (log.detections.scores == 1.0).all()
    assert (log.frames == truth.tracks.frames).all()


def test_a_car_of_which_nothing_is_visible_is_never_seen() -> None:
    sightings = sightings_of([0, 1], [0, 0], visible=[0.0, 1.0])
    for profile in PROFILES:
        detector = Detector(profile, misses=0.0, clutter=1.0)
        assert 0 not in detector.sense(sightings, 0, CAMERA).provenance.ids


def test_one_more_car_changes_no_other_detection() -> None:
    alone = crowd(20, 50)
    everyone = Sightings.concatenate([alone, sightings_of([999] * 50, np.arange(50))])
    everyone = everyone.select(np.argsort(everyone.frames, kind="stable"))
    detector = Detector(replace(ALONE, merges=None))
    few, many = (detector.sense(each, 9, CAMERA, STEP) for each in (alone, everyone))
    for source in ("object", "duplicate"):
        found = {key: row for key, row in rows(many, source).items() if key[1] != 999}
        assert found == rows(few, source)


def test_a_dropped_frame_changes_no_other_frame() -> None:
    whole = crowd(20, 50)
    holey = whole.select(whole.frames != 17)
    detector = Detector(LOUD)
    a, b = (detector.sense(each, 9, CAMERA, STEP, np.arange(50)) for each in (whole, holey))
    assert {k: v for k, v in rows(a).items() if k[0] != 17} == rows(b)


@pytest.mark.parametrize("name", ["jitter", "scores", "duplicates", "clutter"])
def test_switching_one_effect_off_leaves_all_others_as_they_are(name) -> None:
    sightings = crowd(20, 50)
    full, less = (
        Detector(profile).sense(sightings, 3, CAMERA, STEP)
        for profile in (UNCOUPLED, replace(UNCOUPLED, **{name: None}))
    )
    box, score = slice(0, 4), 4
    for source in ("object", "duplicate", "clutter"):
        before, after = rows(full, source), rows(less, source)
        if (name, source) in (("duplicates", "duplicate"), ("clutter", "clutter")):
            assert not after
            continue
        assert before.keys() == after.keys()
        for key, row in before.items():
            if name != "jitter" or source == "clutter":  # second boxes lie beside the first
                assert row[box] == after[key][box]
            if name != "scores" or source != "object":
                assert row[score] == after[key][score]


def test_boxes_go_by_scores_with_all_of_their_noise_at_every_level_of_it() -> None:
    detector = Detector(replace(ALONE, duplicates=None, clutter=None, border=None))
    sightings = crowd(20, 50)
    whole = rows(detector.sense(sightings, 3, CAMERA, STEP))
    exact = rows(replace(detector, score_noise=0.0).sense(sightings, 3, CAMERA, STEP))
    assert {key: row[:4] for key, row in exact.items()} == {
        key: row[:4] for key, row in whole.items()
    }
    assert {row[4] for row in exact.values()} == {1.0}
    other = rows(Detector(replace(detector.effects, scores=None)).sense(sightings, 3, CAMERA, STEP))
    assert any(other[key][:4] != row[:4] for key, row in whole.items())


def test_a_live_step_gives_the_bits_of_the_whole_drive() -> None:
    sightings = crowd(10, 40)
    detector = Detector(LOUD)
    whole = detector.sense(sightings, 3, CAMERA, STEP, np.arange(40))
    for frame in (0, 7, 33):
        now = sightings.select(sightings.frames == frame)
        live = detector.sense(now, 3, CAMERA, STEP, np.array([frame]))
        assert live.log.detections.boxes.tobytes() == whole.log.at(frame).boxes.tobytes()
        assert live.log.detections.scores.tobytes() == whole.log.at(frame).scores.tobytes()


def test_the_seed_decides() -> None:
    sightings = crowd(10, 20)
    first, again, other = (Detector().sense(sightings, seed, CAMERA) for seed in (1, 1, 2))
    assert first.log.detections.boxes.tobytes() == again.log.detections.boxes.tobytes()
    assert first.log.detections.boxes.tobytes() != other.log.detections.boxes.tobytes()


def test_every_detection_knows_where_it_came_from() -> None:
    sensed = Detector(LOUD, clutter=3.0).sense(crowd(10, 100), 1, CAMERA)
    origin = sensed.provenance
    assert len(origin) == len(sensed.log.frames)
    assert set(origin.sources.tolist()) == {"object", "duplicate", "clutter"}
    assert (origin.ids[origin.sources == "clutter"] == -1).all()
    assert (origin.ids[origin.sources != "clutter"] >= 0).all()
    assert (np.diff(sensed.log.frames) >= 0).all()


def test_boxes_stay_in_the_image_and_cues_of_ghosts_are_unknown() -> None:
    detector = Detector(replace(LOUD, pose=Pose(0.1)), jitter=3.0)
    sensed = detector.sense(crowd(10, 100, height=300.0), 1, CAMERA)
    found = sensed.log.detections
    assert (found.boxes >= 0.0).all()
    assert (found.boxes <= CAMERA.far_corner).all()
    assert found.yaw is not None
    shown = np.isin(sensed.provenance.sources, ("object", "duplicate"))
    assert (np.isnan(found.yaw) == ~shown).all()


def test_labels_of_a_drive_are_seen_by_the_same_chain() -> None:
    labels = Tracks(
        np.array([0, 0, 0, 1]),
        np.array([4, -1, 2, 5]),
        np.tile([100.0, 150.0, 200.0, 220.0], (4, 1)),
        kinds=np.array(["Car", "DontCare", "Pedestrian", "Van"]),
        truncation=np.array([1, -1, 0, 0]),
        occlusion=np.array([2, -1, 0, 0]),
    )
    sightings = Sightings.from_labels(labels)
    assert sightings.ids.tolist() == [4, 5]
    assert sightings.visible.tolist() == [0.35, 0.95]
    assert sightings.truncation.tolist() == [0.2, 0.0]
    assert np.isnan(sightings.depth).all()
    log = Detector("perfect").sense(sightings, 0, CAMERA).log
    assert log.detections.boxes.tolist() == labels.boxes[[0, 3]].tolist()


def test_a_label_whose_level_changes_passes_through_what_lies_between() -> None:
    count = 30
    labels = Tracks(
        np.arange(count),
        np.full(count, 3),
        np.tile([100.0, 150.0, 200.0, 220.0], (count, 1)),
        kinds=np.full(count, "Car"),
        truncation=(np.arange(count) >= 20).astype(np.int64),
        occlusion=(np.arange(count) >= 10).astype(np.int64),
    )
    sightings = Sightings.from_labels(labels)
    assert (sightings.visible[:6] == 0.95).all()
    assert (sightings.visible[14:] == 0.65).all()
    assert (np.diff(sightings.visible[5:15]) < 0.0).all()
    assert sightings.visible[9] == pytest.approx((5 * 0.95 + 4 * 0.65) / 9)
    assert (
        sightings.truncation[:20] == 0.0
    ).all()  # the border is where the box ends: no score_shift there
    assert (np.diff(sightings.truncation[19:25]) > 0.0).all()


def test_no_cars_no_detections() -> None:
    nobody = sightings_of([], [])
    assert len(Detector().sense(nobody, 0, CAMERA).log.frames) == 0
    false_alarms = Detector(LOUD).sense(nobody, 0, CAMERA, STEP, np.arange(100))
    assert (false_alarms.provenance.sources == "clutter").all()


def test_bad_levels_and_names_are_refused() -> None:
    with pytest.raises(BadConfig, match=r"0 \(none\) or more"):
        Detector(jitter=-1.0)
    with pytest.raises(UnknownName, match="Did you mean 'pointrcnn'"):
        Detector("pointrccn")
