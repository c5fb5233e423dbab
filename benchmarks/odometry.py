"""Visual odometry against OXTS on KITTI's images, its speed, and what it is worth to a tracker.

    python -m benchmarks.odometry --root KITTI [--clips 0000:0-153 0001:0-50 ...] [--features ...]

Medians over the frames of each clip: rotation error, error of the direction of motion (frames
with more than 0.1 m), error of its length. OXTS gives the nearest of its samples, +-5 ms, so
that its steps zigzag by 5 % from frame to frame; the length is therefore compared with its
running mean over three frames, too. Speed: frames a second of one core's time (the process's
CPU time, one OpenCV thread, images decoded beforehand). Without --root: synthetic drives only.
"""

import argparse
import logging
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time

import cv2
import numpy as np
from numpy import ndarray as Array

from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.evaluation.runs import track_sequence
from mot_sim.metrics import evaluate
from tests.tracker.ego.corridor import CAMERA, NO_BOXES, filmed, misses
from tracker import TRACKERS
from tracker.ego import CornerFlow, Features, VisualOdometry

CLIPS = ("0000:0-153", "0001:0-50", "0005:0-15", "0009:47-62")
MOVING = 0.1  # metres a frame from which a direction is compared
SYNTHETIC = {
    "straight, 9 m/s": ((0.9, 0.0),) * 20,
    "curve, 7 m/s, 7 deg/s": ((0.7, 0.012),) * 20,
    "braking at 3 m/s^2": tuple((0.9 - 0.03 * step, 0.0) for step in range(20)),
}


@dataclass(frozen=True)
class OrbMatches:
    """The other way to find points: ORB, the best match of each by Hamming, a ratio test."""

    count: int = 2000
    ratio: float = 0.8

    def __call__(self, before: Array, now: Array, free: Array) -> tuple[Array, Array]:
        """Pixels in `before`, all of them where `free`, and the same points in `now`."""
        orb = cv2.ORB_create(self.count)
        points, descriptors = orb.detectAndCompute(before, free.astype(np.uint8) * 255)
        others, theirs = orb.detectAndCompute(now, None)
        if descriptors is None or theirs is None:
            return np.zeros((0, 2)), np.zeros((0, 2))
        pairs = cv2.BFMatcher(cv2.NORM_HAMMING).knnMatch(descriptors, theirs, k=2)
        good = [p[0] for p in pairs if len(p) == 2 and p[0].distance < self.ratio * p[1].distance]
        start = np.array([points[match.queryIdx].pt for match in good]).reshape(-1, 2)
        end = np.array([others[match.trainIdx].pt for match in good]).reshape(-1, 2)
        return start, end


FEATURES: dict[str, Features] = {"corner flow": CornerFlow(), "ORB": OrbMatches()}


def clip(root: Path, text: str) -> KittiSequence:
    """The frames of `SSSS:first-last`, with images and OXTS."""
    name, _, frames = text.partition(":")
    first, _, last = frames.partition("-")
    drive: KittiSequence = kitti_sequence(root, name, images=True)
    return drive.subset(range(int(first), int(last) + 1))


def measured(drive: KittiSequence, features: Features) -> tuple[Array, float]:
    """Errors (rotation, direction, length, length against three frames' mean); seconds a frame."""
    frames = list(drive)
    odometry = VisualOdometry(drive.camera, features=features)
    start = process_time()
    seen = [odometry.step(frame.image, frame.detections.boxes)[0] for frame in frames]
    seconds = (process_time() - start) / len(frames)
    rows, pairs = [], []
    for frame, T in zip(frames, seen, strict=True):
        if T is None or frame.T_now_before is None:
            continue
        true = float(np.linalg.norm(frame.T_now_before[:3, 3]))
        rotation, direction, length = misses(T, frame.T_now_before)
        rows.append((rotation, direction if true > MOVING else np.nan, length, np.nan))
        pairs.append((float(np.linalg.norm(T[:3, 3])), true))
    table, (mine, true) = np.array(rows), np.array(pairs).T
    table[1:-1, 3] = mine[1:-1] / np.convolve(true, np.full(3, 1.0 / 3.0), "valid") - 1.0
    return table, seconds


def line(name: str, frames: int, table: Array, seconds: float) -> None:
    """A row of the table of clips."""
    middle = np.nanmedian(np.abs(table), axis=0)
    print(
        f"| {name} | {len(table)} of {frames - 1} | {middle[0]:.3f} | {middle[1]:.2f} | "
        f"{100 * middle[2]:.1f} | {100 * middle[3]:.1f} | {1.0 / seconds:.1f} |"
    )


def head(title: str) -> None:
    """Of the tables of clips."""
    print(f"\n{title}\n")
    print(
        "| drive | motions | rotation, deg | direction, deg | length, % | %, 3 frames | frames/s |"
    )
    print("|---|---|---|---|---|---|---|")


def clips_table(root: Path, clips: list[str], names: list[str]) -> None:
    """Every clip, and all of them together."""
    drives = [clip(root, text) for text in clips]
    for name in names:
        head(f"{name} against OXTS")
        tables, times, count = [], [], 0
        for text, drive in zip(clips, drives, strict=True):
            table, seconds = measured(drive, FEATURES[name])
            line(text, len(drive), table, seconds)
            tables.append(table)
            times.append(seconds * len(drive))
            count += len(drive)
        whole = np.concatenate(tables)
        line("all", count - len(drives) + 1, whole, sum(times) / count)


def synthetic_table() -> None:
    """Drives through a street of textured walls, 620 x 188 pixels."""
    head("synthetic drives against the truth")
    for name, steps in SYNTHETIC.items():
        images, truth = filmed(steps)
        odometry, rows = VisualOdometry(CAMERA), []
        start = process_time()
        seen = [odometry.step(image, NO_BOXES)[0] for image in images]
        seconds = (process_time() - start) / len(images)
        for T, true in zip(seen[1:], truth, strict=True):
            if T is not None:
                rows.append((*misses(T, true), misses(T, true)[2]))
        line(name, len(images), np.array(rows), seconds)


def tracking_table(root: Path, clips: list[str]) -> None:
    """Trackers over the frames that have images, with each source of motion."""
    print(
        "\n| tracker | clip | ego | switches | FP | FN | fragments |\n|---|---|---|---|---|---|---|"
    )
    for text in clips:
        indices = clip(root, text).frame_indices
        for tracker, build in TRACKERS.items():
            for ego in ("oxts", "visual", "orbslam3", "none"):
                drive = kitti_sequence(root, text.partition(":")[0], ego=ego).subset(indices)
                if drive.truth is None:
                    continue
                tracks, _ = track_sequence(build(drive.camera), drive)
                truth = replace(drive.truth, frames=drive.truth.frames - indices[0])
                moved = replace(tracks, frames=tracks.frames - indices[0])
                score = evaluate({drive.name: (truth, moved, len(drive))}).combined
                counts = [f"{score[each]:.0f}" for each in ("IDSW", "CLR_FP", "CLR_FN", "Frag")]
                print(f"| {tracker} | {text} | {ego} | {' | '.join(counts)} |")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, help="the KITTI tree, with images")
    parser.add_argument("--clips", nargs="+", default=list(CLIPS), help="SSSS:first-last")
    parser.add_argument("--features", nargs="+", choices=list(FEATURES), default=list(FEATURES))
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    cv2.setNumThreads(1)
    synthetic_table()
    if arguments.root is not None:
        clips_table(arguments.root, arguments.clips, arguments.features)
        tracking_table(arguments.root, arguments.clips)


if __name__ == "__main__":
    main()
