"""What a process of its own costs: trials of 100 frames with one and without, in turns.

    python -m benchmarks.isolation [--pairs 15] [--frames 100]

A trial is what a sweep does with a tracker and a seed once the truth is recorded: what the detector
sees, the tracking, the scores. One process serves all the trials of a tracker, as in a sweep.
Prints medians of wall and CPU seconds (of this process and its children) and of the ratios pair by
pair. Goal: 10 % more at most.
"""

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from statistics import median
from time import perf_counter

from mot_sim.experiments.executor import one_thread
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings, drive_of
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.sweep.trial import run_trial
from mot_sim.foreign.isolation import Isolation

TRACKERS = ("default", "mine=examples.own_tracker_stress:Overlap")
GOAL = 0.10


def main() -> None:
    """Measure in turns and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=15)
    parser.add_argument("--frames", type=int, default=100)
    given = parser.parse_args()
    conditions = Conditions.of("intersection", {"scene.frames": given.frames})
    with tempfile.TemporaryDirectory() as folder, one_thread():
        recorded = Recordings(Path(folder)).truth(conditions, 0)

        def trial(spec: TrackerSpec) -> tuple[float, float]:
            wall, cpu = perf_counter(), _cpu_seconds()
            outcome = run_trial(spec, drive_of(conditions, recorded, 0))
            assert outcome.error is None, outcome.error
            return perf_counter() - wall, _cpu_seconds() - cpu

        for text in TRACKERS:
            here = replace(TrackerSpec.parse(text), isolation=Isolation("none"))
            apart = replace(here, isolation=Isolation("all"))
            trial(here), trial(apart)
            pairs = [(trial(here), trial(apart)) for _ in range(given.pairs)]
            for what, place in (("wall", 0), ("CPU", 1)):
                before, after = (median(pair[which][place] for pair in pairs) for which in (0, 1))
                more = median(pair[1][place] / pair[0][place] for pair in pairs) - 1.0
                word = "kept" if more <= GOAL else "missed"
                print(
                    f"{here.name:8} {what:4}: {before:.3f} s here, {after:.3f} s apart, "
                    f"{more:+.1%} (goal {GOAL:+.0%}: {word})"
                )


def _cpu_seconds() -> float:
    """CPU seconds of this process and of its children, those that rest too."""
    used = [getrusage(who) for who in (RUSAGE_SELF, RUSAGE_CHILDREN)]
    children = Path("/proc/self/task").glob("*/children")
    resting = [pid for each in children for pid in each.read_text().split()]
    nanoseconds = sum(int(Path(f"/proc/{pid}/schedstat").read_text().split()[0]) for pid in resting)
    return sum(each.ru_utime + each.ru_stime for each in used) + 1e-9 * nanoseconds


if __name__ == "__main__":
    main()
