"""A Dask cluster on this machine: the same table, also when workers and scheduler are killed."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from mot_sim.experiments import executor
from mot_sim.experiments.sweep import Design
from mot_sim.experiments.sweep.running import sweep
from mot_sim.files.named_objects import importable
from tests.mot_sim.experiments.small import numbers, small_design, trial_files
from tests.mot_sim.own_things import write_own_things
from tracker.errors import WorkersLost

ROOT = Path(__file__).parents[4]
LEVELS = {"axes": {"detector.jitter": (0.0, 0.5, 1.0, 2.0)}, "seeds": 3}
MORE = {"axes": {"detector.jitter": (0.0, 0.5, 1.0, 2.0, 3.0, 4.0)}, "seeds": 3}
NOBODY = "tcp://127.0.0.1:9"


@contextmanager
def started(module: str, *options: str) -> Iterator[subprocess.Popen]:
    """A process of Dask, killed in the end."""
    environment = os.environ | {"PYTHONPATH": str(ROOT), "DASK_DISTRIBUTED__LOGGING": "{}"}
    process = subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.{module}", *options, "--no-dashboard"],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@contextmanager
def scheduler(folder: Path) -> Iterator[tuple[str, subprocess.Popen]]:
    """A scheduler on loopback, and its address."""
    file = folder / "scheduler.json"
    options = ("--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))
    with started("dask_scheduler", *options) as process:
        deadline = time.monotonic() + 120.0
        while not file.is_file() or not file.read_text().endswith("}"):
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.05)
        yield json.loads(file.read_text())["address"], process


def worker(address: str, number: int) -> "contextmanager":
    options = ("--nthreads", "1", "--no-nanny", "--name", f"w{number}")
    return started("dask_worker", address, *options)


def after(trials: int, do: Callable[[], None]) -> Callable[[str, int, int], None]:
    """A progress that does something once, when so many trials are finished."""
    done = []

    def progress(what: str, number: int, total: int) -> None:
        if what == "trials" and number >= trials and not done:
            done.append(number)
            do()

    return progress


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_gives_the_table_of_one_process(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    design = small_design(**LEVELS)
    alone = sweep(design, tmp_path / "alone")
    with (
        scheduler(tmp_path) as (address, dying_scheduler),
        worker(address, 0) as first,
        worker(address, 1),
    ):
        progress = after(8, first.kill)
        table = sweep(design, tmp_path / "many", scheduler=address, progress=progress)
        assert first.wait(10.0) != 0
        assert numbers(table).equals(numbers(alone))
        assert len(trial_files(tmp_path / "many")) == len(design)
        # The scheduler goes away before the last third: an error that says so, nothing is lost.
        more = small_design(**MORE)
        progress = after(len(design), dying_scheduler.kill)
        with pytest.raises(WorkersLost, match=r"finished trials are kept"):
            sweep(more, tmp_path / "many", scheduler=address, progress=progress, extend=True)
    there = {path: path.stat().st_mtime_ns for path in trial_files(tmp_path / "many")}
    assert len(design) <= len(there) < len(more)
    assert numbers(sweep(design, tmp_path / "many", extend=True)).equals(numbers(alone))
    assert all(path.stat().st_mtime_ns == then for path, then in there.items())


@pytest.mark.slow
def test_a_cluster_without_any_worker_left_is_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr(executor, "IDLE_TIMEOUT", 2.0)
    with (
        scheduler(tmp_path) as (address, _),
        pytest.raises(WorkersLost, match=r"workers are gone: .* no worker"),
    ):
        sweep(small_design(), tmp_path / "out", scheduler=address)


def test_a_scheduler_that_does_not_answer_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr(executor, "CONNECT_TIMEOUT", 0.5)
    with pytest.raises(WorkersLost, match=r"no Dask scheduler at tcp://127\.0\.0\.1:9: "):
        sweep(small_design(), tmp_path, scheduler=NOBODY)
    with pytest.raises(WorkersLost, match=r"no Dask scheduler at nonsense://x: "):
        sweep(small_design(), tmp_path, scheduler="nonsense://x")


def test_dask_that_is_not_installed_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(WorkersLost, match=r"pip install 'mot-sim\[scale\]'"):
        sweep(small_design(), tmp_path, scheduler=NOBODY)


@pytest.mark.slow
def test_workers_elsewhere_find_the_modules_of_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    write_own_things(tmp_path)
    with scheduler(tmp_path) as (address, _), worker(address, 0), importable(str(tmp_path)):
        monkeypatch.chdir(tmp_path)
        design = Design(
            {"scene.speed": (10.0,)}, ("m=mine:Numbers",), "mine:my_scene", seeds=1, frames=5
        )
        table = sweep(design, tmp_path / "out", scheduler=address)
    sys.modules.pop("mine")
    assert table["error"].to_pylist() == [None]
