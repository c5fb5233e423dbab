"""`mot-sim train-appearance`: the weights of the appearance descriptor, from synthetic cars."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mot_sim.cli.options import Flag, Verbose, option
from mot_sim.cli.terminal import INTERRUPTED, OK, Terminal

if TYPE_CHECKING:
    import mot_sim.training.identities


@dataclass(frozen=True)
class TrainAppearance:
    """Learn the weights of the appearance descriptor (eq. 5) on synthetic cars.

    mot-sim train-appearance --out appearance.npz

    Draws the drives of mot_sim.training.identities, looks at their cars with the keypoint network,
    and solves for the weights; no gradient descent, the same file every time. About 15 minutes.
    """

    out: Annotated[Path, option("FILE", "none: it must be given")]
    """Where the weights go, an .npz."""
    hourglass: Annotated[Path | None, option("FILE", "the shipped one")] = None
    """The keypoint network whose activations are weighted, an ONNX file."""
    drives: Annotated[int | None, option("N", "all")] = None
    """Learn from the first N drives only."""
    grid: int = 4
    """Cells along each side of the box."""
    length: int = 128
    """Numbers of a descriptor."""
    overwrite: Flag = False
    """Replace the file."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Draw, learn, write, and say how well cars are told apart."""
        from mot_sim.files.writing import require_writable
        from mot_sim.training.appearance import LearningOptions, learn
        from mot_sim.training.identities import lessons
        from tracker.descriptors import write_weights
        from tracker.errors import BadConfig, OutputExists
        from tracker.shape import Hourglass

        options = LearningOptions(grid=self.grid, length=self.length)
        drives = lessons()[: self.drives]
        if self.drives is not None and self.drives < 1:
            raise BadConfig(f"--drives {self.drives}: give 1 or more")
        if self.out.exists() and not self.overwrite:
            raise OutputExists(f"{self.out}: exists already; --overwrite replaces it")
        require_writable(self.out)
        network = Hourglass.load(self.hourglass)
        try:
            pictures = sum(drive.pictures for drive in drives)
            with terminal.progress(pictures, unit="frames") as advance:
                learned = learn(_watched(drives, advance), network, options)
        except KeyboardInterrupt:
            terminal.note("interrupted: nothing is left behind")
            return INTERRUPTED
        write_weights(self.out, learned.weights, learned.training(drives, options))
        terminal.write(f"{self.out}: {learned.summary}\n")
        return OK


def _watched(
    drives: "list[mot_sim.training.identities.RenderedDrive]", advance: Callable[..., None]
) -> "Iterator[mot_sim.training.identities.Sight]":
    """The pictures of all drives, one after the other, under a progress bar."""
    from mot_sim.training.identities import sights_of

    for drive in drives:
        for sight in sights_of(drive):
            advance(drive.name)
            yield sight
