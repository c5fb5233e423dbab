"""Which wrong motions and calibrations are named by the boxes, and whether any right one is.

    python -m benchmarks.motion_checks [--root KITTI] [--seeds 2] [--detections rrc ...]

Every drive is checked as it is (a false alarm is printed with its text), and with each mistake:
a count of what was said, and the drives in which nothing was. KITTI: every sequence, with OXTS
and ORB-SLAM3; mistakes with the first of the detectors and OXTS. Scenes: every one, without
pixels. About five minutes.
"""

import argparse
import logging
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from mot_sim import SCENES, find_scene, record
from mot_sim.datasets import available_sequences, kitti_sequence
from tracker import Camera, Frame, Tracker
from tracker.errors import DatasetNotFound, MotionWarning
from tracker.geometry import homogeneous, invert
from tracker.motion_check import Contradiction, MotionCheck

CAR_HEIGHT = 1.5
FLIP = np.diag([1.0, -1.0, -1.0, 1.0])
LEAP = homogeneous(t=np.array([3.0, 0.0, -3.0]))

Motions = list[Array | None]
Drive = tuple[str, Camera, list[Frame]]
MOTION: dict[str, Callable[[Motions], Motions]] = {
    "world-to-camera": lambda Ts: [None if T is None else invert(T) for T in Ts],
    "OpenGL's axes": lambda Ts: [None if T is None else FLIP @ T @ FLIP for T in Ts],
    "one frame late": lambda Ts: [*Ts[:2], *Ts[1:-1]],
    "one frame early": lambda Ts: [*Ts[:1], *Ts[2:], Ts[-1]],
    "a hundredth": lambda Ts: [
        None if T is None else homogeneous(T[:3, :3], 0.01 * T[:3, 3]) for T in Ts
    ],
    "a leap of 4 m": lambda Ts: [
        LEAP @ T if T is not None and k == len(Ts) // 2 else T for k, T in enumerate(Ts)
    ],
}
# Factors of height and focal length, degrees of pitch.
CALIBRATION: dict[str, tuple[float, float, float]] = {
    "height x 0.5": (0.5, 1.0, 0.0), "height x 2": (2.0, 1.0, 0.0),
    "pitch +5 deg": (1.0, 1.0, 5.0), "pitch -5 deg": (1.0, 1.0, -5.0),
    "focal x 0.6": (1.0, 0.6, 0.0), "focal x 1.6": (1.0, 1.6, 0.0),
}  # fmt: skip


def miscalibrated(camera: Camera, height: float, focal: float, degrees: float) -> Camera:
    """A level camera with these mistakes."""
    K = camera.K * [[focal, 1.0, 1.0], [1.0, focal, 1.0], [1.0, 1.0, 1.0]]
    return Camera.mounted(K, camera.image_size, height * camera.height, np.radians(degrees))


def said(
    frames: list[Frame], boxes: list[Array], Ts: Motions, camera: Camera
) -> Contradiction | None:
    """What is said of a drive with these motions."""
    check = MotionCheck()
    for frame, found, T in zip(frames, boxes, Ts, strict=True):
        check = check.after(frame, T, found, camera, CAR_HEIGHT)
    return check.verdict(camera, CAR_HEIGHT)


def scene_drives(seeds: int) -> Iterator[Drive]:
    """Every scene, without pixels."""
    for name in sorted(SCENES):
        for seed in range(seeds):
            episode = record(find_scene(name), seed)
            yield f"{name}/{seed}", episode.camera, list(episode)


def kitti_drives(root: Path, detections: str, ego: str) -> Iterator[Drive]:
    """Every sequence that has these detections."""
    for name in available_sequences(root):
        try:
            sequence = kitti_sequence(root, name, detections, ego)
        except DatasetNotFound:
            continue
        yield name, sequence.camera, list(sequence)


def report(title: str, drives: Iterator[Drive], with_mistakes: bool) -> None:
    """What was said of the drives as they are, and with each mistake."""
    heard: dict[str, list[tuple[str, str]]] = {}
    false_alarms, count = [], 0
    for name, camera, frames in drives:
        suppress = Tracker.default(camera).suppress
        boxes = [suppress(frame.found, camera).boxes for frame in frames]
        Ts: Motions = [frame.T_now_before for frame in frames]
        count += 1
        found = said(frames, boxes, Ts, camera)
        if found is not None:
            false_alarms.append(f"  {name}: {found.text}")
        if not with_mistakes:
            continue
        for mistake, change in MOTION.items():
            found = said(frames, boxes, change(Ts), camera)
            heard.setdefault(mistake, []).append((name, "-" if found is None else found.cause))
        for mistake, changes in CALIBRATION.items():
            found = said(frames, boxes, Ts, miscalibrated(camera, *changes))
            heard.setdefault(mistake, []).append((name, "-" if found is None else found.cause))
    print(f"\n{title}: {count} drives, {len(false_alarms)} false alarms")
    print("\n".join(false_alarms), end="\n" if false_alarms else "")
    for mistake, told in heard.items():
        counts = Counter(cause for _, cause in told)
        silent = " ".join(name for name, cause in told if cause == "-")
        words = ", ".join(f"{number} {cause}" for cause, number in counts.most_common())
        print(f"  {mistake:16s} {words.replace('-', 'silent')}" + f" ({silent})" * bool(silent))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, help="the KITTI tree; without it only scenes")
    parser.add_argument("--seeds", type=int, default=2, help="runs of each scene")
    parser.add_argument("--detections", nargs="+", default=["rrc", "permatrack", "pointrcnn"])
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    warnings.simplefilter("ignore", MotionWarning)
    if arguments.root is not None:
        for detections in arguments.detections:
            for ego in ("oxts", "orbslam3"):
                first = detections == arguments.detections[0] and ego == "oxts"
                drives = kitti_drives(arguments.root, detections, ego)
                report(f"KITTI, {detections}, {ego}", drives, with_mistakes=first)
    report("scenes", scene_drives(arguments.seeds), with_mistakes=True)


if __name__ == "__main__":
    main()
