"""Designs: what they run, and every way in which one cannot be."""

from pathlib import Path
from typing import Any

import pytest

from mot_sim.experiments.sweep import Design, Range, TrackerSpec, read_design
from tests.mot_sim.experiments.small import BARE
from tracker.errors import BadConfig, BadFile, TrackingError, UnknownName


def make(**changes: Any) -> Design:
    given = {"axes": {"detector.jitter": (0.0, 1.0)}, "scene": "crossing", "seeds": 3}
    return Design(**{**given, **changes})


def test_a_design_counts_points_seeds_and_trackers() -> None:
    design = make(axes={"detector.jitter": (0.0, 1.0), "tracker.sigmas": (1.0, 2.0, 3.0)})
    assert len(design.points) == 6
    assert len(design) == 6 * 3 * 2
    assert list(make(first_seed=5).seed_numbers) == [5, 6, 7]


def test_an_axis_of_the_trackers_reaches_them_and_nothing_else() -> None:
    design = make(axes={"tracker.lifecycle.max_gap": (0.0, 2.0)})
    assert [rival.settings for rival in design.rivals(design.points[1])] == [
        {"lifecycle.max_gap": 2.0}
    ] * 2
    first, second = design.conditions
    assert first.axes() == second.axes()


def test_whole_numbers_are_drawn_for_axes_that_want_them() -> None:
    design = make(axes={"scene.frames": Range(4.0, 40.0)}, mode="random", samples=4)
    assert [type(point["scene.frames"]) for point in design.points] == [int] * 4


@pytest.mark.parametrize(
    ("changes", "error", "told"),
    [
        ({"axes": {}}, BadConfig, "empty design"),
        ({"axes": {"detector.jitter": ()}}, BadConfig, "has no levels"),
        ({"axes": {"detector.jitter": (1.0, 1.0)}}, BadConfig, "a level twice"),
        ({"axes": {"detector.jitter": "012"}}, BadConfig, "has no levels"),
        ({"axes": {"detector.jitter": (1.0, "x")}}, BadConfig, "give a number"),
        ({"axes": {"detector.jitta": (1.0,)}}, UnknownName, "Did you mean 'detector.jitter'"),
        ({"axes": {"tracker.sigmaz": (1.0,)}}, UnknownName, "Did you mean 'tracker.sigmas'"),
        ({"axes": {"tracker.associate": ("greedi",)}}, UnknownName, "Did you mean 'greedy'"),
        ({"axes": {"detector.jitter": Range(0.0, 1.0)}}, BadConfig, "is a range"),
        ({"mode": "random"}, BadConfig, "needs samples"),
        ({"samples": 3}, BadConfig, "needs samples"),
        ({"mode": "gird"}, UnknownName, "Did you mean 'grid'"),
        ({"scene": "crosing"}, UnknownName, "Did you mean 'crossing'"),
        ({"rules": "kitti"}, UnknownName, "rules"),
        ({"seeds": 0}, BadConfig, "0 seeds"),
        ({"frames": 0}, BadConfig, "0 frames"),
        ({"trackers": ()}, BadConfig, "no trackers"),
        ({"trackers": ("defalt",)}, UnknownName, "Did you mean 'default'"),
        ({"fixed": {"detector.jitter": 1.0}}, BadConfig, "an axis and fixed"),
        ({"fixed": {"rig.hight": 1.0}}, UnknownName, "Did you mean 'rig.height'"),
        (
            {
                "axes": {"tracker.sigmas": (1.0,)},
                "trackers": ("m=tests.mot_sim.experiments.odd:built",),
            },
            BadConfig,
            "none of ours",
        ),
    ],
)
def test_a_design_that_cannot_be_is_refused_at_once(
    changes: dict[str, Any], error: type[TrackingError], told: str
) -> None:
    with pytest.raises(error, match=told):
        make(**changes)


DESIGN = """
scene = "crossing"
seeds = 4
trackers = {a = {made_by = "paper", sigmas = 2}, default = {}}
[fixed]
"scene.trees" = 0
[axes]
"detector.jitter" = [0, 0.5]
"rig.height_error" = [-0.1, 0.1]
"""


def test_a_design_is_read_from_a_file_and_changed(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(DESIGN)
    design = read_design(str(path), seeds=2)
    assert design.contenders == (TrackerSpec("a", "paper", {"sigmas": 2}), TrackerSpec("default"))
    assert design.axes == {"detector.jitter": (0, 0.5), "rig.height_error": (-0.1, 0.1)}
    assert (design.scene, design.seeds, design.fixed) == ("crossing", 2, {"scene.trees": 0})
    assert len(design) == 4 * 2 * 2


@pytest.mark.parametrize(
    ("content", "error", "told"),
    [
        ("seeds = [", BadFile, "no design can be read"),
        ("seedz = 3", UnknownName, "Did you mean 'seeds'"),
        ("seeds = 'ten'", BadConfig, "give a int"),
        ("[axes]\na = 3", BadConfig, "no list of levels"),
        ("[axes]\na = {low = 1}", BadConfig, "write {low = 0, high = 1}"),
        ("axes = 3", BadConfig, "is no table"),
        ("trackers = 3", BadConfig, "is no table"),
        ("", BadConfig, "empty design"),
    ],
)
def test_a_file_that_is_no_design_is_named(
    tmp_path: Path, content: str, error: type[TrackingError], told: str
) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(content)
    with pytest.raises(error, match=told):
        read_design(str(path))


def test_the_noise_sweep_is_there_with_five_trackers_and_six_kinds_of_noise() -> None:
    design = read_design("noise", scene="crossing", fixed=BARE)
    assert len(design.axes) == 6
    assert len(design.contenders) == 5
    assert design.seeds == 20
    with pytest.raises(UnknownName, match="Did you mean 'noise'"):
        read_design("nois")
    with pytest.raises(BadFile, match=r"absent\.toml"):
        read_design("absent.toml")
