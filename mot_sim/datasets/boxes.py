"""A drive of your own: given as a file of boxes and camera.toml."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array
from numpy.lib.recfunctions import append_fields

from mot_sim.datasets.box_tables import read_box_table
from mot_sim.datasets.camera_files import CameraFile, read_camera
from mot_sim.datasets.detection_files import (
    BadBoxes,
    ScoreMap,
    check_detections,
    kinds_of_rows,
)
from mot_sim.datasets.estimate_files import ESTIMATES_SUFFIX
from mot_sim.datasets.images import ImageFolder
from mot_sim.datasets.kitti.ego import ORBSLAM3_MOTION_STD, ImageMotion
from mot_sim.datasets.kitti.labels import in_order
from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.datasets.trajectories import read_trajectory
from mot_sim.files.text import TextTable, read_text
from tracker.ego import EgoScale
from tracker.errors import BadConfig, BadFile, DatasetNotFound
from tracker.types import TRACKED_KINDS, Tracks, spelled_as_kitti

# How files of boxes end.
BOX_FILES = (".csv", ".json", ".txt")
# What a folder of results holds besides.
RUN_FILE = "run.json"


def box_sequence(
    boxes: Path | str,
    camera: Path | str | CameraFile,
    images: Path | str | None = None,
    poses: Path | str | None = None,
    name: str | None = None,
    *,
    motion_cov: Float[Array, "6 6"] | None = None,
    visual: bool = False,
    bad_boxes: BadBoxes = "error",
    score_map: ScoreMap | None = None,
    every: int | None = None,
    kinds: tuple[str, ...] | None = None,
    metric: bool = True,
) -> RecordedSequence:
    """The drive in a table of boxes and a camera file.

    boxes: a CSV file whose header names its columns, `frame,x_min,y_min,x_max,y_max,score` in
    any order, score optional (1 then), and, if there are any, class, id, time (seconds), yaw
    (radians), length_m,height_m,width_m; or another format that `read_box_table` knows. Frames
    count from 0, pixel centres are integers; boxes are clipped to the image. With a column time
    frames have those times (between them, interpolated); without a column frame they are numbered
    by them. kinds: the classes that are kept; None: those of TRACKED_KINDS that are there.
    camera: a file, see `read_camera`, or what it holds; with distortion, boxes are taken to the
    pinhole's image.
    images: a folder of 000000.png, ... .
    poses: of the camera, see `read_trajectory`; without them its motion is unknown. metric: they
    are in metres; False: their scale is found while the drive is played, see `EgoScale`.
    motion_cov: of the motion that the poses give over one frame; by default that of ORB-SLAM3 on
    KITTI. visual: the motion is seen in the images. name: the file's, unless given. score_map: from
    the scores to probabilities; None: they are ones. every: only every so many-th frame was looked
    at; None: as the boxes say, see `RecordedSequence.looked_at_every`.
    There are as many frames as poses (those without times), else as images, else up to the last
    box.
    """
    if visual and (images is None or poses is not None):
        raise BadConfig("motion seen in images needs images, and no poses: give one or the other")
    if poses is None and not metric:
        raise BadConfig("--ego-scale auto is for poses in a file: give --ego FILE")
    table, form = read_box_table(_require(Path(boxes), "boxes"), kinds)
    table, moments = _timed(table)
    described = camera if isinstance(camera, CameraFile) else read_camera(Path(camera))
    where = "the camera" if isinstance(camera, CameraFile) else camera
    folder = None if images is None else ImageFolder.require(Path(images))
    image_size = described.camera.image_size
    if folder is not None and folder.image_size != image_size:
        raise BadConfig(
            f"{where}: image_width and image_height are {image_size[0]}x{image_size[1]}, the "
            f"images in {images} have {folder.image_size[0]}x{folder.image_size[1]} pixels"
        )
    frame_count = None if folder is None else max(folder.paths) + 1
    form = form if score_map is None else replace(form, score_map=score_map)
    known_count = frame_count if poses is None else None  # otherwise there is one frame per pose
    log = check_detections(table, form, image_size, known_count, bad_boxes)
    last_box = int(table["frame"].max(initial=form.first_frame - 1)) - form.first_frame
    needed = max(last_box + 1, frame_count or 0)
    Ts_world_cam = times = None
    if poses is not None:
        path = _require(Path(poses), "pose file")
        trajectory = read_trajectory(path, described.frame_rate, metric)
        if trajectory.times is None:
            reason = f"{boxes if needed == last_box + 1 else images} reaches frame {needed - 1}"
            frame_count = trajectory.require_frames(needed, reason)
        else:
            frame_count = needed
        times = _frame_times(moments, frame_count, described.frame_rate)
        Ts_world_cam = trajectory.at(
            np.arange(frame_count) / described.frame_rate if times is None else times
        )
    elif frame_count is None:
        frame_count = last_box + 1
    times = _frame_times(moments, frame_count, described.frame_rate) if times is None else times
    lens, camera_seen = described.distortion, described.camera
    if lens is not None:
        if folder is not None:
            raise BadConfig(
                f"{where}: distortion and {images}: images are measured as a pinhole sees them; "
                "undistort them and the boxes, and leave distortion out"
            )
        straight = lens.undistort_boxes(log.detections.boxes)
        log = replace(log, detections=log.detections.replaced(boxes=straight))
        camera_seen = lens.pinhole
    if folder is not None:
        folder.warn_of_gaps(frame_count)
    if motion_cov is None and Ts_world_cam is not None:
        motion_cov = np.diag(ORBSLAM3_MOTION_STD) ** 2
    sequence = RecordedSequence(
        name=Path(boxes).stem if name is None else name,
        camera=camera_seen,
        frame_count=frame_count,
        log=log,
        frame_indices=np.arange(frame_count),
        Ts_world_cam=Ts_world_cam,
        motion_cov=motion_cov,
        images=folder,
        motion=ImageMotion(folder) if visual and folder is not None else None,
        frame_rate=described.frame_rate,
        times=times,
        kinds=form.tracked,
        distortion=lens,
        ego_scale=None if metric else EgoScale(camera_seen),
    )
    return sequence.looked_at_every(every)


# Frames and their times, both increasing.
Moments = tuple[Int[Array, " k"], Float[Array, " k"]]


def _timed(table: TextTable) -> tuple[TextTable, Moments | None]:
    """The table with a column `frame`, and the times of its frames; None without a column time.

    BadFile for times that go back from one frame to the next, and for two times in a frame.
    """
    if "time" not in (table.rows.dtype.names or ()):
        return table, None
    seconds = table.finite(["time"])[:, 0]
    if "frame" not in (table.rows.dtype.names or ()):
        moments, frames = np.unique(seconds, return_inverse=True)
        numbered = append_fields(table.rows, "frame", frames.astype(float), usemask=False)
        return replace(table, rows=numbered), (np.arange(len(moments)), moments)
    frames = table.integers("frame")
    order = np.argsort(frames, kind="stable")
    steps, elapsed = np.diff(frames[order]), np.diff(seconds[order])
    wrong = np.zeros(len(table), bool)
    wrong[order[1:]] = np.where(steps > 0, elapsed <= 0.0, elapsed != 0.0)
    cure = "each frame has one time, later than that of the frame before it"
    table.reject(wrong, "a time that does not fit its frame", ["frame", "time"], cure)
    numbers, first = np.unique(frames, return_index=True)
    return table, (numbers, seconds[first])


def _frame_times(
    moments: Moments | None, frame_count: int, frame_rate: float
) -> Float[Array, " m"] | None:
    """The time of every frame: as stated, between two such interpolated, beyond by the rate."""
    if moments is None or not len(moments[0]):
        return None
    frames, seconds = moments
    wanted = np.arange(frame_count)
    times = np.interp(wanted, frames, seconds)
    times += np.minimum(wanted - frames[0], 0) / frame_rate
    times += np.maximum(wanted - frames[-1], 0) / frame_rate
    return times


def _require(path: Path, what: str) -> Path:
    if not path.is_file():
        raise DatasetNotFound(f"{path}: no {what}; is the path right?")
    return path


def tracks_of_boxes(path: Path) -> Tracks:
    """The rows of a file of boxes with ids as tracks, in the order of frames; see `read_box_table`.

    Rows of classes that are not tracked stay, as labels need them; DontCare has id -1. Raises
    BadFile for a file without ids and for an id twice in a frame. A file .txt without a line, as
    drives without a row get it, has none.
    """
    if _require(path, "boxes").suffix == ".txt" and not read_text(path).strip():
        return Tracks.empty()
    table, form = read_box_table(path)
    table, _ = _timed(table)
    names = table.rows.dtype.names or ()
    if "id" not in names:
        raise BadFile(f"{path}: no column id: without identities nothing can be scored")
    boxes = form.boxes(table)
    inverted = np.asarray((boxes[:, 2:] < boxes[:, :2]).any(axis=1))
    cure = "write x_min,y_min,x_max,y_max or left,top,width,height"
    table.reject(inverted, "inverted box", form.box_columns, cure)
    tracks = Tracks(
        table.frames(first=form.first_frame),
        table.integers("id", -1),
        boxes,
        table.finite(["score"])[:, 0] if "score" in names else None,
        None if form.kinds is None else spelled_as_kitti(kinds_of_rows(table, form)),
        truncation=table.integers("truncated") if "truncated" in names else None,
        occlusion=table.integers("occluded") if "occluded" in names else None,
    )
    return in_order(tracks, table)


def box_files(folder: Path, what: str = "boxes") -> dict[str, Path]:
    """The files of boxes in a folder by their names, perhaps none.

    What `mot-sim track` writes beside its results is none of them.
    what: they hold, for the error. Raises BadConfig for two files of one name.
    """
    files: dict[str, Path] = {}
    for path in sorted(folder.glob("*")):
        is_beside = path.name == RUN_FILE or path.name.endswith(ESTIMATES_SUFFIX)
        if path.suffix in BOX_FILES and not is_beside:
            if path.stem in files:
                raise BadConfig(f"{path}: there are two files of {what} for {path.stem}; keep one")
            files[path.stem] = path
    return files


def box_sequences(
    boxes: Path,
    camera: Path | CameraFile,
    images: Path | None = None,
    poses: Path | None = None,
    *,
    kinds: tuple[str, ...] | None = None,
    **options: Any,
) -> list[RecordedSequence]:
    """The drives of a folder of boxes, or the one in a file; all of the same classes.

    boxes: a folder with NAME.csv, NAME.json or NAME.txt for every drive. camera, poses: of all
    drives, or a folder with NAME.toml, NAME.txt. images: a folder with a folder NAME. kinds: see
    `box_sequence`; None: those of all drives together. options: further ones of `box_sequence`.
    Raises as that, and DatasetNotFound for a folder without boxes.
    """
    if not boxes.is_dir():
        return [box_sequence(boxes, camera, images, poses, kinds=kinds, **options)]
    files = box_files(boxes)
    if not files:
        raise DatasetNotFound(f"{boxes}: no boxes in it; give NAME.csv, NAME.json or NAME.txt")

    def drive(name: str, kinds: tuple[str, ...] | None) -> RecordedSequence:
        return box_sequence(
            files[name],
            camera
            if isinstance(camera, CameraFile)
            else _of_drive(camera, f"{name}.toml") or camera,
            images and images / name,
            _of_drive(poses, f"{name}.txt"),
            kinds=kinds,
            **options,
        )

    drives = [drive(name, kinds) for name in files]
    there = {kind for each in drives for kind in each.kinds}
    together = tuple(kind for kind in TRACKED_KINDS if kind in there)
    return [
        each if each.kinds in (kinds, together) else drive(each.name, together) for each in drives
    ]


def _of_drive(given: Path | None, name: str) -> Path | None:
    """What is given for all drives, or the file of this name in a folder."""
    return given / name if given is not None and given.is_dir() else given
