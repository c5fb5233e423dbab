"""What a sweep costs: 5 levels x 4 trackers x 20 seeds x 100 frames, and a million frames.

    python -m benchmarks.sweep [--seeds 20] [--frames 100] [--scene intersection]
        [--growth] [--update-baseline]

The sweep is run by one process and by two, from nothing: traffic, truth from rendered pixels,
detections, tracking, scores, files, table.
Both tables must be equal to the last bit. Machines differ and are shared: the ratio of both walls
is of one run; CPU seconds hang less on who else is there. Beside the parts stand their ratios to
the time that the trackers take, and those that were kept (see `benchmarks.baseline`). No truth is
taken from the user's cache. --growth: instead, one process with 1, 2, 4, ... seeds.
"""

import argparse
import os
import resource
import tempfile

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from collections.abc import Callable, Iterator  # noqa: E402
from contextlib import contextmanager  # noqa: E402
from dataclasses import dataclass, field, replace  # noqa: E402
from pathlib import Path  # noqa: E402
from time import perf_counter, process_time  # noqa: E402
from typing import Any  # noqa: E402
from unittest.mock import patch  # noqa: E402

import pyarrow as pa  # noqa: E402

from benchmarks.baseline import Ratios  # noqa: E402
from mot_sim.experiments.sweep import Design, trial  # noqa: E402
from mot_sim.experiments.sweep.drives import Recordings  # noqa: E402
from mot_sim.experiments.sweep.running import sweep  # noqa: E402

LEVELS = (0.0, 0.5, 1.0, 2.0, 4.0)
TRACKERS = (
    "default", "paper", "greedy=default:associate=greedy", "brief=default:lifecycle.max_gap=0",
)  # fmt: skip
MILLION = 1_000_000


@dataclass
class Clock:
    """CPU seconds by what they were spent on."""

    spent: dict[str, float] = field(default_factory=dict)

    def timed(self, what: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function, whose CPU seconds are counted."""

        def counted(*arguments: Any) -> Any:
            start = process_time()
            try:
                return function(*arguments)
            finally:
                self.spent[what] = self.spent.get(what, 0.0) + process_time() - start

        return counted


@contextmanager
def accounted() -> Iterator[Clock]:
    """While it lasts, what these parts cost in this process is counted."""
    clock = Clock()
    with (
        patch.object(Recordings, "traffic", clock.timed("traffic", Recordings.traffic)),
        patch.object(Recordings, "truth", clock.timed("truth", Recordings.truth)),
        patch.object(Recordings, "record_truth", clock.timed("truth", Recordings.record_truth)),
        patch.object(trial, "drive_of", clock.timed("detections", trial.drive_of)),
        patch.object(trial, "evaluate_sequence", clock.timed("scores", trial.evaluate_sequence)),
    ):
        yield clock


def cpu_of_all() -> float:
    """CPU seconds of this process and of its children that have ended."""
    both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in both)


def run(design: Design, folder: Path, jobs: int) -> tuple[pa.Table, float]:
    """The table and the seconds of wall time."""
    start = perf_counter()
    table = sweep(design, folder, jobs=jobs)
    return table, perf_counter() - start


def tell_parts(design: Design, table: pa.Table, clock: Clock, cpu: float, ratios: Ratios) -> None:
    """Where the CPU seconds of one process went, a trial; and what a million frames cost."""
    trials, frames = len(design), len(design) * design.frames
    spent = clock.spent | {"tracking": sum(table["cpu_seconds"].to_pylist())}
    spent["truth"] -= spent["traffic"]  # which is recorded where truth first asks for it
    spent["all the rest"] = cpu - sum(spent.values())
    print(f"\n{'one process':14s} CPU s   ms a trial   ms a frame")
    for what, seconds in spent.items():
        ratios.add(what, seconds, spent["tracking"])
        each = 1e3 * seconds / trials
        print(f"{what:14s} {seconds:7.1f} {each:10.2f} {1e3 * seconds / frames:12.4f}")
    print(f"{'sum':14s} {cpu:7.1f} {1e3 * cpu / trials:10.2f} {1e3 * cpu / frames:12.4f}")
    print(f"\noverhead of a trial (all the rest): {1e3 * spent['all the rest'] / trials:.2f} ms")
    shared = len(design.points) * len(design.contenders)
    recorded = spent["traffic"] + spent["truth"]
    alone = cpu + (shared - 1) * recorded
    print(
        f"a million frames: {cpu / frames * MILLION / 3600:.2f} core-hours where {shared} trials "
        f"share a truth, {alone / frames * MILLION / 3600:.2f} where every trial has its own"
    )


def growth_table(design: Design) -> None:
    """CPU seconds of one process by the number of seeds."""
    print(f"{'seeds':>5} {'trials':>7} {'CPU s':>7} {'ms a trial':>11}")
    seeds = 1
    while seeds <= design.seeds:
        part = replace(design, seeds=seeds)
        with tempfile.TemporaryDirectory() as place:
            os.environ["MOT_SIM_CACHE"] = str(Path(place) / "truth")
            start = process_time()
            run(part, Path(place) / "one", 1)
            cpu = process_time() - start
        print(f"{seeds:5d} {len(part):7d} {cpu:7.1f} {1e3 * cpu / len(part):11.2f}", flush=True)
        seeds *= 2


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--scene", default="intersection")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--growth", action="store_true", help="by the number of seeds")
    Ratios.add_option(parser)
    given = parser.parse_args()
    design = Design(
        axes={"detector.jitter": LEVELS}, trackers=TRACKERS, scene=given.scene,
        seeds=given.seeds, frames=given.frames,
    )  # fmt: skip
    if given.growth:
        growth_table(design)
        return
    with tempfile.TemporaryDirectory() as place:
        one, many = Path(place) / "one", Path(place) / "many"
        print(f"{len(design):,} trials, {len(design) * given.frames:,} frames of {given.scene}")
        os.environ["MOT_SIM_CACHE"] = str(Path(place) / "truth of one")
        with accounted() as clock:
            before = process_time()
            table, wall = run(design, one, 1)
            cpu = process_time() - before
        os.environ["MOT_SIM_CACHE"] = str(Path(place) / "truth of many")
        other, wall_many = run(design, many, given.workers)
        same = table.drop_columns(["cpu_seconds"]).equals(other.drop_columns(["cpu_seconds"]))
    print(f"one process {wall:.1f} s, {given.workers} workers {wall_many:.1f} s of wall time")
    print(f"{given.workers} workers are {wall / wall_many:.2f} x one; tables equal: {same}")
    ratios = Ratios("sweep")
    tell_parts(design, table, clock, cpu, ratios)
    ratios.tell(given.update_baseline)


if __name__ == "__main__":
    main()
