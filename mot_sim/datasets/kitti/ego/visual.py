"""Camera motion seen in the images themselves, with the detections' boxes left out."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mot_sim.datasets.images import ImageFolder
from mot_sim.datasets.kitti.calibration import Calibration
from mot_sim.datasets.recorded import DetectionLog, Motion
from tracker.ego import VisualOdometry, prefetch
from tracker.errors import BadCalibration, BadFile
from tracker.types import Camera


@dataclass(frozen=True, eq=False)
class ImageMotion:
    """What sees the motion in a folder of images while the drive is played.

    Frames without an image coast for a second, see `VisualOdometry.step`; after that, and before
    the first two images, nobody knows how the camera moved. threaded: one frame ahead, on a
    thread of its own, with the same results.
    """

    images: ImageFolder
    threaded: bool = True

    def motions(
        self, camera: Camera, log: DetectionLog, frame_count: int, frame_rate: float
    ) -> Iterator[Motion]:
        """T_now_before and its covariance, of every frame of the recording in turn."""
        seen = self._seen(camera, log, frame_count, frame_rate)
        return prefetch(seen) if self.threaded else seen

    def _seen(
        self, camera: Camera, log: DetectionLog, frame_count: int, frame_rate: float
    ) -> Iterator[Motion]:
        odometry = VisualOdometry(camera)
        for frame in range(frame_count):
            image, boxes = self.images.load(frame), log.at(frame).boxes
            yield odometry.step(image, boxes, 1.0 / frame_rate)


@dataclass(frozen=True, eq=False)
class VisualEgo:
    """Motion seen in the images of `<root>/<split>/image_02/SSSS` (visual odometry)."""

    motion_cov: None = None

    def poses(
        self, root: Path, split: str, name: str, calibration: Calibration, frame_count: int
    ) -> None:
        """No poses beforehand: see `watch`."""
        return

    def watch(
        self, images: ImageFolder, image_size: tuple[int, int] | None, frame_count: int
    ) -> ImageMotion:
        """The motion in these images; image_size: what the calibration is for, where known.

        Raises BadCalibration for another size, BadFile for images of more frames than there are.
        """
        folder = images.paths[min(images.paths)].parent
        if image_size is not None and images.image_size != image_size:
            width, height = images.image_size
            raise BadCalibration(
                f"{folder}: images of {width}x{height} pixels, the sequence's calibration is for "
                f"{image_size[0]}x{image_size[1]}; give them at their full size"
            )
        beyond = max(images.paths)
        if beyond >= frame_count:
            raise BadFile(
                f"{images.paths[beyond]}: the sequence has {frame_count} frames, counted from 0; "
                "leave the image out, or number the images from 000000"
            )
        images.warn_of_gaps(frame_count)
        return ImageMotion(images)
