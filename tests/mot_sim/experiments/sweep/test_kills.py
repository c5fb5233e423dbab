"""A sweep that is killed again and again: no trial is lost, none is damaged, none is repeated."""

import multiprocessing
import time
from pathlib import Path

import numpy as np
import pytest

from mot_sim.experiments.sweep.running import sweep
from mot_sim.experiments.sweep.store import SweepFolder
from tests.mot_sim.experiments.small import (
    numbers,
    small_design,
    sweep_until_killed,
    trial_files,
)

KILLS, SEEDS = 10, 4


def written(folder: Path) -> dict[str, int]:
    return {path.stem: path.stat().st_mtime_ns for path in trial_files(folder)}


@pytest.mark.slow
def test_ten_kills_at_random_moments_lose_and_damage_nothing(tmp_path: Path) -> None:
    processes = multiprocessing.get_context("forkserver")
    processes.set_forkserver_preload(["mot_sim.experiments", "scenes.crossing"])
    rng = np.random.default_rng(0)
    before: dict[str, int] = {}
    finished = []
    for _ in range(KILLS):
        child = processes.Process(target=sweep_until_killed, args=(str(tmp_path), SEEDS))
        child.start()
        enough, deadline = len(before) + int(rng.integers(0, 5)), time.monotonic() + 60.0
        while len(trial_files(tmp_path)) < enough and child.is_alive():
            assert time.monotonic() < deadline
            time.sleep(0.001)
        time.sleep(float(rng.uniform(0.0, 0.05)))
        child.kill()
        child.join()
        now = written(tmp_path)
        assert before.items() <= now.items()
        assert all(SweepFolder(tmp_path).read(key) is not None for key in now)
        before = now
        finished.append(len(now))
    assert finished[-1] < 6 * SEEDS * 2  # the last kill still hit a sweep at work
    assert len(set(finished)) > 3
    levels = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0)
    design = small_design(axes={"detector.jitter": levels}, seeds=SEEDS)
    table = sweep(design, tmp_path)
    assert before.items() <= written(tmp_path).items()
    assert list(tmp_path.rglob("*.half")) == []
    small = small_design(axes={"detector.jitter": levels}, seeds=1)
    alone = numbers(sweep(small)).to_pylist()
    assert [row for row in numbers(table).to_pylist() if row["seed"] == 0] == alone
