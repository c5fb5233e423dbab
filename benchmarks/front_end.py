"""What the cues of a frame cost, stage by stage, on one core.

    python -m benchmarks.front_end [--cars 10] [--rounds 30]

A rendered picture of KITTI's size with so many boxes on its cars (each car again with another
jitter where there are fewer). CPU milliseconds a frame, median and 90th percentile; goal: 60 for
ten cars with all cues. Beside it the same picture's suppression, lifting and association.
"""

import argparse
import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from dataclasses import replace  # noqa: E402
from time import process_time  # noqa: E402

import cv2  # noqa: E402
import numpy as np  # noqa: E402

from mot_sim.simulation.registry import find_scene  # noqa: E402
from mot_sim.training.appearance import CarPicture, RenderedDrive, car_pictures  # noqa: E402
from tracker import Detections, Frame, Tracker  # noqa: E402
from tracker.front_end import FrontEnd  # noqa: E402

GOAL_MS, GOAL_CARS = 60.0, 10


def frames_of(picture: CarPicture, cars: int, rounds: int) -> list[Frame]:
    """The picture with so many boxes, which tremble from frame to frame."""
    rng = np.random.default_rng(0)
    first = np.resize(picture.boxes, (cars, 4))
    first[len(picture.boxes) :, [0, 2]] += 3.0
    frames = []
    for index in range(rounds):
        boxes = first + rng.normal(0.0, 1.0, first.shape)
        seen = Detections.of(boxes.clip(0.0, [1241.0, 374.0, 1241.0, 374.0]), np.full(cars, 0.9))
        frames.append(Frame(index, 0.1 * index, seen, image=picture.image))
    return frames


def stage_ms(frames: list[Frame], cues: str) -> dict[str, np.ndarray]:
    """CPU milliseconds of every frame, by stage and in all."""
    front_end, camera = FrontEnd.of(cues), find_scene("intersection").rig.camera
    front_end(frames[0], camera)
    spent: dict[str, list[float]] = {}
    for frame in frames:
        one: dict[str, float] = {}
        front_end(frame, camera, one, process_time)
        for stage, seconds in {**one, "in all": sum(one.values())}.items():
            spent.setdefault(stage, []).append(1e3 * seconds)
    return {stage: np.array(each) for stage, each in spent.items()}


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--cars", type=int, default=GOAL_CARS)
    parser.add_argument("--rounds", type=int, default=30)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    picture = next(car_pictures(RenderedDrive("street", 902, ("noon",), (40,))))
    frames = frames_of(picture, given.cars, given.rounds)
    print(f"{given.cars} cars, {given.rounds} frames, CPU ms a frame: median (90th percentile)")
    for cues in ("pose", "appearance", "classical", "pose,classical", "all"):
        parts = stage_ms(frames, cues)
        told = (
            f"{stage} {np.median(each):5.1f} ({np.percentile(each, 90):.1f})"
            for stage, each in parts.items()
        )
        print(f"{cues:16s} " + "  ".join(told))
    whole = float(np.median(parts["in all"]))
    if given.cars == GOAL_CARS:
        print(
            f"all cues: {whole:.1f} ms, goal {GOAL_MS:g}: {'met' if whole <= GOAL_MS else 'MISSED'}"
        )
    tracker = Tracker.default(find_scene("intersection").rig.camera)
    start = process_time()
    for frame in frames:
        tracker.step(replace(frame, image=None))
    print(f"tracking without cues: {1e3 * (process_time() - start) / len(frames):.1f} ms a frame")


if __name__ == "__main__":
    main()
