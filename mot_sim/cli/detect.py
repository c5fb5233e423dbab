"""`mot-sim detect`: boxes in images, by a network of one's own."""

from dataclasses import dataclass, field
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from mot_sim.cli.options import Flag, FolderOptions, Verbose, help_of, option
from mot_sim.cli.terminal import INTERRUPTED, OK, Terminal

if TYPE_CHECKING:
    import mot_sim.datasets
    import mot_sim.evaluation.detectors
    import mot_sim.files.settings

DETECTOR = ("mot_sim.evaluation.detectors.onnx_detector", "OnnxDetector")


@dataclass(frozen=True)
class Detect:
    """Find cars in images with a detector of your own, an ONNX file.

    mot-sim detect out/crossing --model yolo.onnx --out out/boxes

    mot-sim kitti --root out/crossing --detections out/boxes --detection-format kitti

    mot-sim detect my/images --model ssd.onnx --out out/boxes

    mot-sim track --boxes out/boxes --camera camera.toml --out out/mine

    DIR is a KITTI tree (one of mot-sim record too), a folder of folders of images 000000.png, or
    one of images. OUT/NAME.txt are rows of KITTI's results, without ids and cuboids. Networks of
    YOLO's and SSD's families are known by what they give; nothing is downloaded. Classes are named
    by the file or by --names; else COCO's and PASCAL VOC's are told by their number.
    """

    images: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="DIR")]
    """The images, in colour or grey."""
    model: Annotated[Path, tyro.conf.arg(metavar="FILE")]
    """The detector, an ONNX file."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Where the boxes go: a new or empty folder, unless --resume or --overwrite is given."""
    drives: Annotated[str | None, option("NAMES", "all")] = None
    """Which drives: 0000,0005."""
    classes: Annotated[str, option("NAMES", "car")] = "car"
    """What is kept: car, pedestrian, cyclist, or several: car,pedestrian."""
    names: Annotated[str | None, option("NAMES|FILE", "as the file or their number tells")] = None
    """The network's classes in their order: car,van,... or a file with one a line."""
    size: Annotated[str | None, option("WxH", "the network's own, else 640x640")] = None
    """What images are brought to, px, for networks that take any size."""
    head: Annotated[str | None, option("NAME", "found out")] = None
    """What the network gives: yolo (a score a class), rows (corners, score, class), ssd (boxes,
    scores, classes)."""
    fit: Annotated[str | None, option("NAME", "as is usual for the head")] = None
    """letterbox (grey around the image) or stretch."""
    pixels: Annotated[str, option("NAME", "rgb")] = "rgb"
    """What the network was trained on: rgb (0 to 1), rgb255, bgr255, imagenet."""
    min_score: Annotated[float, option("SCORE", "0.1", help=help_of(*DETECTOR, "min_score"))] = 0.1
    max_iou: Annotated[float, option("IOU", "0.7", help=help_of(*DETECTOR, "max_iou"))] = 0.7
    backend: Annotated[str | None, option("NAME", "ONNX Runtime where it is installed")] = None
    """onnxruntime (pip install 'mot-sim[detect]') or opencv."""
    folder: FolderOptions = field(default_factory=FolderOptions)
    """What happens to boxes that are in OUT already."""
    json: Flag = False
    """Print a summary as JSON instead of one line."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Look at every image, and show a summary."""
        from mot_sim.evaluation.detectors import OnnxDetector, detect_in, image_drives
        from tracker.types import parse_kinds

        drives = self._chosen(image_drives(self.images))
        kinds, size, names = parse_kinds(self.classes), self._size(), self._names()
        look: dict[str, Any] = {"head": self.head, "fit": self.fit, "pixels": self.pixels}
        limits: dict[str, Any] = {"min_score": self.min_score, "max_iou": self.max_iou}
        detector = OnnxDetector.load(
            self.model, self.backend, size, names=names, kinds=kinds, **look, **limits
        )
        settings = {
            "images": str(self.images.resolve()),
            "model": sha256(self.model.read_bytes()).hexdigest(),
            "size": "x".join(map(str, detector.size)),
            "names": None if names is None else ",".join(names.values()),
            "classes": ",".join(kinds),
            **(look | {"head": detector.head, "fit": detector.fit}),
            **limits,
        }
        folder = self._folder(settings, list(drives))
        waiting = {name: drive for name, drive in drives.items() if name not in folder.finished}
        frames = sum(len(drive.paths) for drive in waiting.values())
        try:
            with folder, terminal.progress(frames, unit="frames", lines=True) as advance:
                for name, drive in waiting.items():
                    drive.warn_of_gaps(max(drive.paths) + 1)
                    folder.add(name, detect_in(detector, drive, partial(advance, name)))
        except KeyboardInterrupt:
            terminal.note(
                f"interrupted: {len(folder.finished)} of {len(drives)} drives are finished in "
                f"{self.out}; the same command with --resume does the rest"
            )
            return INTERRUPTED
        self._report(terminal, detector, folder, frames)
        return OK

    def _folder(
        self, settings: "mot_sim.files.settings.Settings", drives: list[str]
    ) -> "mot_sim.evaluation.detectors.DetectedFolder":
        """The folder of boxes, checked."""
        from mot_sim.evaluation.detectors import DetectedFolder

        choice = {"resume": self.folder.resume, "overwrite": self.folder.overwrite}
        return DetectedFolder.open(self.out, settings, drives, **choice)

    def _chosen(
        self, found: "dict[str, mot_sim.datasets.ImageFolder]"
    ) -> "dict[str, mot_sim.datasets.ImageFolder]":
        """The drives that are asked for."""
        from tracker.errors import UnknownName

        if self.drives in (None, "all"):
            return found
        chosen = [name.strip() for name in str(self.drives).split(",")]
        for name in chosen:
            if name not in found:
                raise UnknownName.of("drive", name, list(found))
        return {name: found[name] for name in dict.fromkeys(chosen)}

    def _size(self) -> tuple[int, int] | None:
        """Width and height."""
        from tracker.errors import BadConfig

        if self.size is None:
            return None
        width, _, height = self.size.lower().partition("x")
        if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
            raise BadConfig(f"--size {self.size}: write width x height in pixels, 1248x384")
        return int(width), int(height)

    def _names(self) -> dict[int, str] | None:
        """The network's classes by number."""
        from mot_sim.files.text import read_text
        from tracker.errors import BadConfig

        if self.names is None:
            return None
        is_file = "," not in self.names and Path(self.names).is_file()
        parts = read_text(Path(self.names)).splitlines() if is_file else self.names.split(",")
        names = [part.strip() for part in parts]
        while names and not names[-1]:
            names.pop()
        if not names or not all(names):
            raise BadConfig(f"--names {self.names}: a class without a name; give car,van,...")
        return dict(enumerate(names))

    def _report(
        self,
        terminal: Terminal,
        detector: "mot_sim.evaluation.detectors.OnnxDetector",
        folder: "mot_sim.evaluation.detectors.DetectedFolder",
        frames: int,
    ) -> None:
        """What was found."""
        boxes, drives = sum(folder.finished.values()), len(folder.finished)
        if self.json:
            summary = {"out": str(self.out), "frames": frames, "head": detector.head}
            summary |= {"size": list(detector.size), "fit": detector.fit}
            terminal.write_json({**summary, "drives": folder.finished})
            return
        width, height = detector.size
        terminal.write(
            f"{self.out}: {drives} drive{'s' * (drives != 1)}, {frames:,} frames, {boxes:,} boxes "
            f"(head {detector.head}, {width}x{height}, {detector.fit})\n"
        )
        for name, count in folder.finished.items():
            if count == 0:
                terminal.note(
                    f"warning: {name}: no box; if there are cars, see --pixels, --fit, --min-score"
                )
