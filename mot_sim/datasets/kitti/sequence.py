"""A sequence of the KITTI tracking benchmark: calibration, detections, ego-motion, labels."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.detection_files import BadBoxes, DetectionFormat, ScoreMap, read_detections
from mot_sim.datasets.images import ImageFolder
from mot_sim.datasets.kitti.calibration import CAMERA_HEIGHT_METRES, Calibration, read_calibration
from mot_sim.datasets.kitti.detectors import DETECTORS
from mot_sim.datasets.kitti.ego import EGO, ImageMotion, PoseFiles, VisualEgo, oxts_path
from mot_sim.datasets.kitti.labels import cuboids_of_rows, read_labels
from mot_sim.datasets.kitti.places import (
    DEFAULT_SIZE,
    TRAINING_FRAMES,
    TRAINING_SIZES,
    beside_the_splits,
    find_root,
    require_file,
    require_sequence,
    training_row,
)
from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from mot_sim.files.text import count_rows
from tracker.ego import EgoScale
from tracker.errors import BadConfig, BadFile, DatasetNotFound, UnknownName
from tracker.types import Cuboids, Detections, Tracks

# With this share of the frames of KITTI's sequence of its name, an OXTS file is that one's.
MIN_OXTS_SHARE = 0.9


@dataclass(frozen=True, eq=False)
class KittiSequence(RecordedSequence):
    """A recorded drive with KITTI's calibration and, where there are any, its labels."""

    calibration: Calibration | None = None
    """Where the sensors stand; None: the labels are in the camera's own frame."""
    label_path: Path | None = None
    """File of the labels; None: there are none."""

    @property
    def T_road_label(self) -> Float[Array, "4 4"]:
        """From the frame of KITTI's labels (camera 0) to the road frame of the camera."""
        calibration = self.calibration or Calibration(self.camera.K)
        return self.camera.T_road_cam @ calibration.T_cam_label

    @cached_property
    def truth(self) -> Tracks | None:
        """The labels, read when first asked for; None for a sequence that has none.

        A subset has the labels of its frames.
        """
        if self.label_path is None:
            return None
        labels = read_labels(self.label_path, self.T_road_label, self.frame_count)
        if len(self) == self.frame_count:
            return labels
        return labels.select(np.isin(labels.frames, self.frame_indices))


def kitti_sequence(
    root: Path | str | None,
    name: str,
    detections: str | Path | None = "rrc",
    ego: str = "oxts",
    images: bool = False,
    *,
    split: str = "training",
    height: float = CAMERA_HEIGHT_METRES,
    pitch: float = 0.0,
    detection_format: str | None = None,
    bad_boxes: BadBoxes | None = None,
    score_map: ScoreMap | None = None,
    every: int | None = None,
    kinds: tuple[str, ...] | None = None,
    cuboids: bool = False,
    metric: bool = True,
) -> KittiSequence:
    """A sequence of a KITTI tree, at 10 Hz.

    root: the folder that holds `training`; None takes it from the environment.
    detections: a name of DETECTORS, read from `<root>/detections/<name>/SSSS.txt`; or a folder
    of such files, or one file, with detection_format naming its format; or None, for a drive in
    which nothing was detected; or names with commas, for detectors of several classes. kinds: the
    classes whose boxes are read, of TRACKED_KINDS; None: those that the detectors are for.
    ego: a name of EGO; `visual` reads the images as the drive is played, whatever `images` says.
    images: load the frames' images, one by one while iterating; frames without one get None.
    height, pitch: of the camera above the road, metres and radians. bad_boxes: see
    `read_detections`. score_map: in place of the format's own. every: only every so many-th frame
    was looked at; None: as the boxes say, see `RecordedSequence.looked_at_every`. cuboids: whether
    those of a LiDAR detector are read too, see `Detections.base`. metric: False: the poses in
    files have a scale of their own, which is found while the drive is played, see `EgoScale`.
    For the testing split, detections and odometry lie in a folder `testing` of their own.
    Raises DatasetNotFound, UnknownName, BadFile, BadCalibration.
    """
    root = find_root(root)
    if ego not in EGO:
        raise UnknownName.of("ego-motion", ego, EGO)
    source = EGO[ego]
    if not metric:
        if not isinstance(source, PoseFiles):
            raise BadConfig(f"--ego-scale auto: ego-motion {ego} is in metres; name orbslam3")
        source = replace(source, metric=False)
    detected = []
    for each in _detectors(detections, detection_format):
        path, form = _detection_file(root, split, name, each, detection_format)
        detected.append((path, form if score_map is None else replace(form, score_map=score_map)))
    kinds = _all_kinds(detected) if kinds is None else kinds
    detected = _of_kinds(detected, kinds)
    folder = require_sequence(root, split, name)
    calibration = read_calibration(folder / "calib" / f"{name}.txt")
    image_folder = folder / "image_02" / name
    found = ImageFolder.require(image_folder) if images else ImageFolder.find(image_folder)
    if found is None and isinstance(EGO[ego], VisualEgo):
        raise DatasetNotFound(
            f"{image_folder}: no numbered images, in which ego-motion '{ego}' is seen; give "
            "000000.png, ..., or take another ego-motion: oxts, orbslam3, none"
        )
    number = training_row(name, split)
    known_size = DEFAULT_SIZE if number is None else TRAINING_SIZES[number]
    camera = calibration.camera(found.image_size if found else known_size, height, pitch)
    oxts = oxts_path(root, split, name)
    counted_in = oxts if oxts.is_file() else None
    frame_count = _frame_count(counted_in, name, number, found)
    T_road_label = camera.T_road_cam @ calibration.T_cam_label

    def reads_cuboids(rows: Float[Array, "n 7"]) -> Cuboids:
        return cuboids_of_rows(rows, T_road_label)[0]

    log = DetectionLog(np.zeros(0, np.int64), Detections.empty())
    if detected:
        log = DetectionLog.merged(
            read_detections(
                path,
                form,
                camera.image_size,
                frame_count,
                bad_boxes,
                counted_in,
                reads_cuboids if cuboids else None,
            )
            for path, form in detected
        )
    labels = folder / "label_02" / f"{name}.txt"
    if frame_count is None:
        frame_count = int(log.frames.max(initial=-1)) + 1
        if labels.is_file():
            frame_count = max(frame_count, int(read_labels(labels).frames.max(initial=-1)) + 1)
    Ts_world_cam = source.poses(root, split, name, calibration, frame_count)
    motion = _seen_motion(ego, found, None if number is None else known_size, frame_count)
    if images and found is not None and motion is None:
        found.warn_of_gaps(frame_count)
    sequence = KittiSequence(
        name=name,
        camera=camera,
        frame_count=frame_count,
        log=log,
        frame_indices=np.arange(frame_count),
        Ts_world_cam=Ts_world_cam,
        motion_cov=source.motion_cov,
        images=found if images else None,
        motion=motion,
        calibration=calibration,
        label_path=labels if split == "training" and labels.is_file() else None,
        kinds=kinds,
        ego_scale=None if metric else EgoScale(camera),
    )
    return sequence.looked_at_every(every)


def _seen_motion(
    ego: str, images: ImageFolder | None, image_size: tuple[int, int] | None, frame_count: int
) -> ImageMotion | None:
    """The measured motion in the images, for a source of ego-motion that uses them."""
    source = EGO[ego]
    if images is None or not isinstance(source, VisualEgo):
        return None
    return source.image_motion(images, image_size, frame_count)


def _frame_count(
    oxts: Path | None, name: str, number: int | None, images: ImageFolder | None
) -> int | None:
    """From OXTS, else from KITTI's list, else from the images; None when only rows can say.

    BadFile for OXTS that lacks lines: a blank one, or a few less than KITTI's sequence has.
    """
    known = None if number is None else TRAINING_FRAMES[number]
    if oxts is not None:
        count = count_rows(oxts)
        if known is not None and MIN_OXTS_SHARE * known <= count != known:
            raise BadFile(
                f"{oxts}: {count} lines where KITTI's sequence {name} has {known} frames; give "
                "one line per frame (or another name to a sequence that is not KITTI's)"
            )
        return count
    if images is not None and number is None:
        return max(images.paths) + 1
    return known


def _detectors(detections: str | Path | None, detection_format: str | None) -> list[str | Path]:
    """The detectors that `detections` names: none, one (or a path), or several with commas."""
    if detections is None:
        return []
    if detection_format is None and isinstance(detections, str) and "," in detections:
        return [name.strip() for name in detections.split(",")]
    return [detections]


def _of_kinds(
    detected: list[tuple[Path, DetectionFormat]], kinds: tuple[str, ...]
) -> list[tuple[Path, DetectionFormat]]:
    """The files that can hold boxes of these classes, with formats that keep no others.

    Raises BadConfig for a class that no file can hold.
    """
    chosen = []
    for path, form in detected:
        possible = form.tracked if form.kinds is None else form.kinds.values()
        held = tuple(kind for kind in kinds if kind in possible)
        if held:
            chosen.append((path, replace(form, tracked=held)))
    lacking = set(kinds) - set(_all_kinds(chosen))
    if lacking and detected:
        raise BadConfig(
            f"{', '.join(str(path) for path, _ in detected)}: no boxes of {min(lacking)} are "
            "there; name a detector of that class too (--detections rrc,rrc_pedestrian), or leave "
            "the class out"
        )
    return chosen


def _all_kinds(detected: list[tuple[Path, DetectionFormat]]) -> tuple[str, ...]:
    """The classes of all files, each once."""
    return tuple(dict.fromkeys(kind for _, form in detected for kind in form.tracked)) or ("Car",)


def _detection_file(
    root: Path, split: str, name: str, detections: str | Path, detection_format: str | None
) -> tuple[Path, DetectionFormat]:
    """The file of a sequence's detections and its format."""
    given = Path(detections)
    if detection_format is None:
        if detections not in DETECTORS and given.exists():
            raise BadConfig(
                f"detections {given}: name their format too, --detection-format NAME; known: "
                f"{', '.join(sorted(DETECTORS))}"
            )
        if detections not in DETECTORS:
            raise UnknownName.of("detector", str(detections), DETECTORS)
    elif detection_format not in DETECTORS:
        raise UnknownName.of("detection format", detection_format, DETECTORS)
    form = DETECTORS[detection_format or str(detections)]
    if detection_format is not None and given.is_file():
        return given, form
    beside = beside_the_splits(root, "detections", str(detections), split)
    folder = given if detection_format is not None and given.is_dir() else beside
    path = folder / f"{name}.txt"
    return require_file(path, "detections", "give them, or choose --detections NAME"), form
