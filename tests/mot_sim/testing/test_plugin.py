"""The pytest plugin: its fixtures, its cache, and that it costs a start of pytest nothing."""

from pathlib import Path

import pytest

import mot_sim.testing  # noqa: F401  (imported here, so that inner runs need not)
from tests.mot_sim.test_imports import modules_after

pytest_plugins = ["pytester"]

ROOT = Path(__file__).parents[3]
TESTS = """
from tracker import Tracker

BARE = dict(houses=0.0, trees=0.0, furniture=0.0, frames=6)

def test_good(mot_episode, assert_tracks):
    episode = mot_episode("crossing", seed=3, profile="perfect", **BARE)
    assert_tracks(Tracker.default, episode, mota=0.1, idsw=5)

def test_bad(mot_episode, assert_tracks):
    episode = mot_episode("crossing", seed=3, profile="perfect", **BARE)
    assert_tracks(Tracker.default, episode, fn=-1)
"""


def test_fixtures_work_fail_loudly_and_record_once(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(TESTS)
    first = pytester.runpytest_inprocess("-p", "mot_sim_pytest", "-p", "no:xdist")
    first.assert_outcomes(passed=1, failed=1)
    shown = first.stdout.str()
    assert "must be at most -1" in shown
    assert "crossing, seed 3, profile=perfect" in shown
    assert "_mistaken" not in shown  # the traceback ends in the test
    files = sorted(pytester.path.glob(".pytest_cache/d/mot-sim/truth/*.npz"))
    assert len(files) == 1
    before = files[0].stat().st_mtime_ns
    again = pytester.runpytest_inprocess("-p", "mot_sim_pytest", "-p", "no:xdist")
    again.assert_outcomes(passed=1, failed=1)
    assert files[0].stat().st_mtime_ns == before


def test_without_pytests_cache_nothing_stays(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(TESTS)
    options = ("-p", "mot_sim_pytest", "-p", "no:cacheprovider", "-p", "no:xdist", "-k", "good")
    pytester.runpytest_inprocess(*options).assert_outcomes(passed=1, deselected=1)
    assert not (pytester.path / ".pytest_cache").exists()


def test_loading_the_plugin_imports_none_of_our_packages() -> None:
    loaded = modules_after(f"import sys; sys.path.insert(0, {str(ROOT)!r}); import mot_sim_pytest")
    assert loaded.isdisjoint({"mot_sim", "tracker", "scenes", "gymnasium", "numpy", "cv2", "scipy"})
    assert "mot_sim_pytest" in loaded
