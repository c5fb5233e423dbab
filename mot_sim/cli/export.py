"""`mot-sim export`: results for other evaluators; `mot-sim export-car`: a car as GLB."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.evaluate import say_unlabelled
from mot_sim.cli.options import DETECTIONS, Root, Verbose, option
from mot_sim.cli.terminal import OK, Terminal

if TYPE_CHECKING:
    import mot_sim.datasets
    import tracker


SERVER = "kitti-server"


@dataclass(frozen=True)
class Export:
    """Write results and labels for another evaluator.

    mot-sim export out/rrc out/mot --to motchallenge --root KITTI --detections rrc

    mot-sim export out/rrc out/te --to trackeval --root KITTI

    mot-sim export out/testing out/testing.zip --to kitti-server

    mot-sim export out/mine out/tables --to csv

    motchallenge: OUT/SSSS/ with seqinfo.ini, det/det.txt, res/res.txt and, where there are labels,
    gt/gt.txt; frames and ids from 1. trackeval: OUT/gt is GT_FOLDER and OUT/trackers is
    TRACKERS_FOLDER of TrackEval's Kitti2DBox; only sequences with labels. kitti-server: OUT is the
    archive of the 29 testing sequences, checked by the server's rules. csv, coco, mot: a file of
    boxes with ids for each sequence, of KITTI or of your own: OUT/NAME.csv; OUT/NAME.json, COCO's
    results with a track_id; OUT/NAME.txt, MOTChallenge's rows with ids from 1.
    """

    results: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RESULTS")]
    """A folder with SSSS.txt, or data/SSSS.txt, for every sequence."""
    out: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUT")]
    """A new or empty folder; for kitti-server a file, NAME.zip."""
    to: Annotated[str, tyro.conf.arg(metavar="FORMAT")]
    """motchallenge, trackeval, kitti-server, csv, coco or mot."""
    root: Root = None
    """The KITTI tree with the calibration, labels and detections."""
    sequences: Annotated[str | None, option("NAMES", "those with results")] = None
    """all, labelled, or names: 0000,0005."""
    detections: Annotated[str, option("NAME|PATH", DETECTIONS)] = DETECTIONS
    """For motchallenge: the detections that det/det.txt gets."""
    detection_format: Annotated[str | None, option("NAME", "the detector's own")] = None
    """How the rows of a folder or file of your own are written: the name of a detector."""
    name: Annotated[str | None, option("NAME", "the name of the folder RESULTS")] = None
    """For trackeval: what the tracker is called."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Read everything, then write."""
        from mot_sim.datasets.box_writers import BOX_WRITERS
        from mot_sim.evaluation.scoring import pick_results, read_picked
        from mot_sim.files.settings import require_empty
        from tracker.errors import UnknownName

        if self.to == SERVER:
            return self._for_server(terminal)
        if self.to not in {**FORMATS, **BOX_WRITERS}:
            raise UnknownName.of("export format", self.to, [*FORMATS, *BOX_WRITERS, SERVER])
        require_empty(self.out)
        if self.to in BOX_WRITERS:
            return self._as_boxes(terminal)
        files = pick_results(self.results, self.root, self.sequences)
        drives = [self._drive(name) for name in files]
        names = FORMATS[self.to](self, drives, read_picked(files, drives, with_cuboids=True))
        say_unlabelled(terminal, tuple(name for name in files if name not in names))
        count = len(names)
        terminal.write(f"{self.out}: {count} sequence{'s' * (count != 1)} for {self.to}\n")
        return OK

    def _as_boxes(self, terminal: Terminal) -> int:
        """Write each result file as a table of boxes; nothing of KITTI is needed."""
        from mot_sim.datasets import tracks_of_boxes, write_lines
        from mot_sim.datasets.box_writers import BOX_WRITERS
        from mot_sim.evaluation.scoring import result_files

        writer = BOX_WRITERS[self.to]
        files = result_files(self.results)
        tables = {name: list(writer.lines(tracks_of_boxes(path))) for name, path in files.items()}
        for name, lines in tables.items():
            write_lines(self.out / f"{name}{writer.suffix}", lines)
        count = len(tables)
        terminal.write(f"{self.out}: {count} sequence{'s' * (count != 1)} for {self.to}\n")
        return OK

    def _for_server(self, terminal: Terminal) -> int:
        """Pack the results of the testing split; labels are not needed."""
        from mot_sim.datasets.kitti import write_server_archive
        from mot_sim.evaluation.scoring import result_files

        files = result_files(self.results)
        write_server_archive(files, self.out)
        terminal.write(f"{self.out}: {len(files)} sequences for KITTI's server\n")
        return OK

    def _drive(self, name: str) -> "mot_sim.datasets.KittiSequence":
        """A drive, with its detections if the format wants them."""
        from mot_sim.datasets import kitti_sequence

        detections = self.detections if self.to == "motchallenge" else None
        return kitti_sequence(
            self.root, name, detections, "none", detection_format=self.detection_format
        )


def to_motchallenge(
    export: Export,
    drives: "list[mot_sim.datasets.KittiSequence]",
    results: "dict[str, tracker.Tracks]",
) -> list[str]:
    """Write one folder per sequence; returns the names of the written sequences."""
    from mot_sim.datasets import export_motchallenge

    for drive in drives:
        export_motchallenge(export.out, drive, drive.truth, results[drive.name])
    return [drive.name for drive in drives]


def to_trackeval(
    export: Export,
    drives: "list[mot_sim.datasets.KittiSequence]",
    results: "dict[str, tracker.Tracks]",
) -> list[str]:
    """Write TrackEval's two folders; returns the names of the written sequences."""
    from mot_sim.datasets import export_trackeval
    from tracker.errors import DatasetNotFound

    truths = {drive.name: drive.truth for drive in drives if drive.truth is not None}
    if not truths:
        raise DatasetNotFound(f"no labels for {', '.join(results)}: TrackEval needs them")
    lengths = {drive.name: drive.frame_count for drive in drives if drive.name in truths}
    tracker_name = export.name or export.results.resolve().name
    frames = {drive.name: drive.T_road_label for drive in drives}
    export_trackeval(export.out, tracker_name, lengths, truths, results, frames)
    return list(truths)


FORMATS: dict[str, Callable[..., list[str]]] = {
    "motchallenge": to_motchallenge,
    "trackeval": to_trackeval,
}


if TYPE_CHECKING:
    from numpy import ndarray as Array


@dataclass(frozen=True)
class ExportCar:
    """Write a car of the fleet as GLB, for 3D programs.

    mot-sim export-car --body estate --paint red out/estate.glb

    mot-sim export-car --size 4.4,1.5,1.8 out/car.glb

    mot-sim export-car --coefficients=-0.3,0.1,0,0,0.05 out/shape.glb

    The shape is drawn at random (--seed), unless --size or --coefficients give it.
    """

    out: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUT.glb")]
    """The file; an older one is replaced."""
    seed: int = 0
    """Seed of the drawn shape and paint."""
    body: Annotated[str | None, option("NAME", "drawn; with --size the nearest")] = None
    """sedan, hatchback, estate, suv, coupe, van or pickup."""
    size: Annotated[str | None, option("L,H,W")] = None
    """Length, height and width in metres; the likeliest car of about that size is written."""
    paint: Annotated[str | None, option("NAME", "drawn")] = None
    """black, grey, silver, white, blue, red, green, brown or yellow."""
    coefficients: Annotated[str | None, option("NUMBERS")] = None
    """1 to 20 shape coefficients of eq. 1, in place of a drawn shape."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Write the car, and say how large it is."""
        import numpy as np

        from mot_sim.simulation.cars import export_car, load_fleet

        shape, paint = self._car()
        path = export_car(shape, self.out, self.paint or paint)
        length, height, width = load_fleet(len(shape)).size(np.asarray(shape)).tolist()
        terminal.write(
            f"{path}: {length:.2f} m long, {height:.2f} m high, {width:.2f} m wide, "
            f"{self.paint or paint}; coefficients {','.join(f'{b:.4f}' for b in shape.tolist())}\n"
        )
        return OK

    def _car(self) -> "tuple[Array, str]":
        """Shape coefficients, and the paint that is drawn."""
        import numpy as np

        from mot_sim.simulation.cars import load_fleet
        from tracker.errors import BadConfig

        if self.coefficients is not None and (self.size or self.body):
            other = "--size" if self.size else "--body"
            raise BadConfig(f"--coefficients and {other} both say the shape: keep one")
        fleet = load_fleet()
        drawn = fleet.sample(self.seed, np.array([0]), self.body)
        if self.coefficients is not None:
            return _numbers("--coefficients", self.coefficients), drawn.paints[0]
        if self.size is None:
            return drawn.coefficients[0], drawn.paints[0]
        size = _numbers("--size", self.size)
        if len(size) != 3 or not (np.isfinite(size).all() and (size > 0.0).all()):
            raise BadConfig(f"--size {self.size}: three numbers above 0, length,height,width")
        found = fleet.nearest(size, self.body or fleet.body_of(size)).coefficients
        assert found is not None
        return found, drawn.paints[0]


def _numbers(name: str, text: str) -> "Array":
    """Numbers between commas."""
    import numpy as np

    from tracker.errors import BadConfig

    try:
        return np.array([float(number) for number in text.split(",")])
    except ValueError:
        raise BadConfig(f"{name} {text}: write numbers between commas, as 1.5,-2,0") from None
