"""`mot-sim teaser`: the paper's first figure, on real frames or on synthetic ones."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mot_sim.cli.options import Flag, Root, Verbose, option, parse_knobs
from mot_sim.cli.terminal import OK, Terminal

if TYPE_CHECKING:
    import mot_sim.report.opening


@dataclass(frozen=True)
class Teaser:
    """Draw the search areas of one frame, carried into the next: the paper's first figure.

    mot-sim teaser --root KITTI --sequence 0001 --frame 20 --out teaser.png

    mot-sim teaser --scene intersection --frame 88 --out teaser.svg

    Frame t with its boxes lifted to the road; frame t + 1 with the areas in which each car is
    expected, and the new boxes; both from above, with ellipses of 1 and 2 standard deviations.
    """

    out: Annotated[Path, option("FILE", "teaser.png")] = Path("teaser.png")
    """FILE.png, FILE.jpg, FILE.svg or FILE.pdf."""
    frame: Annotated[int, option("N", "none: it must be given")] = -1
    """Frame t."""
    root: Root = None
    """A KITTI root or a folder of mot-sim record."""
    sequence: Annotated[str | None, option("NAME", "the only one")] = None
    """Which one of the root, for example 0009."""
    detections: Annotated[str | None, option("NAME", "rrc; simulated")] = None
    """A detector of the tree (mot-sim list)."""
    ego: Annotated[str, option("NAME", "oxts")] = "oxts"
    """How the camera moved: oxts, orbslam3, none."""
    scene: Annotated[str | None, option("NAME")] = None
    """A scene instead of a folder (mot-sim list)."""
    knobs: Annotated[str | None, option("NAME=VALUE,...", "the scene's own")] = None
    """Changes to the scene."""
    seed: int = 0
    """Seed of the scene."""
    cues: Annotated[str, option("NAMES", "pose")] = "pose"
    """What is measured in the images: pose (yaw, size and shape of each car), or none."""
    overwrite: Flag = False
    """Replace an older figure."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Track two frames and draw them."""
        from mot_sim.evaluation.runs import Recipe
        from mot_sim.report.teaser import draw_teaser, save_teaser, track_two_frames

        self._check()
        front_end = Recipe(cues=self.cues).front_end
        with terminal.progress():
            two = track_two_frames(self._request().open(), self.frame, front_end)
            save_teaser(draw_teaser(two), self.out)
        compared, every = int(two.compared.sum()), two.compared.size
        terminal.write(
            f"{self.out}: frames {self.frame} and {self.frame + 1} of {two.name}; {compared} of "
            f"{every} pairs lie in a search area\n"
        )
        return OK

    def _check(self) -> None:
        """What can be checked before any work."""
        from mot_sim.report.teaser import require_picture
        from tracker.errors import BadConfig, OutputExists

        require_picture(self.out)
        if self.out.exists() and not self.overwrite:
            raise OutputExists(f"{self.out}: exists; give --overwrite, or another name")
        if self.frame < 0:
            raise BadConfig("give --frame N, the first of the two frames; they count from 0")
        if self.scene is not None and (self.root or self.sequence):
            raise BadConfig("--scene is run now, --root and --sequence are recorded: keep one")
        if self.scene is None and self.knobs:
            raise BadConfig("--knobs belong to a scene: give --scene too")

    def _request(self) -> "mot_sim.report.opening.DriveRequest":
        """The drive that the options name; of a scene no more frames than needed."""
        from mot_sim.datasets import find_root
        from mot_sim.report.opening import DriveRequest

        if self.scene is None:
            root = str(find_root(self.root))
            return DriveRequest(root, self.sequence, self.detections, self.ego)
        knobs = parse_knobs(self.scene, self.knobs)
        return DriveRequest(
            self.scene, self.sequence, self.detections, self.ego, self.seed, knobs, self.frame + 2
        )
