"""Fixtures for the whole suite: where KITTI is, a browser, the reproducible hypothesis profile."""

import atexit
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

settings.register_profile("reproducible", derandomize=True, deadline=None, max_examples=60)
# Where shapes are checked: those of any example are those of all.
settings.register_profile("few", derandomize=True, deadline=None, max_examples=10)
settings.load_profile("reproducible")

# Few tests that take long each: begun first, so that no worker is left with them at the end.
SLOW_FILES = ("test_docs.py", "test_examples.py")
# Coverage tells what the tests of the modules themselves reach. Others are whole runs through the
# same code: watching each line would make them two or three times as long, and say nothing new.
HERE = Path(__file__).parent
COVERED_FOLDERS = tuple(HERE / name for name in ("tracker", "mot_sim", "scenes"))
UNCOVERED_FILES = ("test_every_scene.py", "test_annotate.py")
MARKERS = ("kitti", "gl", "slow", "browser")  # what is counted where it does not run
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

# What the hook that checks the shapes of arrays leaves alone: numba cannot compile what it wraps.
UNHOOKED = ("tracker.kernels", "mot_sim.simulation.kernels")
# Recorded truths are shared by all workers of a run, and by no two runs.
if "MOT_SIM_CACHE" not in os.environ:
    os.environ["MOT_SIM_CACHE"] = tempfile.mkdtemp(prefix="mot-sim-truth-")
    atexit.register(shutil.rmtree, os.environ["MOT_SIM_CACHE"], ignore_errors=True)


def pytest_configure(config: pytest.Config) -> None:
    """Let the hook of jaxtyping, where it is installed, pass by the kernels."""
    for finder in sys.meta_path:
        if type(finder).__name__ == "_JaxtypingFinder":
            finder.should_instrument = hooked(finder.should_instrument)  # type: ignore[attr-defined]


def hooked(instruments: Callable[[str], bool]) -> Callable[[str], bool]:
    """The same choice of modules, without the kernels."""

    def is_hooked(module: str) -> bool:
        inside = any(f"{module}.".startswith(f"{package}.") for package in UNHOOKED)
        return instruments(module) and not inside

    return is_hooked


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--must-run MARKER`: where every one of these tests is skipped, nothing has been tested."""
    parser.addoption(
        "--must-run", choices=MARKERS, help="fail unless a test with this marker has run"
    )


def kitti_root_of_the_environment() -> Path | None:
    """The KITTI root that the user's environment names, if it names one."""
    root = os.environ.get("MOT_SIM_KITTI_ROOT")
    return Path(root) if root else None


@pytest.fixture
def kitti_root() -> Path:
    """The root of a KITTI tree (the folder that holds `training`); tests carry the marker."""
    root = kitti_root_of_the_environment()
    if root is None:
        pytest.skip("MOT_SIM_KITTI_ROOT is not set")
    return root


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """A Chromium: of $MOT_SIM_CHROMIUM, of the system, or playwright's own."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    found = [path for path in map(shutil.which, BROWSERS) if path is not None]
    path = os.environ.get("MOT_SIM_CHROMIUM") or (found[0] if found else None)
    with playwright.sync_playwright() as started:
        try:
            browser = started.chromium.launch(executable_path=path, args=["--no-sandbox"])
        except playwright.Error as error:
            told = str(error).split("\n", maxsplit=1)[0]
            pytest.skip(f"no Chromium can be started: {told}; install chromium, or name it in "
                        "MOT_SIM_CHROMIUM")  # fmt: skip
        yield browser
        browser.close()


def is_covered(path: Path) -> bool:
    """Whether the tests of a file are watched where coverage is measured."""
    inside = any(folder in path.parents for folder in COVERED_FOLDERS)
    return inside and path.name not in UNCOVERED_FILES


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Measure no coverage of whole runs, neither in their tests nor in their fixtures."""
    plugin = item.config.pluginmanager.get_plugin("_cov")
    controller = getattr(plugin, "cov_controller", None)
    if controller is None or is_covered(item.path):
        return (yield)
    controller.pause()
    try:
        return (yield)
    finally:
        controller.resume()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skip what needs a data set where there is none, and wrong types where types are checked.

    Slow files come first (`make test` keeps this order).
    """
    items.sort(key=lambda item: item.path.name not in SLOW_FILES)
    for item in items:
        for marker in MARKERS:
            if item.get_closest_marker(marker):
                item.user_properties.append(("marker", marker))
    if config.getoption("jaxtyping_packages", None):
        for item in items:
            if item.get_closest_marker("unchecked"):
                item.add_marker(pytest.mark.skip(reason="the annotations forbid what it gives"))
    if kitti_root_of_the_environment() is None:
        for item in items:
            if item.get_closest_marker("kitti"):
                item.add_marker(pytest.mark.skip(reason="MOT_SIM_KITTI_ROOT is not set"))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say aloud how many tests of each marker did not run."""
    skipped = terminalreporter.stats.get("skipped", [])
    for marker in MARKERS:
        count = sum(("marker", marker) in report.user_properties for report in skipped)
        if count:
            terminalreporter.write_line(f"{count} tests marked '{marker}' were skipped")


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail where a marker's tests had to run and all were skipped."""
    marker = session.config.getoption("must_run")
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if marker is None or reporter is None:
        return
    ran = [*reporter.stats.get("passed", []), *reporter.stats.get("failed", [])]
    if not any(("marker", marker) in report.user_properties for report in ran):
        reporter.write_line(f"\nno test marked '{marker}' has run, and one must (--must-run)")
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
