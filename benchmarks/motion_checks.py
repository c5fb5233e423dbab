"""Which wrong motions and calibrations are named by the boxes, and whether any right one is.

    python -m benchmarks.motion_checks [--root KITTI] [--seeds 2] [--detections rrc ...]

Every drive is checked as it is, cars and walkers, with every frame looked at and with every third;
a false alarm is printed with its text. Then with each mistake: in how many drives it was named
rightly, how many were refused at once, as no camera moves so, and what else was said. KITTI: every
sequence, with OXTS and ORB-SLAM3; mistakes with the first of the detectors and OXTS. Scenes: every
one, without pixels. About three minutes.
"""

import argparse
import logging
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy import ndarray as Array

from mot_sim import SCENES, find_scene, record
from mot_sim.datasets import available_sequences, kitti_sequence
from tracker import Camera, Frame, Tracker
from tracker.ego_motion import CameraMotion
from tracker.errors import BadCalibration, BadMotion, DatasetNotFound, MotionWarning
from tracker.geometry import homogeneous, invert
from tracker.motion_check import MotionCheck
from tracker.per_class import for_kind

FLIP = np.diag([1.0, -1.0, -1.0, 1.0])
# From our axes to a vehicle's: x forward, y left, z up.
TO_VEHICLE = homogeneous(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]))
LEAP = homogeneous(t=np.array([3.0, 0.0, -3.0]))
# Every so many-th frame is looked at.
EVERY = 3
DETECTIONS = [
    "rrc",
    "permatrack",
    "pointrcnn",
    "rrc_pedestrian",
    "pointrcnn_pedestrian",
]

Motions = list[Array | None]
# Name, camera, frames, and the class of their boxes.
Drive = tuple[str, Camera, list[Frame], str]


class Mistake(NamedTuple):
    """What is done to a drive, and what should be said of it."""

    causes: tuple[str, ...]
    """Of tracker.motion_check.CAUSES, those that name it rightly."""
    motions: Callable[[Motions], Motions] = lambda Ts: Ts
    """What is given in place of the motions."""
    height: float = 1.0
    """By which the camera's height is multiplied."""
    focal: float = 1.0
    """By which its focal length is multiplied."""
    degrees: float = 0.0
    """Of pitch that the camera does not have."""

    def camera(self, camera: Camera) -> Camera:
        """A level camera with this mistake."""
        f = self.focal
        K = camera.K * [[f, 1.0, 1.0], [1.0, f, 1.0], [1.0, 1.0, 1.0]]
        height, pitch = self.height * camera.height, float(np.radians(self.degrees))
        return Camera.mounted(K, camera.image_size, height, pitch)


def each(change: Callable[[Array], Array]) -> Callable[[Motions], Motions]:
    """The same change of every motion."""
    return lambda Ts: [None if T is None else change(T) for T in Ts]


def scaled(factor: float) -> Callable[[Motions], Motions]:
    """Translations so many times as long."""
    return each(lambda T: homogeneous(T[:3, :3], factor * T[:3, 3]))


def transposed(Ts: Motions) -> Motions:
    """Of poses whose rotations are written column by column."""
    T_world_cam, before, result = np.eye(4), np.eye(4), list(Ts[:1])
    for T in Ts[1:]:
        T_world_cam = T_world_cam @ invert(np.eye(4) if T is None else T)
        now = homogeneous(T_world_cam[:3, :3].T, T_world_cam[:3, 3])
        result.append(None if T is None else invert(now) @ before)
        before = now
    return result


def leaping(Ts: Motions) -> Motions:
    """A leap in the middle."""
    return [LEAP @ T if T is not None and k == len(Ts) // 2 else T for k, T in enumerate(Ts)]


MISTAKES = {
    "world-to-camera": Mistake(("inverse", "reversed"), each(invert)),
    "OpenGL's axes": Mistake(("opengl", "reversed"), each(lambda T: FLIP @ T @ FLIP)),
    "a vehicle's axes": Mistake(
        ("vehicle axes",), each(lambda T: TO_VEHICLE @ T @ invert(TO_VEHICLE))
    ),
    "transposed": Mistake(("transposed", "inverse"), transposed),
    "one frame late": Mistake(("one frame late",), lambda Ts: [*Ts[:2], *Ts[1:-1]]),
    "one frame early": Mistake(("one frame early",), lambda Ts: [*Ts[:1], *Ts[2:], Ts[-1]]),
    "translation x 100": Mistake(("units",), scaled(100.0)),
    "translation / 100": Mistake(("units",), scaled(0.01)),
    "a leap of 4 m": Mistake(("leap",), leaping),
    "height x 0.1": Mistake(("camera height",), height=0.1),
    "height x 0.5": Mistake(("camera height",), height=0.5),
    "height x 2": Mistake(("camera height",), height=2.0),
    "height x 10": Mistake(("camera height",), height=10.0),
    "pitch +5 deg": Mistake(("pitch",), degrees=5.0),
    "pitch -5 deg": Mistake(("pitch",), degrees=-5.0),
    "focal x 0.5": Mistake(("focal length",), focal=0.5),
    "focal x 0.6": Mistake(("focal length",), focal=0.6),
    "focal x 1.6": Mistake(("focal length",), focal=1.6),
    "focal x 2": Mistake(("focal length",), focal=2.0),
}


def said(drive: Drive, mistake: Mistake) -> tuple[str, str]:
    """The cause that is named, `refused` or empty, and its text."""
    _, camera, frames, kind = drive
    try:
        tracker = for_kind(Tracker.default(mistake.camera(camera)), kind)
        check, height = MotionCheck(), tracker.lift.car_size[1]
        Ts, before = mistake.motions([frame.T_now_before for frame in frames]), frames[0].time
        for frame, T in zip(frames, Ts, strict=True):
            CameraMotion.of(replace(frame, T_now_before=T), frame.time - before)
            boxes = tracker.suppress(frame.found, camera).boxes
            check, before = check.after(frame, T, boxes, tracker.camera, height), frame.time
    except (BadCalibration, BadMotion) as error:
        return "refused", str(error)
    found = check.verdict(tracker.camera, height)
    return ("", "") if found is None else (found.cause, found.text)


def skipping(drive: Drive) -> Drive:
    """Every third frame of a drive, with the motion from one to the next."""
    name, camera, frames, kind = drive
    kept: list[Frame] = []
    motion: Array | None = np.eye(4)
    for frame in frames:
        T = frame.T_now_before
        motion = None if motion is None or T is None else T @ motion
        if frame.index % EVERY == 0:
            kept.append(replace(frame, T_now_before=motion))
            motion = np.eye(4)
    return name, camera, kept, kind


def scene_drives(seeds: int) -> Iterator[Drive]:
    """Every scene, without pixels."""
    for name in sorted(SCENES):
        for seed in range(seeds):
            episode = record(find_scene(name), seed)
            yield f"{name}/{seed}", episode.camera, list(episode), "Car"


def kitti_drives(root: Path, detections: str, ego: str) -> Iterator[Drive]:
    """Every sequence that has these detections."""
    kind = "Pedestrian" if detections.endswith("_pedestrian") else "Car"
    for name in available_sequences(root):
        try:
            sequence = kitti_sequence(root, name, detections, ego)
        except DatasetNotFound:
            continue
        yield name, sequence.camera, list(sequence), kind


def report(title: str, drives: list[Drive], with_mistakes: bool) -> None:
    """What was said of the drives as they are, and with each mistake."""
    right = Mistake(())
    false_alarms = [
        f"  {drive[0]}{skipped}: {text}"
        for drive in drives
        for skipped, given in (("", drive), (f" every {EVERY}", skipping(drive)))
        for cause, text in (said(given, right),)
        if cause
    ]
    print(f"\n{title}: {len(drives)} drives, {len(false_alarms)} false alarms")
    print("\n".join(false_alarms), end="\n" if false_alarms else "")
    if not with_mistakes:
        return
    print(f"  {'mistake':18s} named  refused  wrongly  silent")
    for name, mistake in MISTAKES.items():
        heard = [(drive[0], said(drive, mistake)[0]) for drive in drives]
        named = sum(cause in mistake.causes for _, cause in heard)
        refused = sum(cause == "refused" for _, cause in heard)
        silent = [drive for drive, cause in heard if not cause]
        others = Counter(
            cause for _, cause in heard if cause not in ("", "refused", *mistake.causes)
        )
        words = ", ".join(f"{cause} {count}" for cause, count in others.most_common())
        print(
            f"  {name:18s} {named:5d} {refused:8d} {sum(others.values()):8d} {len(silent):7d}  "
            f"{'; '.join(filter(None, (words, ' '.join(silent))))}".rstrip()
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, help="the KITTI tree; without it only scenes")
    parser.add_argument("--seeds", type=int, default=2, help="runs of each scene")
    parser.add_argument("--detections", nargs="+", default=DETECTIONS)
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    warnings.simplefilter("ignore", MotionWarning)
    if arguments.root is not None:
        for detections in arguments.detections:
            for ego in ("oxts", "orbslam3"):
                first = detections == arguments.detections[0] and ego == "oxts"
                drives = list(kitti_drives(arguments.root, detections, ego))
                report(f"KITTI, {detections}, {ego}", drives, with_mistakes=first)
    if arguments.seeds:
        report("scenes", list(scene_drives(arguments.seeds)), with_mistakes=True)


if __name__ == "__main__":
    main()
