"""One small sweep for all tests that only look."""

from pathlib import Path

import pyarrow as pa
import pytest

from mot_sim.experiments.sweep.running import sweep
from tests.mot_sim.experiments.small import small_design


@pytest.fixture(scope="package")
def swept(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, pa.Table]:
    """The folder and the table of the small design, run in this process."""
    folder = tmp_path_factory.mktemp("sweep") / "small"
    return folder, sweep(small_design(), folder)
