"""Things by name: ours, of installed packages, and `module:name`."""

import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

import scenes
from mot_sim.experiments.stress.suites import Suite, find_suites, read_suites, suite_names
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import truth_key
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec, tracker_specs_of
from mot_sim.files.fingerprint import digest, source_digest
from mot_sim.files.named_objects import (
    ASSOCIATION_NAMES,
    COST_NAMES,
    TRACKER_NAMES,
    importable,
    make_tracker,
)
from mot_sim.simulation.registry import SCENE_NAMES, find_scene, knobs_of
from mot_sim.simulation.renderers import find_renderer
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.sensors import find_profile
from tests.mot_sim.own_things import FILES, write_own_things, write_package
from tracker import Tracker
from tracker.costs import Cost
from tracker.errors import BadConfig, UnknownName

CAMERA = Rig.kitti().camera


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working folder with things of a user's own, which Python looks in last."""
    monkeypatch.chdir(write_own_things(tmp_path))
    with importable(str(tmp_path)):
        yield tmp_path
    for name in FILES:
        module = sys.modules.get(name.removesuffix(".py"))
        if module is not None and str(module.__file__).startswith(str(tmp_path)):
            del sys.modules[module.__name__]


def installed(
    place: Path, monkeypatch: pytest.MonkeyPatch, name: str, points: dict[str, dict[str, str]]
) -> None:
    """A package that registers these entry points, on Python's path."""
    write_package(place / name, name, points)
    monkeypatch.syspath_prepend(str(place / name))


def test_a_scene_of_ones_own_is_found_with_its_knobs(place: Path) -> None:
    scene = find_scene("mine:my_scene", speed=18, frames=5, weather="rain")
    assert (scene.name, scene.frame_count) == ("mine:my_scene", 5)
    assert scene.knobs["speed"] == 18.0
    assert knobs_of("mine:my_scene")["frames"] == 12
    assert SCENE_NAMES.source("mine:my_scene") == source_digest("mine")
    assert SCENE_NAMES.source("crossing") is None


def test_costs_trackers_associations_and_suites_of_ones_own_are_found(place: Path) -> None:
    assert isinstance(COST_NAMES.make("mine:MyCost", Cost), Cost)
    assert make_tracker("mine:forgetful", CAMERA, Tracker).lifecycle.max_gap == 0.5
    made = make_tracker("default", CAMERA)
    assert ASSOCIATION_NAMES.make("mine:greedy", Tracker, made).associate != made.associate
    known = read_suites()
    (suite,) = find_suites(["mine:MY_SUITE"], known)
    assert suite.scene == "mine:my_scene"
    assert [each.name for each in find_suites([], known)] == list(known)


def test_a_name_may_lead_into_a_class(place: Path) -> None:
    name = "mot_sim.simulation.renderers.raster:RasterRenderer"
    assert type(find_renderer(name)).__name__ == "RasterRenderer"
    assert make_tracker("tracker:Tracker.paper", CAMERA, Tracker) == Tracker.paper(CAMERA)


def test_settings_with_colons_are_put_together(place: Path) -> None:
    text = "default:costs=image_overlap=0.8+mine:MyCost=0.2:associate=mine:greedy:sigmas=2"
    spec = TrackerSpec.parse(f"a={text}")
    assert spec.settings == {
        "costs": "image_overlap=0.8+mine:MyCost=0.2", "associate": "mine:greedy", "sigmas": 2,
    }  # fmt: skip
    built = spec.build(CAMERA)
    assert [weight for weight, _ in built.costs] == [0.8, 0.2]
    assert TrackerSpec.parse("default:costs=volume:sigmas=2").settings["sigmas"] == 2
    alone = TrackerSpec.parse("default:costs=mine:MyCost:sigmas=2")
    assert alone.settings == {"costs": "mine:MyCost", "sigmas": 2}


def test_what_decides_a_trial_holds_the_source_of_scene_cost_and_tracker(place: Path) -> None:
    def keys() -> tuple[str, str, str]:
        conditions = Conditions.of("mine:my_scene", {"scene.frames": 5})
        costs = TrackerSpec.parse("default:costs=mine:MyCost").description()
        mine = TrackerSpec.parse("mine:forgetful").description()
        return truth_key(conditions, 0), digest(costs), digest(mine)

    before = keys()
    assert keys() == before
    (place / "mine.py").write_text(FILES["mine.py"] + "\n# another\n")
    assert all(new != old for new, old in zip(keys(), before, strict=True))


BROKEN = {
    "nowhere:f": "No module named 'nowhere'; looked in the working folder {here}, PYTHONPATH",
    "mime:my_scene": "Did you mean 'mine'?",
    "mine.inner:f": "No module named 'mine.inner'; 'mine' is not a package",
    "mine:my_scen": "there is no callable 'my_scen' in mine; it has .*Did you mean 'my_scene'?",
    "divides:f": "module divides raises at import: ZeroDivisionError: .*(divides.py:2)",
    "syntax:f": "module syntax raises at import: SyntaxError: invalid syntax (syntax.py:2)",
    "lacks:f": "raises at import: ModuleNotFoundError: .*'no_such_library' (lacks.py:1)",
    "ends:f": "module ends raises at import: SystemExit: 3 (ends.py:1)",
    "bad:N": "scene 'bad:N' is no function: 5 is not a callable",
    "bad:gives_none": "scene 'bad:gives_none' gives a NoneType, no Scene",
    "bad:raises": "cannot be built: ValueError: no cars (bad.py:9)",
    "bad:needs": "argument speed cannot be a knob: give it a default",
    "bad:weathered": "argument weather is a knob that all scenes have",
    "scenes:my_scene": "scenes.py of the working folder is hidden by another module 'scenes'",
    ":f": "is not written as MODULE:NAME",
    "mine:": "is not written as MODULE:NAME",
    "mine:a:b": "is not written as MODULE:NAME",
    "mine:my-scene": "is not written as MODULE:NAME",
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_scene_that_cannot_be_had_is_named_in_one_line(place: Path, name: str) -> None:
    with pytest.raises(BadConfig) as told:
        find_scene(name)
    words = BROKEN[name].format(here=place).split(".*")
    assert str(told.value).startswith(f"scene {name!r}")
    assert "\n" not in str(told.value)
    for word in words:
        assert word in str(told.value)


def test_costs_suites_and_profiles_that_are_none_are_named(place: Path) -> None:
    for name, told in {
        "bad:Takes": "cannot be built: TypeError: missing a required",
        "bad:NoCost": "cost 'bad:NoCost' gives a NoCost, no Cost",
        "bad:N": "cost 'bad:N' is a int, no callable",
    }.items():
        with pytest.raises(BadConfig, match=told):
            COST_NAMES.make(name, Cost)
    for name, told in {
        "bad:N": "suite 'bad:N' is a int, no suite",
        "bad:gives_none": "gives a NoneType, no Suite",
        "mine:MY_SUIT": "there is no suite 'MY_SUIT' in mine.*Did you mean 'MY_SUITE'",
    }.items():
        with pytest.raises(BadConfig, match=told):
            find_suites([name], {})
    with pytest.raises(BadConfig, match="profile 'bad:gives_none' gives a NoneType, no Profile"):
        find_profile("bad:gives_none")
    with pytest.raises(BadConfig, match="renderer 'bad:NoCost' gives a NoCost, no Renderer"):
        find_renderer("bad:NoCost")
    with pytest.raises(BadConfig, match="scene 'bad:timeless' has no knob frames"):
        Conditions.of("bad:timeless", {"scene.frames": 4})


def test_a_module_that_hides_another_is_only_refused_under_its_own_name(place: Path) -> None:
    assert isinstance(find_scene("crossing"), Scene)
    with pytest.raises(BadConfig, match=r"give yours another name"):
        tracker_specs_of(["mine=scenes:my_scene"])[0].check()


def test_packages_register_scenes_costs_suites_and_trackers(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = {
        "mot_sim.scenes": {"overtaking": "mine:my_scene"},
        "mot_sim.costs": {"height": "mine:MyCost"},
        "mot_sim.suites": {"overtaken": "mine:MY_SUITE"},
        "mot_sim.trackers": {"numbers": "mine:Numbers [extra]"},
    }
    installed(place, monkeypatch, "their-things", points)
    assert find_scene("overtaking", frames=3).name == "overtaking"
    assert Conditions.of("overtaking", {}).traffic()["source"] == source_digest("mine")
    assert TrackerSpec.parse("default:costs=height").build(CAMERA)
    assert find_suites(["overtaken"], {})[0].scene == "mine:my_scene"
    (spec,) = tracker_specs_of(["numbers"])
    spec.check()
    assert spec.description()["source"] == source_digest("mine")
    assert {"overtaking", "crossing"} <= set(SCENE_NAMES.names())
    assert suite_names({}).broken() == {}
    with pytest.raises(UnknownName, match=r"known: .*overtaking.*Did you mean 'overtaking'"):
        find_scene("overtakin")


def test_a_broken_entry_point_is_named_and_the_others_work(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = {
        "good": "mine:my_scene", "gone": "no.such:thing", "divides": "divides:f",
        "strange": "mine my_scene", "crossing": "mine:my_scene", "twice": "mine:my_scene",
    }  # fmt: skip
    installed(place, monkeypatch, "their-scenes", {"mot_sim.scenes": points})
    installed(place, monkeypatch, "others", {"mot_sim.scenes": {"twice": "mine:my_scene"}})
    assert isinstance(find_scene("good"), Scene)
    broken = SCENE_NAMES.broken()
    assert sorted(broken) == ["crossing", "divides", "gone", "strange", "twice"]
    prefix = "scene 'gone' of package their-scenes 1.0 (mot_sim.scenes): No module named 'no'"
    assert broken["gone"].startswith(prefix)
    assert "raises at import: ZeroDivisionError" in broken["divides"]
    assert "is not written as MODULE:NAME" in broken["strange"]
    assert "we have one already" in broken["crossing"]
    assert "registered by package " in broken["twice"]
    assert "their-scenes 1.0" in broken["twice"]
    assert "others 1.0" in broken["twice"]
    assert find_scene("crossing").make_traffic.__module__ == "scenes.crossing"


def test_python_looks_in_a_folder_only_while_it_is_asked_to(tmp_path: Path) -> None:
    (tmp_path / "only_here.py").write_text("N = 5\n")
    (tmp_path / "scenes.py").write_text("N = 6\n")
    before, finders = [*sys.path], [*sys.meta_path]
    assert find_spec("only_here") is None
    with importable(str(tmp_path)):
        with importable(str(tmp_path)):
            assert find_spec("only_here") is not None
        found = find_spec("only_here")
        assert found is not None
        assert found.origin == str(tmp_path / "only_here.py")
        ours = find_spec("scenes")
        assert ours is not None
        assert ours.origin == scenes.__file__  # nobody's own module hides ours
    assert find_spec("only_here") is None
    assert (sys.path, sys.meta_path) == (before, finders)


def test_names_are_listed_without_loading_anything() -> None:
    assert isinstance(TRACKER_NAMES.names(), list)
    assert "default" in TRACKER_NAMES
    assert "anything:at.all" in TRACKER_NAMES
    assert "nobody" not in TRACKER_NAMES
    assert isinstance(read_suites()["fog"], Suite)
