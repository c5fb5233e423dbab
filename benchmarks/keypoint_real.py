"""The keypoint network on real pixels: yaw against labels, keypoints against people's.

Called by `benchmarks.keypoints`. KITTI's labels of the clips 0000, 0005 and 0009 are judged on;
nothing was trained on them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy import ndarray as Array

from benchmarks.shape_real import CROP_CONFIDENCE, CROP_SHARE, yaw_error
from benchmarks.shape_samples import from_crops, real_cars
from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.datasets.images import ImageFolder
from tracker.geometry import box_iou
from tracker.shape import KEYPOINTS_14, KEYPOINTS_36, CarModel, Hourglass, ShapeFit, load_prior
from tracker.types import Tracks

CLIPS = ("0000", "0005", "0009")
DETECTOR = "rrc"
SHARE = 0.05  # of a box's sides: what the fit is told a keypoint at confidence 1 is off by
PCK_SHARE = 0.1
NEAR = 30.0  # metres
FAR, HALF_HIDDEN = 60.0, 1  # metres and KITTI's occlusion: of the others, which were not looked at
SAME = 0.7  # overlap of a detection and its label


@dataclass(frozen=True, eq=False)
class Scored:
    """Cars of a clip: their labels, the boxes that were given, keypoints, yaw errors in degrees,
    whether they fit and are trusted, and how much less likely they are turned round."""

    labels: Tracks
    boxes: Array
    keypoints: Array
    error: Array
    trusted: Array
    fits: Array
    turned_gap: Array


def pictures(root: Path, sequence: KittiSequence) -> ImageFolder:
    """The images of a sequence."""
    return ImageFolder.require(root / "training" / "image_02" / sequence.name)


def bgr_of(folder: ImageFolder, frame: int) -> Array:
    """A frame as OpenCV reads it."""
    image = cv2.imread(str(folder.paths[frame]), cv2.IMREAD_COLOR)
    assert image is not None
    return image


def cars_of(sequence: KittiSequence, folder: ImageFolder, others: bool = False) -> Tracks:
    """The labelled cars and vans of the frames with images, unoccluded, whole and near.

    others: instead those that are farther or partly hidden.
    """
    truth = sequence.truth
    assert truth is not None
    assert truth.cuboids is not None
    assert truth.occlusion is not None
    assert truth.truncation is not None
    there = np.isin(truth.frames, list(folder.paths)) & np.isin(truth.kinds, ["Car", "Van"])
    there &= truth.truncation == 0
    near = (truth.occlusion == 0) & (truth.cuboids.base[:, 2] < NEAR)
    far = (truth.occlusion <= HALF_HIDDEN) & (truth.cuboids.base[:, 2] < FAR) & ~near
    return truth.select(there & (far if others else near))


def detected_boxes(root: Path, sequence: KittiSequence, labels: Tracks) -> Array:
    """For each label the detection that covers it best; NaN where none does."""
    found = kitti_sequence(root, sequence.name, detections=DETECTOR)
    boxes = np.full((len(labels), 4), np.nan)
    for frame in found:
        rows = np.flatnonzero(labels.frames == frame.index)
        if not len(rows) or not len(frame.detections):
            continue
        overlap = box_iou(labels.boxes[rows][:, None], frame.detections.boxes[None])
        best = overlap.argmax(axis=1)
        good = overlap.max(axis=1) >= SAME
        boxes[rows[good]] = frame.detections.boxes[best[good]]
    return boxes


def scored(
    hourglass: Hourglass, sequence: KittiSequence, folder: ImageFolder, labels: Tracks, boxes: Array
) -> Scored:
    """Keypoints in boxes, the fit to them, and how far its yaw is from the label's."""
    keypoints = np.full((len(labels), len(KEYPOINTS_36), 3), np.nan)
    for frame in np.unique(labels.frames).tolist():
        rows = np.flatnonzero(labels.frames == frame)
        keypoints[rows] = hourglass(bgr_of(folder, frame), boxes[rows]).keypoints
    fitted = ShapeFit()(keypoints, sequence.camera, SHARE * (boxes[:, 2:] - boxes[:, :2]))
    assert labels.cuboids is not None
    return Scored(
        labels, boxes, keypoints, yaw_error(fitted, labels.cuboids.yaw), fitted.trusted,
        fitted.fits, fitted.turned_gap,
    )  # fmt: skip


def clips(
    hourglass: Hourglass, root: Path, detected: bool = False, others: bool = False
) -> Iterator[tuple[str, Scored]]:
    """The clips with images, from the labels' boxes or a detector's; others: see `cars_of`."""
    for name in CLIPS:
        sequence = kitti_sequence(root, name, detections=None)
        folder = pictures(root, sequence)
        labels = cars_of(sequence, folder, others)
        boxes = detected_boxes(root, sequence, labels) if detected else labels.boxes
        yield name, scored(hourglass, sequence, folder, labels, boxes)


def yaw_on_clips(hourglass: Hourglass, root: Path) -> None:
    """A line a clip, for both kinds of boxes."""
    print(
        f"yaw error, unoccluded cars and vans nearer than {NEAR:g} m, degrees: cars, fitted, "
        "trusted; median, 90 % of fitted; flips; median of trusted, flips; cars without vans: "
        "fitted, median, flips"
    )
    kinds = (
        ("labels' boxes", False, False),
        (f"{DETECTOR}'s boxes", True, False),
        (f"{DETECTOR}'s boxes, to {FAR:g} m or half hidden", True, True),
    )
    for what, detected, others in kinds:
        every = list(clips(hourglass, root, detected, others))
        rows = [(one.error, one.trusted, one.labels.kinds) for _, one in every]
        for (name, _), row in zip(every, rows, strict=True):
            print(f"  {name} {what}: {line_of(*row)}")
        together = [np.concatenate(part) for part in zip(*rows, strict=True)]
        print(f"  all  {what}: {line_of(*together)}")


def line_of(error: Array, trusted: Array, kinds: Array) -> str:
    """Counts and medians."""
    fitted = np.isfinite(error)
    sure = error[fitted & trusted]
    car = error[fitted & (kinds == "Car")]
    middle = np.median(error[fitted]) if fitted.any() else np.nan
    high = np.percentile(error[fitted], 90) if fitted.any() else np.nan
    return (
        f"{len(error):4d} {fitted.sum():4d} {len(sure):4d}  {middle:6.2f} {high:6.1f} "
        f"{(error[fitted] > 90).sum():3d}  {np.median(sure) if len(sure) else np.nan:6.2f} "
        f"{(sure > 90).sum():3d}  {len(car):4d} {np.median(car) if len(car) else np.nan:6.2f} "
        f"{(car > 90).sum():3d}"
    )


def annotated_pck(hourglass: Hourglass, root: Path, prior: Path) -> None:
    """PCK on the frames whose keypoints people set, where the tree has the image."""
    folder = prior / "keypoints" / "kp36"
    crops = np.loadtxt(folder / "annotated.txt").reshape(-1, len(KEYPOINTS_36), 3)
    right, sure = [], []
    for crop, row in zip(crops, np.loadtxt(folder / "annInfofile.txt"), strict=True):
        sequence = kitti_sequence(root, f"{int(row[1]):04d}", detections=None)
        images = ImageFolder.find(root / "training" / "image_02" / sequence.name)
        if images is None or int(row[2]) not in images.paths or sequence.truth is None:
            continue
        truth = sequence.truth
        own = truth.select((truth.frames == int(row[2])) & (truth.ids == int(row[3])))
        wanted = from_crops(crop[None], own.boxes)[0]
        found = hourglass(bgr_of(images, int(row[2])), own.boxes).keypoints[0]
        longer = (own.boxes[0, 2:] - own.boxes[0, :2]).max()
        near = np.hypot(*(found[:, :2] - wanted[:, :2]).T) <= PCK_SHARE * longer
        right.append(near)
        sure.append(found[:, 2] >= 0.5)
    if not right:
        print("no image of the hand-annotated frames")
        return
    near, seen = np.array(right), np.array(sure)
    print(f"hand-annotated: {len(near)} frames; PCK@0.1 of all 36 points, hidden ones too: "
          f"{near.mean():.3f}; of the {seen.sum()} that the network says it sees: "
          f"{near[seen].mean() if seen.any() else np.nan:.3f}")  # fmt: skip


def published_beside_ours(hourglass: Hourglass, root: Path, prior: Path) -> None:
    """Yaw from the published hourglass's 14 keypoints and from ours, on the same cars."""
    theirs = ShapeFit(
        CarModel(load_prior(points=KEYPOINTS_14).first(5)), min_confidence=CROP_CONFIDENCE
    )
    print("the published hourglass and ours on the same cars: cars; median yaw error, degrees")
    for cars in real_cars(prior / "keypoints" / "kp14", root):
        images = ImageFolder.find(root / "training" / "image_02" / cars.sequence.name)
        there = [
            images is not None and frame in images.paths for frame in cars.labels.frames.tolist()
        ]
        rows = np.flatnonzero(there)
        if images is None or not len(rows):
            continue
        labels = cars.labels.select(rows)
        assert labels.cuboids is not None
        fitted = theirs(cars.keypoints[rows], cars.sequence.camera, CROP_SHARE * cars.sides[rows])
        published = yaw_error(fitted, labels.cuboids.yaw)
        ours = scored(hourglass, cars.sequence, images, labels, labels.boxes).error
        print(
            f"  {cars.name}: {len(rows)}; {np.nanmedian(published):.2f}, {np.nanmedian(ours):.2f}"
        )
