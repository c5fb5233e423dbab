"""Films and pictures on disk: written by ffmpeg and OpenCV, and read back before use."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType

import cv2

from mot_sim.plotting.canvas import Image
from tracker.errors import BadConfig, BadOutput, OutputExists

# H.264 that every browser plays: even sizes, 4:2:0, the index in front.
H264 = (
    "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,"
    "format=yuv420p,setparams=colorspace=bt709:color_primaries=bt709:color_trc=bt709",
    "-c:v", "libx264", "-preset", "veryfast", "-crf", "20", "-movflags", "+faststart", "-f", "mp4",
)  # fmt: skip
LOSSLESS = ("-c:v", "libx264rgb", "-preset", "ultrafast", "-qp", "0", "-f", "matroska")
PALETTE = ("-vf", "palettegen=stats_mode=full", "-f", "image2", "-update", "1")
GIF = ("-lavfi", "paletteuse=dither=bayer:bayer_scale=4:diff_mode=rectangle", "-loop", "0",
       "-f", "gif")  # fmt: skip
QUIET = ("-hide_banner", "-nostdin", "-loglevel", "error", "-y")
FILM_ENDINGS = (".mp4", ".gif", "")  # H.264; a looping GIF; a folder of 000000.png, ...


def find_ffmpeg() -> str:
    """The program. Raises BadConfig where there is none."""
    try:
        from imageio_ffmpeg import get_ffmpeg_exe  # noqa: PLC0415 - pictures do not need it

        return str(get_ffmpeg_exe())
    except ImportError:
        cure = "the package imageio-ffmpeg is missing: pip install imageio-ffmpeg"
    except RuntimeError:
        cure = "imageio-ffmpeg has no program for this machine: set IMAGEIO_FFMPEG_EXE to one"
    raise BadConfig(f"no ffmpeg, which writes MP4 and GIF; {cure}, or write a folder of PNG")


class Encoder:
    """A running ffmpeg that takes frames of one size.

    It does not see the terminal's Ctrl-C, so that what was written before can still be finished.
    """

    def __init__(self, path: Path, first: Image, frame_rate: float, how: Sequence[str]) -> None:
        height, width = first.shape[:2]
        self.path, self.shape = path, first.shape
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the encoder
        given = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}")
        self._process = subprocess.Popen(
            [find_ffmpeg(), "-hide_banner", "-loglevel", "error", "-y",
             *given, "-r", f"{frame_rate:g}", "-i", "pipe:0", *how, str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self._said,
            start_new_session=True,
        )  # fmt: skip

    def add(self, frame: Image) -> None:
        """One more frame. Raises BadOutput when ffmpeg has given up, or for another size."""
        if frame.shape != self.shape:
            raise BadOutput(f"{self.path}: a frame of {frame.shape} after ones of {self.shape}")
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(frame.tobytes())
        except BrokenPipeError:
            self.finish()
            raise BadOutput(f"{self.path}: ffmpeg stopped early") from None

    def finish(self) -> None:
        """Close the file. Raises BadOutput with what ffmpeg says when it failed."""
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):  # it has ended by itself; its exit code says how
            self._process.stdin.close()
        code = self._process.wait()
        self._said.seek(0)
        said = self._said.read().decode(errors="replace")
        self._said.close()
        if code:
            raise BadOutput(f"{self.path}: ffmpeg failed: {last_line(said)}")

    def abandon(self) -> None:
        """Stop at once; what it wrote is of no use."""
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        if self._process.stdin is not None:
            with suppress(BrokenPipeError):
                self._process.stdin.close()
        self._said.close()


def convert(sources: Sequence[Path], how: Sequence[str], target: Path) -> None:
    """One run of ffmpeg from files to a file. Raises BadOutput."""
    given = [word for source in sources for word in ("-i", str(source))]
    done = subprocess.run(
        [find_ffmpeg(), *QUIET, *given, *how, str(target)], capture_output=True, check=False
    )
    if done.returncode:
        said = done.stderr.decode(errors="replace")
        raise BadOutput(f"{target}: ffmpeg failed: {last_line(said)}")


def last_line(text: str) -> str:
    """The last line that says something."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "it says nothing; is the disk full?"


def require_target(path: Path, overwrite: bool = False) -> None:
    """Check that a film can be written there, before any work is done; writes nothing.

    Raises BadConfig for an unknown ending or a missing ffmpeg, OutputExists for what is there
    already (a film, or a folder that holds something; with overwrite, one that holds more than
    a film's pictures), BadOutput for a place that cannot be written to.
    """
    ending = path.suffix.lower()
    if ending not in FILM_ENDINGS:
        raise BadConfig(f"{path}: no film ends in '{path.suffix}'; give .mp4, .gif, or a folder")
    if ending:
        find_ffmpeg()
    if path.is_dir() and ending:
        raise BadOutput(f"{path}: is a folder; name a file, or a folder without an ending")
    if path.is_file() and not (ending and overwrite):
        cure = "give --overwrite, or another name" if ending else "name another folder"
        raise OutputExists(f"{path}: exists; {cure}")
    there = sorted(child.name for child in path.iterdir()) if path.is_dir() else []
    foreign = [name for name in there if not (name.endswith(".png") and name[:-4].isdecimal())]
    if foreign:
        raise OutputExists(f"{path}: holds {foreign[0]}, which is no film's; name another folder")
    if there and not overwrite:
        raise OutputExists(f"{path}: exists and is not empty; give --overwrite, or another name")
    place = path.absolute().parent
    while not place.exists():
        place = place.parent
    if not place.is_dir() or not os.access(place, os.W_OK | os.X_OK):
        raise BadOutput(f"{path}: cannot be written: {place} is no folder that can be written to")


class FilmWriter:
    """Frames into a film; it appears as a whole when the context ends.

    The ending decides: .mp4 is H.264 that browsers play, .gif loops, a path without one becomes
    a folder of PNG named by `add`'s number. Ctrl-C inside the context keeps the frames so far (a
    shorter film) and goes on up; any other exception leaves nothing. See `require_target` for
    what may be replaced.
    """

    def __init__(self, path: Path, frame_rate: float) -> None:
        self.path, self.frame_rate, self.frames = path, frame_rate, 0
        self._half = path.absolute().with_name(f".{path.name}.{os.getpid()}.half")
        self._encoder: Encoder | None = None
        self._ending = path.suffix.lower()

    def __enter__(self) -> "FilmWriter":
        try:
            self._half.parent.mkdir(parents=True, exist_ok=True)
            self._half.mkdir()
        except OSError as error:
            raise BadOutput(f"{self.path}: cannot be written: {error.strerror}") from None
        return self

    def add(self, frame: Image, number: int | None = None) -> None:
        """One more frame. number: in the name of its PNG; counts from 0 unless told."""
        if self._ending == "":
            write_image(self._half / f"{self.frames if number is None else number:06d}.png", frame)
        else:
            if self._encoder is None:
                how = LOSSLESS if self._ending == ".gif" else H264
                self._encoder = Encoder(self._draft, frame, self.frame_rate, how)
            self._encoder.add(frame)
        self.frames += 1

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        try:
            is_stopped = kind is not None and issubclass(kind, KeyboardInterrupt)
            if kind is None or (is_stopped and self.frames):
                self._finish(is_stopped)
            elif self._encoder is not None:
                self._encoder.abandon()
        except OSError as trouble:
            raise BadOutput(f"{self.path}: cannot be written: {trouble.strerror}") from None
        finally:
            shutil.rmtree(self._half, ignore_errors=True)

    @property
    def _draft(self) -> Path:
        return self._half / ("draft.mkv" if self._ending == ".gif" else "film.mp4")

    def _finish(self, is_stopped: bool) -> None:
        """Complete the film and put it in place; Ctrl-C may have cut the last frame."""
        if not self.frames:
            raise BadOutput(f"{self.path}: a film of no frames cannot be written")
        if self._encoder is None:
            put_in_place(self._half, self.path)
            return
        self._encoder.finish()
        film = self._draft
        if self._ending == ".gif":
            palette, film = self._half / "palette.png", self._half / "film.gif"
            convert([self._draft], PALETTE, palette)
            convert([self._draft, palette], GIF, film)
        readable = count_frames(film)
        if not readable or (readable != self.frames and not is_stopped):
            raise BadOutput(
                f"{self.path}: {readable} of {self.frames} frames can be read back; is the disk "
                "full?"
            )
        self.frames = readable
        os.replace(film, self.path)


def write_video(path: Path, frames: Iterable[Image], frame_rate: float) -> Path:
    """Write a film and give its path; see `FilmWriter`."""
    with FilmWriter(path, frame_rate) as film:
        for frame in frames:
            film.add(frame)
    return path


def put_in_place(half: Path, folder: Path) -> None:
    """Move a folder to where an older one may be; that leaves only when the new one stands."""
    if not folder.exists():
        half.rename(folder)
        return
    old = half.with_suffix(".old")
    folder.rename(old)
    try:
        half.rename(folder)
    except OSError:
        old.rename(folder)
        raise
    shutil.rmtree(old)


def count_frames(path: Path) -> int:
    """The frames of a film that can be decoded; 0 for what is none."""
    if not path.is_file():
        return 0
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
