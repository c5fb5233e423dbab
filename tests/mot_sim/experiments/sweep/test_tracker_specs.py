"""Trackers side by side: ours with parameters changed, and other people's."""

import pytest

from mot_sim.experiments.sweep.tracker_specs import (
    TrackerSpec,
    tracker_settings,
    tracker_specs_of,
)
from mot_sim.files.fingerprint import digest
from mot_sim.foreign.protocol import ForeignTracker
from mot_sim.simulation.rig import Rig
from tests.mot_sim.experiments import odd
from tracker import Tracker
from tracker.association import Greedy
from tracker.errors import BadConfig, UnknownName

CAMERA = Rig.kitti().camera
ODD = "tests.mot_sim.experiments.odd"


def test_settings_are_read_and_reach_the_tracker() -> None:
    text = "slow=paper:lifecycle.max_gap=2:associate=greedy:costs=volume=0.6+reprojection=0.4"
    contender = TrackerSpec.parse(text)
    built = contender.build(CAMERA)
    assert contender.name == "slow"
    assert isinstance(built, Tracker)
    assert built.lifecycle.max_gap == 2.0
    assert isinstance(built.associate, Greedy)
    assert [weight for weight, _ in built.costs] == [0.6, 0.4]


def test_components_that_a_tracker_can_do_without_are_switched_off() -> None:
    text = "plain=default:car_filter=none:gap_rows=none:sigmas=2"
    plain = TrackerSpec.parse(text).build(CAMERA)
    default = Tracker.default(CAMERA)
    assert isinstance(plain, Tracker)
    assert (plain.car_filter, plain.gap_rows, plain.sigmas) == (None, None, 2.0)
    assert plain.existence == default.existence
    lagging = TrackerSpec.parse("default:associate=window:car_filter=none").build(CAMERA)
    assert lagging.tracker.car_filter is None
    described = [digest(TrackerSpec.parse(each).description()) for each in (text, "default")]
    assert described[0] != described[1]


def test_a_tracker_without_a_name_is_called_what_it_is() -> None:
    assert TrackerSpec.parse("default").name == "default"
    assert TrackerSpec.parse("default:sigmas=2").name == "default:sigmas=2"


def test_every_setting_of_ours_can_be_set_to_the_value_that_it_has() -> None:
    for preset in ("default", "paper"):
        known = tracker_settings(TrackerSpec(preset, preset).build(CAMERA))
        assert len(known) > 15
        again = TrackerSpec(preset, preset, known).build(CAMERA)
        assert tracker_settings(again) == known


def test_trackers_that_do_the_same_have_the_same_description() -> None:
    plain = digest(TrackerSpec.parse("default").description())
    assert digest(TrackerSpec.parse("d=default:associate=hungarian").description()) == plain
    assert digest(TrackerSpec.parse("default:associate=greedy").description()) != plain
    assert digest(TrackerSpec.parse("paper").description()) != plain


def test_a_callable_of_a_module_is_a_tracker() -> None:
    assert isinstance(TrackerSpec.parse(f"mine={ODD}:built").build(CAMERA), Tracker)
    updated = TrackerSpec.parse(f"mine={ODD}:Updates:min_score=0.5").build(CAMERA)
    assert isinstance(updated, ForeignTracker)
    assert updated.inner.min_score == 0.5
    assert isinstance(updated.inner, odd.Updates)


@pytest.mark.parametrize(
    ("text", "error", "told"),
    [
        ("defalt", UnknownName, "unknown tracker 'defalt'.*Did you mean 'default'"),
        ("default:sigmas", BadConfig, "no callable|No module named 'default'"),
        ("default:sigmas=1:sigmas=2", BadConfig, "each setting once"),
        ("default:sigmaz=1", UnknownName, "Did you mean 'sigmas'"),
        ("default:sigmas=wide", BadConfig, r"tracker.sigmas = 'wide': give a number"),
        ("default:sigmas=-1", BadConfig, "sigmas -1"),
        ("default:car_filter=1", BadConfig, "only car_filter=none.*what is inside: car_filter[.]"),
        ("paper:car_filter=none", UnknownName, "unknown setting of tracker paper"),
        ("default:car_filter=none:car_filter.switch=0.1", UnknownName, "'car_filter.switch'"),
        ("default:car_filter.x=1", UnknownName, r"known: [^ ]+, car_filter.cues.\*, "),
        ("default:lift=none", UnknownName, "unknown setting of tracker default: 'lift'"),
        ("default:costs=volum", UnknownName, "Did you mean 'volume'"),
        ("default:associate=greed", UnknownName, "Did you mean 'greedy'"),
        ("mine=nowhere.at.all:X", BadConfig, "No module named 'nowhere'"),
        (f"mine={ODD}:Absent", BadConfig, "no callable"),
        (f"mine={ODD}:NoTracker", BadConfig, "neither step"),
        (f"mine={ODD}:Updates:speed=3", BadConfig, "cannot be built.*speed"),
    ],
)
def test_a_tracker_that_cannot_be_built_is_named(
    text: str, error: type[Exception], told: str
) -> None:
    with pytest.raises(error, match=told):
        tracker_specs_of([text])[0].check()


def test_two_trackers_of_one_name_and_none_at_all_are_refused() -> None:
    with pytest.raises(BadConfig, match="two trackers are named default"):
        tracker_specs_of(["default", TrackerSpec("default", "paper")])
    with pytest.raises(BadConfig, match="no trackers"):
        tracker_specs_of([])
