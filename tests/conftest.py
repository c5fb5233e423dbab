"""Fixtures for the whole suite: where KITTI is, and the reproducible hypothesis profile."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("reproducible", derandomize=True, deadline=None, max_examples=60)
settings.load_profile("reproducible")


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


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skip what needs a data set where there is none, and wrong types where types are checked."""
    for item in items:
        for marker in ("kitti", "gl", "slow", "browser"):
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
    for marker in ("kitti", "gl", "slow", "browser"):
        count = sum(("marker", marker) in report.user_properties for report in skipped)
        if count:
            terminalreporter.write_line(f"{count} tests marked '{marker}' were skipped")
