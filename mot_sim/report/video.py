"""Videos and pictures on disk, each read back before anybody is told that it is there."""

from collections.abc import Iterable
from pathlib import Path

import cv2

from mot_sim.report.canvas import Image
from tracker.errors import BadOutput

# Codecs by file ending, the wanted one first: MPEG-4, and pictures one by one, which every
# build of OpenCV can write.
CODECS = ((".mp4", "mp4v"), (".avi", "MJPG"))


def write_video(path: Path, frames: Iterable[Image], frame_rate: float) -> Path:
    """Write an MP4, or an AVI of the same name where OpenCV lacks the codec; gives its path.

    Raises BadOutput when neither works, or when the file does not hold all frames.
    """
    writer: cv2.VideoWriter | None = None
    written, count = path, 0
    try:
        for frame in frames:
            if writer is None:
                written, writer = _open(path, frame, frame_rate)
            writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
            count += 1
    finally:
        if writer is not None:
            writer.release()
    if count == 0:
        raise BadOutput(f"{path}: a video of no frames cannot be written")
    readable = count_frames(written)
    if readable != count:
        raise BadOutput(
            f"{written}: {readable} of {count} video frames can be read back; is the disk full?"
        )
    return written


def _open(path: Path, frame: Image, frame_rate: float) -> tuple[Path, cv2.VideoWriter]:
    """A writer that works, and the path that it writes to."""
    height, width = frame.shape[:2]
    for ending, codec in CODECS:
        target = path.with_suffix(ending)
        fourcc = cv2.VideoWriter.fourcc(*codec)
        writer = cv2.VideoWriter(str(target), fourcc, frame_rate, (width, height))
        if writer.isOpened():
            return target, writer
        target.unlink(missing_ok=True)
    tried = ", ".join(f"{codec} in {ending}" for ending, codec in CODECS)
    raise BadOutput(
        f"{path}: OpenCV can write no video here (tried {tried}); is the folder writable? "
        "'mot-sim doctor' lists the codecs"
    )


def count_frames(path: Path) -> int:
    """The frames of a video that can be decoded; 0 for what is none."""
    capture = cv2.VideoCapture(str(path))
    count = 0
    try:
        while capture.isOpened() and capture.grab():
            count += 1
    finally:
        capture.release()
    return count


def write_image(path: Path, image: Image) -> None:
    """Write a PNG or JPEG. Raises BadOutput where that fails."""
    parameters = [cv2.IMWRITE_PNG_COMPRESSION, 6] if path.suffix == ".png" else []
    written = path.parent.is_dir() and cv2.imwrite(
        str(path), cv2.cvtColor(image, cv2.COLOR_RGB2BGR), parameters
    )
    if not written:
        raise BadOutput(f"{path}: the picture cannot be written; is the folder there and writable?")
