"""Does the testbed foretell what a tracker does on KITTI? The same trackers on both kinds of drive.

    python -m benchmarks.closed_loop --root KITTI [--detections rrc] [--seeds 10] [--cache DIR]

The labelled cars of the ten given sequences are re-enacted: replayed as worlds, cast with cars of
our fleet, drawn, and measured pixel by pixel; the profile sees them in place of the detector.
Camera, ego-motion and scoring stay KITTI's, and so do the labels' levels and DontCare regions, on
both sides; on the made side a re-enacted car is scored by its own box (--label-boxes: by KITTI's,
which annotators drew somewhat wider than our cars are). Printed: every variant's MOTA, HOTA and
identity switches on KITTI beside the made ones (median over the seeds, and their range), and
Spearman's rank correlation of the variants by HOTA and by switches.

What the labels know and the replay cannot is what else hides a car: trees, walls, people, cars
without a label. So the fraction that counts is the mean of the label's and of the measured one, of
which no more counts than the upper end of the label's level.
"""

import argparse
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from benchmarks.kitti_tables import GIVEN, IMAGE
from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.evaluation.runs import track_sequence
from mot_sim.metrics import evaluate
from mot_sim.simulation.cars import VehicleSampler
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.sensors import Detector, Profile, Sightings, find_profile
from mot_sim.simulation.sensors.fitting.calibrate import fit_profile
from mot_sim.simulation.sensors.fitting.measure import LabelledDetections
from mot_sim.simulation.traffic.kitti_replay import kitti_recording
from mot_sim.simulation.truth import annotate
from tracker import Camera, Tracker, Tracks
from tracker.association import Greedy
from tracker.lifecycle import Lifecycle
from tracker.suppression import Suppression

MOST_MOTA, MOST_HOTA, MOST_IDSW, LEAST_RANK = 1.5, 2.5, 0.35, 0.9
VEHICLES = ("Car", "Van", "Truck")
HALF_A_LEVEL = 0.15  # of the visible fraction: KITTI's levels end near .8, .5 and .2
Scores = tuple[float, float, float]
Variant = tuple[str, str, Callable[[Camera], Tracker]]


def default(**changes: object) -> Callable[[Camera], Tracker]:
    """Tracker.default with some parts replaced."""
    return lambda camera: replace(Tracker.default(camera), **changes)


VARIANTS: tuple[Variant, ...] = (
    ("default", "oxts", default()),
    ("paper", "oxts", Tracker.paper),
    ("default without ego-motion", "none", default()),
    ("greedy", "oxts", default(associate=Greedy(0.7))),
    ("IoU of neighbours, Hungarian", "none", default(
        costs=((1.0, IMAGE),), lifecycle=Lifecycle(0.0, 0.0), strong_score=0.0,
    )),
    ("scores from .1", "oxts", default(suppress=Suppression(0.1, 0.5))),
    ("scores from .9, one stage", "oxts", default(
        suppress=Suppression(0.9, 0.5), strong_score=0.0,
    )),
    ("memory 0.5 s", "oxts", default(lifecycle=Lifecycle(0.8, 0.5))),
    ("no memory", "oxts", default(lifecycle=Lifecycle(0.8, 0.0))),
    ("paper, memory 0.3 s, births from .8", "oxts", lambda camera: replace(
        Tracker.paper(camera), lifecycle=Lifecycle(0.8, 0.3))),
)  # fmt: skip


@dataclass(frozen=True)
class Reenacted:
    """A drive with the sightings of its re-enactment, and the truth that they are scored by."""

    drive: KittiSequence
    sightings: Sightings
    truth: Tracks


def reenact(
    drive: KittiSequence, truth: Tracks, cache: Path | None, label_boxes: bool
) -> Reenacted:
    """The labelled vehicles of a drive, cast, drawn and measured; a row a label, as it was.

    The few without a pixel in the image (0.1 %, beside the camera) stay as the label has them.
    """
    labels = Sightings.from_labels(truth)
    if len(labels):
        mine, theirs, seen = measured(drive, labels, cache)
        exact = seen["visible"][theirs]
        known = labels.visible[mine]
        visible = labels.visible.copy()
        visible[mine] = 0.5 * (known + np.minimum(exact, known + HALF_A_LEVEL))
        columns = {"visible": visible}
        for name in ("boxes", "amodal_boxes", "visible_boxes"):
            columns[name] = getattr(labels, name).copy()
            columns[name][mine] = seen[name][theirs]
        labels = replace(labels, **columns)
    if not label_boxes:
        rows, cars = common(truth.frames, truth.ids, labels.frames, labels.ids)
        boxes = truth.boxes.copy()
        boxes[rows] = labels.boxes[cars]
        truth = replace(truth, boxes=boxes)
    return Reenacted(drive, labels, truth)


def measured(
    drive: KittiSequence, labels: Sightings, cache: Path | None
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Rows of the labels, rows of what was drawn, and its columns."""
    path = None if cache is None else cache / f"{drive.name}.npz"
    if path is not None and path.exists():
        with np.load(path, allow_pickle=False) as kept:
            columns = dict(kept)
    else:
        recording = kitti_recording(drive, VEHICLES)
        stage = SceneMeshes(VehicleSampler().sample(recording, 0), Rig(drive.camera))
        seen = Sightings.from_truth(annotate(recording.states, stage).truth)
        names = ("frames", "ids", "boxes", "amodal_boxes", "visible_boxes", "visible")
        columns = {name: getattr(seen, name) for name in names}
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            np.savez_compressed(path, **columns)
    rows = common(labels.frames, labels.ids, columns["frames"], columns["ids"])
    return *rows, columns


def common(
    frames: np.ndarray, ids: np.ndarray, other_frames: np.ndarray, other_ids: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The rows of both tables that are the same object in the same frame; DontCare is nobody."""
    one = np.where(ids >= 0, ids * (1 << 32) + frames, -1 - np.arange(len(ids)))
    other = other_ids * (1 << 32) + other_frames
    _, rows, others = np.intersect1d(one, other, assume_unique=True, return_indices=True)
    return rows, others


def synthetic(drives: Sequence[Reenacted], profile: Profile, seed: int) -> list[KittiSequence]:
    """The re-enacted drives with made detections."""
    detector, made = Detector(profile), []
    for number, each in enumerate(drives):
        drive = each.drive
        own, step, sightings = 1000 * seed + number, 1.0 / drive.frame_rate, each.sightings
        if profile.lives is not None:
            sightings = profile.lives(
                sightings, own, drive.camera, drive.frame_count, step, each.truth
            )
        sensed = detector.sense(sightings, own, drive.camera, step, np.arange(drive.frame_count))
        made.append(replace(drive, log=sensed.log))
    return made


def scores(drives: Sequence[KittiSequence], truths: Sequence[Tracks], variant: Variant) -> Scores:
    """MOTA and HOTA in percent, identity switches."""
    _, ego, build = variant
    results = {}
    for drive, truth in zip(drives, truths, strict=True):
        heard = drive if ego == "oxts" else replace(drive, Ts_world_cam=None)
        tracks, _ = track_sequence(build(drive.camera), heard)
        results[drive.name] = (truth, tracks, drive.frame_count)
    combined = evaluate(results).combined
    return 100 * combined["MOTA"], 100 * combined["HOTA"], combined["IDSW"]


def profile_of(name: str, drives: Sequence[KittiSequence], fit: bool) -> Profile:
    """The shipped profile, or one fitted here and now."""
    if not fit:
        return find_profile(name)
    labelled = [
        LabelledDetections(d.truth, d.log, d.frame_count, d.camera) for d in drives if d.truth
    ]
    return fit_profile(labelled)


def show(real: Sequence[Scores], made: np.ndarray) -> None:
    """The table, how many variants are within reach, and the ranks."""
    middle = np.median(made, axis=1)
    print(
        f"{'':40s}{'MOTA':>8s}{'made':>8s}{'HOTA':>8s}{'made':>8s}{'IDSW':>7s}{'made':>7s}  range"
    )
    for (name, _, _), kitti, ours, each in zip(VARIANTS, real, middle, made, strict=True):
        print(
            f"{name:40s}{kitti[0]:8.2f}{ours[0]:8.2f}{kitti[1]:8.2f}{ours[1]:8.2f}"
            f"{kitti[2]:7.0f}{ours[2]:7.0f}  {each[:, 2].min():.0f}-{each[:, 2].max():.0f}"
        )
    kitti = np.array(real)
    off = np.abs(middle - kitti)
    off[:, 2] /= np.maximum(kitti[:, 2], 1.0)
    for column, (name, limit) in enumerate(
        (("MOTA", MOST_MOTA), ("HOTA", MOST_HOTA), ("IDSW, relative", MOST_IDSW))
    ):
        inside, worst = int((off[:, column] <= limit).sum()), off[:, column].max()
        print(f"{name}: {inside} of {len(off)} variants within {limit:g}, worst {worst:.2f}")
    for column, name in ((1, "HOTA"), (2, "IDSW")):
        rank = float(spearmanr(kitti[:, column], middle[:, column]).statistic)
        print(f"rank correlation by {name}: {rank:.3f} (goal {LEAST_RANK:g})")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--detections", default="rrc")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--cache", type=Path, help="folder that keeps what was drawn")
    parser.add_argument("--label-boxes", action="store_true", help="score by KITTI's boxes")
    parser.add_argument("--labels-only", action="store_true", help="nothing is drawn")
    parser.add_argument("--profile", help="a name or a file; without: the detections' own")
    parser.add_argument("--fit", action="store_true", help="fit the profile now")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    drives = [kitti_sequence(arguments.root, name, arguments.detections) for name in GIVEN]
    profile = profile_of(arguments.profile or arguments.detections, drives, arguments.fit)
    labels = [drive.truth for drive in drives if drive.truth is not None]
    real = [scores(drives, labels, variant) for variant in VARIANTS]
    stages = [
        Reenacted(drive, Sightings.from_labels(truth), truth)
        if arguments.labels_only
        else reenact(drive, truth, arguments.cache, arguments.label_boxes)
        for drive, truth in zip(drives, labels, strict=True)
    ]
    truths = [each.truth for each in stages]
    made = np.zeros((len(VARIANTS), arguments.seeds, 3))
    for seed in range(arguments.seeds):
        seen = synthetic(stages, profile, seed)
        for number, variant in enumerate(VARIANTS):
            made[number, seed] = scores(seen, truths, variant)
    print(
        f"{arguments.detections}: KITTI beside the profile {profile.name}, {arguments.seeds} seeds"
    )
    show(real, made)


if __name__ == "__main__":
    main()
