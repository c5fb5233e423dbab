"""What stays equal to the last bit when numpy and OpenBLAS take other kernels, as on other CPUs.

    python -m benchmarks.determinism [--scene intersection] [--frames 20]

The same episode is recorded and tracked in child processes that are told to use other kernels:
OpenBLAS by OPENBLAS_CORETYPE, numpy by NPY_DISABLE_CPU_FEATURES. Printed for each stage: `equal`,
or the largest difference from the run with this machine's own kernels.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from mot_sim import Tracker, evaluate_sequence, find_scene, record, track_sequence

ROOT = Path(__file__).parents[1]
OLD = {"NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX"}
KERNELS: dict[str, dict[str, str]] = {
    "own kernels": {},
    "own kernels, again": {},
    "OpenBLAS as on Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "OpenBLAS as on Nehalem": {"OPENBLAS_CORETYPE": "Nehalem"},
    "numpy without AVX2": OLD,
    "both without AVX2": {"OPENBLAS_CORETYPE": "Nehalem", **OLD},
}
STAGES = ("traffic", "labels", "visibility", "image", "detections", "tracks", "HOTA")


def compute(scene: str, frames: int) -> dict[str, np.ndarray]:
    """The arrays of each stage."""
    episode = record(find_scene(scene, frames=frames), seed=1, renderer="raster")
    first = next(iter(episode))
    bare = record(find_scene(scene, frames=frames), seed=1)
    tracks, _ = track_sequence(Tracker.default(episode.camera), bare)
    scores = evaluate_sequence(episode.truth, tracks, len(episode))
    states = episode.traffic_states
    assert first.image is not None
    return {
        "traffic": np.concatenate([(state.x, state.y, state.heading) for state in states], axis=1),
        "labels": episode.truth.boxes,
        "visibility": episode.exact.visible,
        "image": first.image,
        "detections": episode.log.detections.boxes,
        "tracks": tracks.boxes,
        "HOTA": np.array([scores["HOTA"]]),
    }


def run(scene: str, frames: int, variables: dict[str, str]) -> dict[str, np.ndarray]:
    """The same in a process with these variables in its environment."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "arrays.npz"
        command = [sys.executable, "-m", "benchmarks.determinism", "--scene", scene]
        subprocess.run(
            [*command, "--frames", str(frames), "--into", str(out)],
            env={**os.environ, "PYTHONPATH": str(ROOT), **variables}, cwd=ROOT, check=True,
            stderr=subprocess.DEVNULL,
        )  # fmt: skip
        with np.load(out) as arrays:
            return dict(arrays)


def compared(before: np.ndarray, now: np.ndarray) -> str:
    """`equal`, or how far apart; another number of rows is said as such."""
    if before.shape != now.shape:
        return f"{len(now)} rows, not {len(before)}"
    if before.tobytes() == now.tobytes():
        return "equal"
    return f"{np.abs(now.astype(float) - before.astype(float)).max():.1e}"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--scene", default="intersection")
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--into", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.into is not None:
        np.savez(arguments.into, **compute(arguments.scene, arguments.frames))
        return
    print(f"| {' | '.join(('kernels', *STAGES))} |\n|{'---|' * (len(STAGES) + 1)}")
    own: dict[str, np.ndarray] = {}
    for name, variables in KERNELS.items():
        found = run(arguments.scene, arguments.frames, variables)
        own = own or found
        cells = [compared(own[stage], found[stage]) for stage in STAGES]
        print(f"| {' | '.join((name, *cells))} |", flush=True)


if __name__ == "__main__":
    main()
