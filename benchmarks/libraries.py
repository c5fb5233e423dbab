"""Trackers of other libraries through every command that takes trackers, as a user names them.

    python -m benchmarks.libraries [--frames 10]

norfair, motpy and `trackers` (with supervision) come from the environments of the guests
(`mot-sim compare --setup all` makes them, once), as if they were installed beside mot-sim. Prints
a line a command: the exit code, and the seconds that it took; ends with 1 where one failed.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

from mot_sim.foreign.register import ENVIRONMENTS

TRACKERS = "n=norfair:Tracker,m=motpy:MultiObjectTracker,s=trackers:SORTTracker,d=glue:OfDetections"
GLUE = '''
from trackers import ByteTrackTracker


class OfDetections:
    """Anything with update(detections) is given supervision's."""

    def __init__(self):
        self.inner = ByteTrackTracker(frame_rate=10.0)

    def update(self, detections):
        return self.inner.update(detections)
'''
SUITES = """
[small]
about = "cars that cross"
scene = "crossing"
frames = {frames}
bounds = {{ HOTA = 0.05 }}
"""
ASSERTS = """
from glue import OfDetections
from motpy import MultiObjectTracker
from norfair import Tracker
from trackers import SORTTracker

from mot_sim import assert_tracks, mot_episode

episode = mot_episode("crossing", seed=1, frames={frames})
for tracker in (Tracker, SORTTracker, OfDetections(), MultiObjectTracker(dt=0.1)):
    assert_tracks(tracker, episode, hota=0.05)
"""


def main() -> None:
    """Run all commands and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=10)
    frames = parser.parse_args().frames
    small = ("--seeds", "1", "--frames", str(frames))
    axis = ("--axis", "detector.jitter=1", "--scene", "crossing")
    scene = ("--scene", "crossing", "--seeds", "0", "--knobs", f"frames={frames}")
    commands = {
        "stress": ("--file", "suites.toml", "--seeds", "1", "--trackers", TRACKERS),
        "sweep": (*axis, *small, "--trackers", TRACKERS, "--out", "out/sweep"),
        "diagnose": ("crossing", "--seeds", "1", "--set", f"scene.frames={frames}",
                     "--tracker", "d=glue:OfDetections"),
        "compare": (*scene, "--trackers", f"default,{TRACKERS}"),
    }  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "glue.py").write_text(GLUE)
        (place / "suites.toml").write_text(SUITES.format(frames=frames))
        (place / "asserts.py").write_text(ASSERTS.format(frames=frames))
        (place / "sitecustomize.py").write_text(f"import sys\nsys.path += {_libraries()!r}\n")
        calls = {name: ["-m", "mot_sim", name, *options] for name, options in commands.items()}
        calls["assert_tracks"] = ["asserts.py"]
        failed = [name for name, call in calls.items() if not _runs(name, call, place)]
    sys.exit(1 if failed else 0)


def _libraries() -> list[str]:
    """Where the packages of the guests' environments lie."""
    for name, environment in ENVIRONMENTS.items():
        if not environment.is_ready:
            sys.exit(f"{name}: no environment; mot-sim compare --setup all makes it")
    found = [sorted(each.path.glob("lib/python3*/site-packages")) for each in ENVIRONMENTS.values()]
    return [str(folder) for folders in found for folder in folders]


def _runs(name: str, call: list[str], place: Path) -> bool:
    """Run a command; whether it ended with 0."""
    path = os.pathsep.join([str(place), os.environ.get("PYTHONPATH", str(Path.cwd()))])
    start = perf_counter()
    done = subprocess.run(
        [sys.executable, *call],
        cwd=place, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    print(f"{name:13} exit code {done.returncode}, {perf_counter() - start:.1f} s", flush=True)
    if done.returncode:
        print(done.stdout[-2000:], done.stderr[-2000:])
    return done.returncode == 0


if __name__ == "__main__":
    main()
