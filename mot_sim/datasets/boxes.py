"""A drive of your own: given as boxes.csv and camera.toml."""

from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.camera_files import read_camera, read_poses
from mot_sim.datasets.detection_files import BadBoxes, DetectionFormat, ScoreMap, check_detections
from mot_sim.datasets.images import ImageFolder
from mot_sim.datasets.kitti.ego import ORBSLAM3_MOTION_STD, ImageMotion
from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.files.text import TextTable, read_table
from tracker.errors import BadConfig, BadFile, DatasetNotFound, UnknownName

REQUIRED_COLUMNS = ("frame", "x_min", "y_min", "x_max", "y_max")
OPTIONAL_COLUMNS = ("score",)
HEADER = ",".join((*REQUIRED_COLUMNS, *OPTIONAL_COLUMNS))


def box_sequence(
    boxes: Path | str,
    camera: Path | str,
    images: Path | str | None = None,
    poses: Path | str | None = None,
    name: str | None = None,
    *,
    motion_cov: Float[Array, "6 6"] | None = None,
    visual: bool = False,
    bad_boxes: BadBoxes = "error",
    score_map: ScoreMap | None = None,
    every: int | None = None,
) -> RecordedSequence:
    """The drive in a table of boxes and a camera file.

    boxes: a csv file whose header names its columns, `frame,x_min,y_min,x_max,y_max,score` in
    any order, score optional (1 then); frames count from 0, pixel centres are integers; boxes
    are clipped to the image. camera: see `read_camera`. images: a folder of 000000.png, ... .
    poses: a 3x4 camera-to-world matrix per line, one per frame, in metres; without it the
    camera's motion is unknown. motion_cov: of the motion that the poses give over one frame; by
    default that of ORB-SLAM3 on KITTI. visual: the motion is seen in the images. name: the
    csv file's, unless given. score_map: from the scores to probabilities; None: they are ones.
    every: only every so many-th frame was looked at; None: as the boxes say, see
    `RecordedSequence.looked_at_every`.
    There are as many frames as poses, else as images, else up to the last box.
    """
    if visual and (images is None or poses is not None):
        raise BadConfig("motion seen in images needs images, and no poses: give one or the other")
    table = read_boxes_table(Path(boxes))
    described = read_camera(Path(camera))
    folder = None if images is None else ImageFolder.require(Path(images))
    image_size = described.camera.image_size
    if folder is not None and folder.image_size != image_size:
        raise BadConfig(
            f"{camera}: image_width and image_height are {image_size[0]}x{image_size[1]}, the "
            f"images in {images} have {folder.image_size[0]}x{folder.image_size[1]} pixels"
        )
    frame_count = None if folder is None else max(folder.paths) + 1
    columns = tuple(table.rows.dtype.names or ())
    form = DetectionFormat(columns, delimiter=",", score_map=score_map)
    known_count = frame_count if poses is None else None  # otherwise there is one frame per pose
    log = check_detections(table, form, image_size, known_count, bad_boxes)
    last_box = int(table["frame"].max(initial=-1))
    Ts_world_cam = None
    if poses is not None:
        path = _require(Path(poses), "pose file")
        Ts_world_cam = read_poses(path, step=1.0 / described.frame_rate)
        last = max(last_box, -1 if frame_count is None else frame_count - 1)
        if len(Ts_world_cam) <= last:
            raise BadFile(
                f"{path}: {len(Ts_world_cam)} poses, but {boxes if last == last_box else images} "
                f"reaches frame {last}, counted from 0; give one pose per frame, {last + 1} in "
                "all (between those of key-frames, interpolate)"
            )
        frame_count = len(Ts_world_cam)
    elif frame_count is None:
        frame_count = last_box + 1
    if folder is not None:
        folder.warn_of_gaps(frame_count)
    if motion_cov is None and Ts_world_cam is not None:
        motion_cov = np.diag(ORBSLAM3_MOTION_STD) ** 2
    sequence = RecordedSequence(
        name=Path(boxes).stem if name is None else name,
        camera=described.camera,
        frame_count=frame_count,
        log=log,
        frame_indices=np.arange(frame_count),
        Ts_world_cam=Ts_world_cam,
        motion_cov=motion_cov,
        images=folder,
        motion=ImageMotion(folder) if visual and folder is not None else None,
        frame_rate=described.frame_rate,
    )
    return sequence.looked_at_every(every)


def read_boxes_table(path: Path) -> TextTable:
    """The rows of a boxes.csv; BadFile without a header, for missing and unknown columns."""

    def columns(fields: list[str]) -> list[str]:
        if not set(fields) & {*REQUIRED_COLUMNS, *OPTIONAL_COLUMNS}:
            first = ",".join(fields) or "an empty file"
            raise BadFile(f"{path}:1: no header but {first[:80]!r}; the first line names: {HEADER}")
        for field in fields:
            if field not in REQUIRED_COLUMNS + OPTIONAL_COLUMNS:
                error = UnknownName.of("column", field, REQUIRED_COLUMNS + OPTIONAL_COLUMNS)
                raise BadFile(f"{path}:1: {error}")
        missing = [column for column in REQUIRED_COLUMNS if column not in fields]
        if missing or len(set(fields)) < len(fields):
            what = f"no column {missing[0]}" if missing else "a column stands twice"
            raise BadFile(f"{path}:1: {what}: {','.join(fields)}; the header is {HEADER}")
        return fields

    return read_table(_require(path, "boxes"), columns, delimiter=",", header=True)


def _require(path: Path, what: str) -> Path:
    if not path.is_file():
        raise DatasetNotFound(f"{path}: no {what}; is the path right?")
    return path
