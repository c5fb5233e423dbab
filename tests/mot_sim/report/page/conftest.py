"""One page of a result of every kind, for all tests that only look."""

from pathlib import Path

import pytest

from mot_sim.report.page import write_report
from tests.mot_sim.report.page.made import write_every


@pytest.fixture(scope="package")
def every(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page."""
    home = tmp_path_factory.mktemp("every")
    return write_report(write_every(home), home / "report.html").path
