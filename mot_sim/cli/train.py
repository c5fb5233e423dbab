"""`mot-sim train-keypoints` and `train-appearance`: training on rendered cars."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.options import Flag, Verbose, help_of, option
from mot_sim.cli.terminal import INTERRUPTED, OK, Terminal

if TYPE_CHECKING:
    import mot_sim.training.appearance

_of_plan = partial(help_of, "mot_sim.training.learning", "TrainingPlan")
_of_learning = partial(help_of, "mot_sim.training.appearance", "LearningOptions")


@dataclass(frozen=True)
class TrainKeypoints:
    """Train the keypoint network on rendered images.

    mot-sim train-keypoints --out out/keypoints

    mot-sim train-keypoints --out out/keypoints --resume

    mot-sim train-keypoints --out out/better --start mine.onnx --rate 0.0008 --epochs 4

    Crops of cars are rendered first, then the network is trained; both continue where they were
    stopped. The defaults are those of the shipped network. Needs PyTorch:
    pip install 'mot-sim[train]'.
    """

    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Gets hourglass.onnx and .json, the learning curve (CSV, PNG), crops and checkpoint."""
    crops: Annotated[int, option("N", "5800", help=_of_plan("crops"))] = 5800
    epochs: Annotated[int, option("N", "15", help=_of_plan("epochs"))] = 15
    seed: int = 0
    """Seed of the crops and of the training."""
    size: str = "shipped"
    """Size of the network: shipped, or small (to try it out)."""
    held_out: Annotated[int, option("N", "1400", help=_of_plan("held_out"))] = 1400
    rate: Annotated[float, option("R", "0.002", help=_of_plan("rate"))] = 0.002
    start: Annotated[Path | None, option("FILE", "none: random weights")] = None
    """Go on from the weights of this ONNX file, with its .json beside it."""
    resume: Flag = False
    """Continue from the checkpoint in --out, which must be of the same training."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Train, write, and say how good it is."""
        from mot_sim.training.keypoints import train_keypoints
        from mot_sim.training.learning import TrainingPlan

        plan = TrainingPlan(
            crops=self.crops,
            epochs=self.epochs,
            seed=self.seed,
            size=self.size,
            held_out=self.held_out,
            rate=self.rate,
        )
        with terminal.progress() as tell:
            scores = train_keypoints(plan, self.out, tell, self.resume, self.start)
        terminal.write(
            f"{self.out / 'hourglass.onnx'}: PCK@0.1 {scores.pck:.3f} of {scores.seen.sum()} "
            f"visible keypoints of {len(scores.seen)} held-out crops; confidences off by "
            f"{scores.calibration_error:.3f} on average\n"
        )
        return OK


@dataclass(frozen=True)
class TrainAppearance:
    """Learn the weights of the appearance descriptor (eq. 5) on synthetic cars.

    mot-sim train-appearance --out appearance.npz

    Renders the drives of mot_sim.training.appearance, computes the keypoint network's activations
    and solves for the weights: no gradient descent, the same file every time. About 15 minutes.
    """

    out: Annotated[Path, option("FILE", "none: it must be given")]
    """Where the weights go, an .npz."""
    hourglass: Annotated[Path | None, option("FILE", "the shipped one")] = None
    """The keypoint network whose activations are weighted, an ONNX file."""
    drives: Annotated[int | None, option("N", "all")] = None
    """Learn from the first N drives only."""
    grid: Annotated[int, option("N", "4", help=_of_learning("grid"))] = 4
    length: Annotated[int, option("N", "128", help=_of_learning("length"))] = 128
    overwrite: Flag = False
    """Replace the file."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Draw, learn, write, and say how well cars are told apart."""
        from mot_sim.files.writing import require_writable
        from mot_sim.training.appearance import LearningOptions, learn_descriptor, training_drives
        from tracker.descriptors import write_weights
        from tracker.errors import BadConfig, OutputExists
        from tracker.shape import Hourglass

        options = LearningOptions(grid=self.grid, length=self.length)
        drives = training_drives()[: self.drives]
        if self.drives is not None and self.drives < 1:
            raise BadConfig(f"--drives {self.drives}: give 1 or more")
        if self.out.exists() and not self.overwrite:
            raise OutputExists(f"{self.out}: exists already; --overwrite replaces it")
        require_writable(self.out)
        network = Hourglass.load(self.hourglass, mirrored=False)
        try:
            with terminal.progress(
                sum(drive.pictures for drive in drives), unit="frames"
            ) as advance:
                learned = learn_descriptor(_pictures(drives, advance), network, options)
        except KeyboardInterrupt:
            terminal.note("interrupted: nothing is left behind")
            return INTERRUPTED
        write_weights(self.out, learned.weights, learned.provenance(drives, options))
        terminal.write(f"{self.out}: {learned.summary}\n")
        return OK


def _pictures(
    drives: "list[mot_sim.training.appearance.RenderedDrive]", advance: Callable[..., None]
) -> "Iterator[mot_sim.training.appearance.CarPicture]":
    """The pictures of all drives, one after the other, under a progress bar."""
    from mot_sim.training.appearance import car_pictures

    for drive in drives:
        for picture in car_pictures(drive):
            advance(drive.name)
            yield picture
