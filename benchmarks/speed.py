"""How fast the trackers are, how they grow, and what reading all of KITTI costs.

    python -m benchmarks.speed [--root KITTI] [--update-baseline]

CPU seconds of one thread. Machines differ and are shared: beside every figure stands its ratio
to a yardstick measured in the same run, the same frames through a bare IoU matcher (IoU matrix
and Hungarian assignment of neighbouring frames, nothing else). `all cues, given`: every cost, on
columns of shapes, poses and descriptors that were drawn at random before (measuring them in images
is another benchmark, front_end). The ratios that were kept stand beside those of the run, see
`benchmarks.baseline`. `mot-sim compare` has peers in one run with ours.
"""

import argparse
import logging
import os
import resource
import sys

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from collections.abc import Callable  # noqa: E402
from dataclasses import replace  # noqa: E402
from pathlib import Path  # noqa: E402
from time import perf_counter, process_time  # noqa: E402

import numpy as np  # noqa: E402
from scipy.optimize import linear_sum_assignment  # noqa: E402

from benchmarks.baseline import Ratios  # noqa: E402
from benchmarks.three_d import without_car_filter  # noqa: E402
from mot_sim.datasets import available_sequences, kitti_sequence  # noqa: E402
from mot_sim.evaluation.runs import parse_costs  # noqa: E402
from mot_sim.experiments.paper.cue_sets import ALL_CUES  # noqa: E402
from tracker import Camera, Detections, Frame, Tracker  # noqa: E402
from tracker.beliefs import MEAN_CAR  # noqa: E402
from tracker.costs import COSTS  # noqa: E402
from tracker.geometry import box_iou, homogeneous  # noqa: E402

K = np.array([[721.5, 0.0, 609.6], [0.0, 721.5, 172.9], [0.0, 0.0, 1.0]])
CAMERA = Camera.mounted(K, (1242, 375), 1.65)
Drive = tuple[Camera, list[Frame]]
# Lengths of the shipped shape prior's coefficients and of the learned descriptor.
SHAPES, DESCRIPTOR = 5, 128


def yardstick(drives: list[Drive]) -> float:
    """CPU seconds of the bare IoU matcher over the drives."""
    start = process_time()
    for _, frames in drives:
        before = frames[0].detections.boxes
        for frame in frames[1:]:
            boxes = frame.detections.boxes
            linear_sum_assignment(-box_iou(before[:, None], boxes[None]))
            before = boxes
    return process_time() - start


def tracking(build: Callable[[Camera], Tracker], drives: list[Drive]) -> float:
    """CPU seconds of a tracker over the drives."""
    start = process_time()
    for camera, frames in drives:
        tracker = build(camera)
        for frame in frames:
            tracker.step(frame)
    return process_time() - start


def with_cues(drives: list[Drive]) -> list[Drive]:
    """The same frames with a column for every cue, drawn at random."""
    rng = np.random.default_rng(0)

    def seen(detections: Detections) -> Detections:
        n = len(detections)
        return replace(
            detections,
            yaw=rng.uniform(-np.pi, np.pi, n),
            size=rng.normal(MEAN_CAR, 0.1, (n, 3)),
            shape=rng.normal(0.0, 0.2, (n, SHAPES)),
            pose_cov=np.tile(0.01 * np.eye(SHAPES + 1), (n, 1, 1)),
            descriptor=rng.normal(0.0, 0.05, (n, DESCRIPTOR)),
        )

    return [
        (camera, [replace(frame, detections=seen(frame.detections)) for frame in frames])
        for camera, frames in drives
    ]


def every_cost(camera: Camera) -> Tracker:
    """The default tracker with all costs at once."""
    weights = parse_costs(ALL_CUES.replace("+", ","))
    return Tracker.default(camera, tuple((weights[name], COSTS[name]()) for name in weights))


def crowd(boxes: int, frames: int = 100) -> Drive:
    """So many cars standing on a wide road that the camera passes at 5 m/s, with jittered boxes."""
    rng = np.random.default_rng(boxes)
    x, z = rng.uniform(-0.7, 0.7, boxes), rng.uniform(0.15, 1.0, boxes)
    steps = []
    for index in range(frames):
        depth = 60.0 * z + 50.0 - 0.5 * index
        height = K[1, 1] * 1.5 / depth * rng.normal(1, 0.02, boxes)
        u = (
            K[0, 2]
            + K[0, 0] * x * (60.0 * z + 50.0) / depth
            + 0.02 * height * rng.normal(size=boxes)
        )
        v = K[1, 2] + K[1, 1] * 1.65 / depth + 0.02 * height * rng.normal(size=boxes)
        corners = np.stack((u - 0.6 * height, v - height, u + 0.6 * height, v), axis=1)
        motion = homogeneous(t=np.array([0.0, 0.0, -0.5]))
        seen = Detections.of(corners, np.full(boxes, 0.95))
        steps.append(Frame(index, 0.1 * index, seen, motion if index else None))
    return CAMERA, steps


def growth_table(ratios: Ratios) -> None:
    """CPU milliseconds a step, by the number of boxes: mean and 99th percentile."""
    print("\nboxes   default ms   p99 ms   paper ms   p99 ms   x yardstick (default)")
    for boxes in (5, 20, 50, 100, 200):
        camera, frames = crowd(boxes)
        cells = []
        for build in (Tracker.default, Tracker.paper):
            tracker, times = build(camera), []
            for frame in frames:
                start = process_time()
                tracker.step(frame)
                times.append(1e3 * (process_time() - start))
            cells += [float(np.mean(times[1:])), float(np.percentile(times[1:], 99))]
        drives = [(camera, frames)]
        cost = tracking(Tracker.default, drives), yardstick(drives)
        ratio = ratios.add(f"default, {boxes} boxes", *cost)
        default, p99, paper, paper_p99 = cells
        print(f"{boxes:5d} {default:12.2f} {p99:8.2f} {paper:10.2f} {paper_p99:8.2f} {ratio:8.1f}")


def kitti_table(root: Path, repeats: int, ratios: Ratios) -> None:
    """Frames per CPU second over all sequences with RRC boxes, the time to read, the memory."""
    names = available_sequences(root)
    start_cpu, start = process_time(), perf_counter()
    sequences = [kitti_sequence(root, name) for name in names]
    print(
        f"\n{len(names)} sequences read (calib, oxts, rrc) in {perf_counter() - start:.2f} s, "
        f"{process_time() - start_cpu:.2f} CPU s"
    )
    drives = [(sequence.camera, list(sequence)) for sequence in sequences]
    frames = sum(len(steps) for _, steps in drives)
    print(
        f"\n{frames} frames, RRC boxes   frames / CPU s (median, best of {repeats})   x yardstick"
    )
    yard = [yardstick(drives) for _ in range(repeats)]
    print(
        f"bare IoU matcher   {frames / np.median(yard):10.0f} {frames / min(yard):8.0f}        1.0"
    )
    trackers = {
        "default": (Tracker.default, drives),
        "without car filter": (without_car_filter, drives),
        "paper": (Tracker.paper, drives),
        "all cues, given": (every_cost, with_cues(drives)),
    }
    for name, (build, seen) in trackers.items():
        times, beside = [], []
        for _ in range(repeats):
            times.append(tracking(build, seen))
            beside.append(times[-1] / yardstick(drives))
        ratio = ratios.add(f"{name}, RRC", float(np.median(beside)), 1.0)
        fast = frames / np.median(times), frames / min(times), ratio
        print(f"{name:18s} {fast[0]:10.0f} {fast[1]:8.0f} {fast[2]:10.1f}")
    unit = 1024 if sys.platform != "darwin" else 1024**2
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
    print(f"\npeak memory, all sequences held at once: {peak:.0f} MB")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, help="the KITTI tree; without it only the growth")
    parser.add_argument("--repeats", type=int, default=5)
    Ratios.add_option(parser)
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    ratios = Ratios("speed")
    if arguments.root is not None:
        kitti_table(arguments.root, arguments.repeats, ratios)
    growth_table(ratios)
    ratios.tell(arguments.update_baseline)


if __name__ == "__main__":
    main()
