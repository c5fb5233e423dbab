"""What a unit test of a tracker costs: CPU seconds of making, reading and asserting an episode.

python -m benchmarks.testing
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Callable
from statistics import median
from time import process_time

from mot_sim.experiments.sweep import drives, seeded_episodes
from mot_sim.testing import assert_tracks, mot_episode
from tracker import Tracker

SCENES = ("intersection", "look_alikes", "gauntlet")
REPEATS = 5
YARDSTICK = "sum(i * i for i in range(2_000_000))"


def timed(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """The median CPU seconds of a call."""
    times = []
    for _ in range(repeats):
        start = process_time()
        work()
        times.append(process_time() - start)
    return median(times)


def forget() -> None:
    """As a new process would begin, its modules imported."""
    seeded_episodes._drive.cache_clear()
    drives._read.cache_clear()


def main() -> None:
    """Print a line a scene, beside a yardstick of this machine."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    yardstick = timed(lambda: eval(YARDSTICK))
    print(f"CPU seconds, medians of {REPEATS}; yardstick {YARDSTICK}: {yardstick:.3f}")
    print(f"{'scene':14}{'made':>8}{'read':>8}{'assert':>8}{'a cached test':>15}")
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:

            def made(scene: str = scene) -> object:
                forget()
                return mot_episode(scene, 3, cache=folder)

            first, cached = timed(made, 1), timed(made)
            episode = mot_episode(scene, 3, cache=folder)
            test = timed(lambda episode=episode: assert_tracks(Tracker.default, episode, mota=0.1))
            print(f"{scene:14}{first:8.2f}{cached:8.3f}{test:8.3f}{cached + test:15.3f}")
    clock = "time.process_time()"
    start = f"import time; s = {clock}; import mot_sim_pytest; print({clock} - s)"
    loaded = subprocess.run(
        [sys.executable, "-c", f"import pytest; {start}"],
        capture_output=True,
        text=True,
        check=True,
    )
    print(f"loading the plugin, beside pytest itself: {float(loaded.stdout):.4f}")


if __name__ == "__main__":
    main()
