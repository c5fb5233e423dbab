"""`mot-sim calibrate-camera`: where a camera stands, by the boxes of the cars that it saw."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mot_sim.cli.options import Flag, Verbose, option
from mot_sim.cli.terminal import OK, Terminal

if TYPE_CHECKING:
    import mot_sim.datasets

# Stands in for the height that is to be estimated, m.
ANY_HEIGHT = 1.5


@dataclass(frozen=True)
class CalibrateCamera:
    """Estimate a camera's height, pitch and roll from boxes of cars.

    mot-sim calibrate-camera --boxes boxes.csv --focal 700 --image-size 1280x720 --out camera.toml

    mot-sim calibrate-camera --boxes DRIVES --camera lens.toml --out camera.toml

    Cars are 1.5 m high and stand on the road: that gives the scale. The focal length must be known.
    Several drives of the same camera (a folder of files) tell more than one; at least 12 cars must
    be seen wholly. Without --out the camera file is printed.
    """

    boxes: Annotated[Path, option("FILE|DIR", "none: it must be given")]
    """Boxes as mot-sim track reads them; those of cars are used."""
    camera: Annotated[Path | None, option("FILE")] = None
    """A camera file, as for mot-sim track, whose intrinsics and lens are kept; camera_height may be
    missing, and where the camera stands is not looked at."""
    focal: Annotated[float | None, option("PIXELS")] = None
    """The focal length, in place of --camera; the principal point is the image's centre."""
    image_size: Annotated[str | None, option("WxH")] = None
    """Width and height of the image in pixels, with --focal: 1280x720."""
    out: Annotated[Path | None, option("FILE", "printed")] = None
    """The camera file; an older one is replaced."""
    drop_bad_boxes: Flag = False
    """Leave out boxes without area and boxes outside the image, instead of refusing the file."""
    json: Flag = False
    """Print the estimate as JSON."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Estimate, and write or print the camera file."""
        from mot_sim.datasets import box_sequences
        from mot_sim.datasets.camera_estimate import estimate_camera
        from mot_sim.datasets.camera_files import camera_lines
        from mot_sim.files.writing import require_writable, write_lines

        if self.out is not None:
            require_writable(self.out)
        described = self._described()
        drives = box_sequences(
            self.boxes, described, bad_boxes="drop" if self.drop_bad_boxes else "error",
            kinds=("Car",),
        )  # fmt: skip
        seen_by = drives[0].camera  # the pinhole that stands in for a lens
        found = estimate_camera([drive.log for drive in drives], seen_by.K, seen_by.image_size)
        mount = replace(described.camera, T_cam_road=found.camera.T_cam_road)
        lines = [f"# {line}" for line in found.lines]
        lines += camera_lines(replace(described, camera=mount))
        if self.out is not None:
            write_lines(self.out, lines)
        if self.json:
            terminal.write_json(found.content)
        elif self.out is None:
            terminal.write("\n".join(lines) + "\n")
        else:
            terminal.write("\n".join([*found.lines, f"{self.out}: the camera"]) + "\n")
        return OK

    def _described(self) -> "mot_sim.datasets.CameraFile":
        """The camera, with any height."""
        import numpy as np

        from mot_sim.datasets import CameraFile, read_camera
        from tracker.errors import BadConfig
        from tracker.types import Camera

        if (self.camera is None) == (self.focal is None):
            raise BadConfig("give --camera FILE, or --focal PIXELS with --image-size WxH")
        if self.camera is not None:
            if self.image_size is not None:
                raise BadConfig("--image-size belongs to --focal: the camera file says it")
            return read_camera(self.camera, ANY_HEIGHT)
        try:
            width, height = (int(number) for number in (self.image_size or "").lower().split("x"))
        except ValueError:
            raise BadConfig(f"--image-size {self.image_size}: write WxH, as 1280x720") from None
        K = np.diag([self.focal, self.focal, 1.0])
        K[:2, 2] = 0.5 * (width - 1), 0.5 * (height - 1)
        return CameraFile(Camera.mounted(K, (width, height), ANY_HEIGHT), 10.0)
