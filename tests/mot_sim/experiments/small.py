"""Small sweeps for the tests: an open road, few frames."""

from pathlib import Path
from typing import Any

import pyarrow as pa

from mot_sim.experiments.sweep import Design
from mot_sim.experiments.sweep.running import sweep

BARE = {"scene.houses": 0.0, "scene.trees": 0.0, "scene.furniture": 0.0}


def small_design(**changes: Any) -> Design:
    """Three levels of jitter on an open crossing, two trackers, two seeds, six frames."""
    given: dict[str, Any] = {
        "axes": {"detector.jitter": (0.0, 1.0, 3.0)}, "scene": "crossing", "seeds": 2,
        "frames": 6, "fixed": BARE,
    }  # fmt: skip
    return Design(**{**given, **changes})


def numbers(table: pa.Table) -> pa.Table:
    """All of a table that must be equal to the last bit."""
    return table.drop_columns(["cpu_seconds"])


def trial_files(folder: Path) -> list[Path]:
    """The finished trials of a sweep's folder."""
    return sorted((folder / "trials").glob("*/*.json"))


def sweep_until_killed(folder: str, seeds: int) -> None:
    """A sweep of many trials, in a process that somebody is going to kill."""
    levels = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0)
    sweep(small_design(axes={"detector.jitter": levels}, seeds=seeds), folder)
