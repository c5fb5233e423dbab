"""ffmpeg, found and fed: raw RGB frames in, an encoded file out."""

import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from mot_sim.plotting.canvas import Image
from tracker.errors import BadConfig, BadOutput

# H.264 that every browser plays: even sizes, 4:2:0, the index in front.
H264 = (
    "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,"
    "format=yuv420p,setparams=colorspace=bt709:color_primaries=bt709:color_trc=bt709",
    "-c:v", "libx264", "-preset", "fast", "-crf", "20", "-movflags", "+faststart", "-f", "mp4",
)  # fmt: skip
LOSSLESS = ("-c:v", "libx264rgb", "-preset", "ultrafast", "-qp", "0", "-f", "matroska")
PALETTE = ("-vf", "palettegen=stats_mode=full", "-f", "image2", "-update", "1")
GIF = ("-lavfi", "paletteuse=dither=bayer:bayer_scale=4:diff_mode=rectangle", "-loop", "0",
       "-f", "gif")  # fmt: skip
QUIET = ("-hide_banner", "-nostdin", "-loglevel", "error", "-y")


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
        [find_ffmpeg(), *QUIET, *given, *how, str(target)],
        capture_output=True,
        check=False,
    )
    if done.returncode:
        said = done.stderr.decode(errors="replace")
        raise BadOutput(f"{target}: ffmpeg failed: {last_line(said)}")


def last_line(text: str) -> str:
    """The last line that says something."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "it says nothing; is the disk full?"
