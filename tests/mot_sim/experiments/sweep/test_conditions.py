"""What a trial is run under, and that everything of it can be an axis."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.experiments.sweep.conditions import Conditions, Mount
from mot_sim.files.fingerprint import digest
from mot_sim.simulation.rig import Rig
from tracker.errors import BadCalibration, BadConfig, UnknownName


def plain(**axes: float | str) -> Conditions:
    return Conditions.of("crossing", {name.replace("__", "."): axes[name] for name in axes})


def test_every_number_among_the_axes_can_be_set_to_the_value_that_it_has() -> None:
    conditions = Conditions.of("crossing", {})
    axes = conditions.axes()
    assert len(axes) > 300
    numbered = [axis for axis in axes if axis[-1].isdecimal()]
    for axis in sorted({*axes} - {*numbered[1:]})[::5] + numbered[:1]:
        assert conditions.with_level(axis, axes[axis]).axes() == axes, axis


@pytest.mark.parametrize(
    "axis",
    ["scene.frames", "rig.height", "rig.height_error", "detector.clutter", "odometry.drift",
     "timing.drops", "miscalibration.pitch", "misses.by_height.3", "jitter.left.spread"],
)  # fmt: skip
def test_an_axis_changes_itself_alone_and_the_name_of_the_trial(axis: str) -> None:
    before = Conditions.of("crossing", {})
    level = 7 if axis == "scene.frames" else 0.125
    after = before.with_level(axis, level)
    assert after.axes() == {**before.axes(), axis: level}
    assert digest(after.description()) != digest(before.description())


def test_a_level_that_is_the_own_value_is_the_same_trial() -> None:
    assert digest(plain(detector__jitter=1).description()) == digest(plain().description())


def test_what_only_trackers_see_shares_the_truth() -> None:
    before = plain()
    for axis in ("detector.misses", "odometry.scale", "rig.pitch_error_deg", "timing.drops"):
        assert before.with_level(axis, 0.25).truth() == before.truth()
    assert before.with_level("scene.profile", "subcnn").truth() == before.truth()
    higher = before.with_level("rig.height", 2.0)
    assert higher.truth() != before.truth()
    assert higher.traffic() == before.traffic()
    assert before.with_level("scene.frames", 7).traffic() != before.traffic()


def test_less_confidence_brings_scores_near_a_half_in_their_order() -> None:
    scores = np.array([0.0, 0.3, 0.5, 0.9, 1.0])
    assert plain().seen_scores(scores).tolist() == scores.tolist()
    seen = plain(detector__confidence=0.1).seen_scores(scores)
    assert (np.diff(seen) > 0.0).all()
    np.testing.assert_allclose(seen[1:4], [0.47883, 0.5, 0.55471], atol=1e-5)  # 9**0.1 = 1.2457
    assert plain(detector__confidence=0.0).seen_scores(scores).tolist() == [0.5] * 5
    with pytest.raises(BadConfig, match=r"detector\.confidence -1: give a number"):
        plain(detector__confidence=-1.0)


def test_the_believed_camera_is_the_true_one_but_for_its_errors() -> None:
    mount = Mount(height=2.0, pitch_deg=3.0)
    np.testing.assert_array_equal(mount.believed.T_cam_road, mount.rig.camera.T_cam_road)
    wrong = replace(mount, pitch_error_deg=1.0, height_error=-0.5)
    right = Rig.kitti(1.5, np.radians(4.0)).camera
    np.testing.assert_allclose(wrong.believed.T_cam_road, right.T_cam_road, atol=1e-12)
    np.testing.assert_array_equal(wrong.rig.camera.T_cam_road, mount.rig.camera.T_cam_road)


@pytest.mark.parametrize(("rate", "every"), [(10.0, 1), (5.0, 2), (3.333, 3), (2.5, 4), (1.0, 10)])
def test_a_frame_rate_delivers_every_so_many_frames(rate: float, every: int) -> None:
    conditions = plain(rig__frame_rate=rate)
    assert conditions.frames(11).tolist() == list(range(0, 11, every))


@pytest.mark.parametrize(
    ("axis", "level", "error", "told"),
    [
        ("scene.carz", 1, UnknownName, "known: scene."),
        ("detector.jiter", 1, UnknownName, "Did you mean 'detector.jitter'"),
        ("jitter.left.spred", 1, UnknownName, "Did you mean 'jitter.left.spread'"),
        ("detector.jitter", "much", BadConfig, "give a number"),
        ("detector.jitter", -1, BadConfig, "level of noise"),
        ("detector.weather", "hail", UnknownName, "unknown weather 'hail'"),
        ("scene.frames", 1.5, BadConfig, "give a whole number"),
        ("scene.profile", "rrk", UnknownName, "Did you mean 'rrc'"),
        ("rig.frame_rate", 7, BadConfig, "10 Hz over a whole number"),
        ("rig.frame_rate", 20, BadConfig, "10 Hz over a whole number"),
        ("rig.frame_rate", 0, BadConfig, "10 Hz over a whole number"),
        ("rig.height_error", -2, BadCalibration, "above the road"),
        ("timing.drops", 2, BadConfig, "timing drops"),
        ("scene.weather", "fog", BadConfig, "only pictures.*detector.weather = fog"),
        ("scene.camera_look", "plain", BadConfig, "only pictures.*camera_look=plain"),
        ("scene.fog", 80, BadConfig, "only pictures.*detector.fog = 80"),
        ("scene.sun_elevation", 20, BadConfig, "only pictures.*sun_elevation=20"),
        ("detector.fog", 3, BadConfig, "fog = 3: give 10 to 20000 metres of visibility"),
        ("detector.rain", -1, BadConfig, "rain = -1: give 0.1 to 150 mm/h"),
    ],
)
def test_an_axis_or_level_that_cannot_be_is_named(
    axis: str, level: float | str, error: type[Exception], told: str
) -> None:
    with pytest.raises(error, match=told):
        Conditions.of("crossing", {axis: level})


def test_an_effect_that_the_profile_lacks_is_made_or_asked_for() -> None:
    perfect = {"scene.profile": "perfect"}
    made = Conditions.of("crossing", {"jitter.left.spread": 0.1, **perfect})
    assert made.effects.jitter is not None
    assert made.effects.jitter.left.spread == 0.1
    assert made.effects.jitter.upper.spread == 0.0
    with pytest.raises(BadConfig, match="profile perfect has no misses"):
        Conditions.of("crossing", {"misses.base": 1.0, **perfect})
