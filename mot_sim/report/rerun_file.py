"""A drive for the rerun viewer: images, boxes, cuboids, trails and the camera, frame by frame.

rerun-sdk is the extra `view`; it is imported only when a recording is asked for. The map has
x forward, y right, z down, as in `mot_sim.report.ground`.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.files.writing import require_writable, whole_file
from mot_sim.plotting.colours import DETECTION_COLOUR, TRUE_COLOUR, colour_of_id
from mot_sim.report.expectations import ExpectedTracks, expectations
from mot_sim.report.film import Film
from mot_sim.report.ground import GroundMap
from tracker.errors import BadConfig, OutputExists
from tracker.types import Cuboids

RERUN_ENDING = ".rrd"
JPEG_QUALITY = 90  # of JPEG; lossless images make recordings ten times as large
TRAIL_FRAMES = 50


def find_rerun() -> Any:
    """The package. Raises BadConfig where it is not installed."""
    try:
        import rerun  # noqa: PLC0415 - an extra, and slow to import
    except ImportError:
        raise BadConfig("--rerun needs the extra `view`: pip install 'mot-sim[view]'") from None
    return rerun


def require_rerun(path: Path, overwrite: bool = False) -> None:
    """Check the ending, the place and the package before any work is done."""
    if path.suffix.lower() != RERUN_ENDING:
        raise BadConfig(f"{path}: a recording for rerun ends in {RERUN_ENDING}")
    require_writable(path)
    if path.exists() and not overwrite:
        raise OutputExists(f"{path}: exists; give --overwrite, or another name")
    find_rerun()


def write_rerun(path: Path, film: Film, first: int, end: int, progress: Callable[[], None]) -> None:
    """Write frames `first` to before `end` of what a film shows, as a whole or not at all.

    progress: called after every frame. Raises BadConfig without rerun-sdk, BadOutput.
    """
    rr = find_rerun()
    with whole_file(path) as half:
        name = f"{film.drive.name}-{film.tracker_name}"
        stream = rr.RecordingStream("mot-sim", recording_id=name)
        stream.save(str(half))
        logger = _FrameLogger(rr, stream, film)
        try:
            logger.begin()
            for index, standing in expectations(film.drive, film.tracks):
                if index >= end:
                    break
                if index >= first:
                    logger.frame(index, standing)
                    progress()
        finally:
            stream.disconnect()


class _FrameLogger:
    """Writes frames to a rerun stream, and keeps the trails."""

    def __init__(self, rr: Any, stream: Any, film: Film) -> None:
        self.rr, self.stream, self.film = rr, stream, film
        self.ground = GroundMap.of(film.drive, film.truth)
        self.trails: dict[int, list[list[float]]] = {}

    def begin(self) -> None:
        """Log what holds for all frames: the axes and the lens."""
        rr, camera = self.rr, self.film.drive.camera
        self.stream.log("map", rr.ViewCoordinates.FRD, static=True)
        lens = rr.Pinhole(
            image_from_camera=camera.K,
            resolution=list(camera.image_size),
            camera_xyz=rr.ViewCoordinates.RDF,
        )
        self.stream.log("map/camera/image", lens, static=True)

    def frame(self, index: int, standing: ExpectedTracks) -> None:
        """Log one frame."""
        rr, stream, drive = self.rr, self.stream, self.film.drive
        stream.set_time("frame", sequence=index)
        stream.set_time("time", duration=index / drive.frame_rate)
        T = self.ground.T_map_cam(index, drive.camera)
        stream.log("map/camera", rr.Transform3D(translation=T[:3, 3], mat3x3=T[:3, :3]))
        image = None if drive.images is None else drive.images.load(index)
        if image is not None:
            done, jpeg = cv2.imencode(
                ".jpg",
                cv2.cvtColor(image, cv2.COLOR_RGB2BGR),
                [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY],
            )
            assert done
            picture = rr.EncodedImage(contents=jpeg.tobytes(), media_type="image/jpeg")
            stream.log("map/camera/image", picture)
        self._boxes(index)
        self._cuboids(index, standing)

    def _boxes(self, index: int) -> None:
        film = self.film
        rows = film.tracks.select(film.tracks.frames == index)
        colours = [colour_of_id(each) for each in rows.ids.tolist()]
        self._log_boxes("tracks", rows.boxes, colours, rows.ids)
        boxes = film.drive.log.at(index).boxes
        self._log_boxes("detections", boxes, [DETECTION_COLOUR] * len(boxes))
        if film.truth is not None:
            now = film.truth.select((film.truth.frames == index) & (film.truth.ids >= 0))
            self._log_boxes("truth", now.boxes, [TRUE_COLOUR] * len(now), now.ids)

    def _log_boxes(
        self,
        name: str,
        boxes: Float[Array, "n 4"],
        colours: list[tuple[int, int, int]],
        ids: Int[Array, " n"] | None = None,
    ) -> None:
        rr = self.rr
        labels = None if ids is None else [str(each) for each in ids.tolist()]
        corners = rr.Box2DFormat.XYXY
        found = rr.Boxes2D(array=boxes, array_format=corners, colors=colours, labels=labels)
        self.stream.log(f"map/camera/image/{name}", found)

    def _cuboids(self, index: int, standing: ExpectedTracks) -> None:
        """Cuboids and trails on the map."""
        rr, now = self.rr, standing.now
        colours = [colour_of_id(each) for each in now.ids.tolist()]
        self._log_cuboids("map/tracks", now.cuboids, index, colours, now.ids)
        bases = self.ground.on_map(now.cuboids.base[:, ::2], index)
        for name, base in zip(now.ids.tolist(), bases.tolist(), strict=True):
            way = self.trails.setdefault(name, [])
            way[:] = [*way, [*base, 0.0]][-TRAIL_FRAMES if self.ground.poses is not None else -1 :]
        ways = [self.trails[name] for name in now.ids.tolist()]
        self.stream.log("map/trails", rr.LineStrips3D(ways, colors=colours))
        truth = self.film.truth
        if truth is not None and truth.cuboids is not None:
            rows = truth.select((truth.frames == index) & np.isfinite(truth.cuboids.yaw))
            assert rows.cuboids is not None
            white = [TRUE_COLOUR] * len(rows)
            self._log_cuboids("map/truth", rows.cuboids, index, white, rows.ids)

    def _log_cuboids(
        self,
        place: str,
        cuboids: Cuboids,
        index: int,
        colours: list[tuple[int, int, int]],
        ids: Int[Array, " n"],
    ) -> None:
        rr, ground = self.rr, self.ground
        on_ground = ground.on_map(cuboids.base[:, ::2], index)
        height = cuboids.base[:, 1] - 0.5 * cuboids.size[:, 1]
        heading = cuboids.yaw + 0.5 * np.pi + ground.pose(index)[2]
        zero = np.zeros(len(cuboids))
        turns = np.stack((zero, zero, np.sin(0.5 * heading), np.cos(0.5 * heading)), axis=1)
        boxes = rr.Boxes3D(
            centers=np.column_stack((on_ground, height)),
            half_sizes=0.5 * cuboids.size[:, [0, 2, 1]],
            quaternions=turns,
            colors=colours,
            labels=[str(each) for each in ids.tolist()],
        )
        self.stream.log(place, boxes)
