"""How fast the sensor chain is: a recorded episode at once, and one frame at a time.

    python -m benchmarks.sensors [--profile rrc]

Ten objects a frame, each for ten seconds; CPU seconds of one thread, best of five seeds, so that
nothing is kept from an earlier run. A live step is the mean over 100 frames in a row, in which ten
objects come and go. The machine's speed of the moment: a thousand additions of ten numbers, beside
every profile. Goals: 10,000 frames/s over a recorded episode, 1 ms for a live step.
"""

import argparse
import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from time import process_time  # noqa: E402

import numpy as np  # noqa: E402

from mot_sim.simulation.rig import Rig  # noqa: E402
from mot_sim.simulation.sensors import PROFILES, Detector, Sightings  # noqa: E402

FRAMES, OBJECTS, LIFE, LIVE = 2000, 10, 100, 100


def crowd() -> Sightings:
    """Ten objects in every frame, each for ten seconds."""
    rng = np.random.default_rng(0)
    frames = np.repeat(np.arange(FRAMES), OBJECTS)
    slot = np.tile(np.arange(OBJECTS), FRAMES)
    ids = (frames + 7 * slot) // LIFE * OBJECTS + slot
    count = len(frames)
    left, top = rng.uniform(0, 1000, count), rng.uniform(150, 200, count)
    height = rng.uniform(20, 120, count)
    boxes = np.stack((left, top, left + 1.5 * height, top + height), axis=1)
    return Sightings(
        frames, ids, boxes, boxes, np.full((count, 4), np.nan), rng.uniform(0.2, 1.0, count),
        np.zeros(count), np.full(count, 30.0), np.full(count, "Car", "<U8"),
    )  # fmt: skip


def yardstick() -> float:
    """Milliseconds that a thousand additions of ten numbers take now."""
    numbers = np.ones(10)
    start = process_time()
    for _ in range(1000):
        numbers + numbers
    return 1e3 * (process_time() - start)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--profile", nargs="+", default=PROFILES)
    sightings, camera = crowd(), Rig.kitti().camera
    every = np.arange(FRAMES)
    print(
        f"{'profile':12s}{'recorded, frames/s':>20s}{'live, ms a step':>18s}"
        f"{'1000 additions, ms':>21s}"
    )
    for name in parser.parse_args().profile:
        detector = Detector(name)
        whole, live, pace = [], [], []
        for seed in range(5):
            start = process_time()
            detector.sense(sightings, seed, camera, 0.1, every)
            whole.append(process_time() - start)
            start = process_time()
            for frame in range(1000, 1000 + LIVE):
                now = sightings.select(slice(frame * OBJECTS, (frame + 1) * OBJECTS))
                detector.sense(now, seed, camera, 0.1, np.array([frame]))
            live.append((process_time() - start) / LIVE)
            pace.append(yardstick())
        print(f"{name:12s}{FRAMES / min(whole):20,.0f}{1e3 * min(live):18.2f}{min(pace):21.2f}")


if __name__ == "__main__":
    main()
