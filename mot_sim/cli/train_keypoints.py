"""`mot-sim train-keypoints`: the keypoint network, trained on renders."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from mot_sim.cli.options import Flag, Verbose
from mot_sim.cli.terminal import OK, Terminal


@dataclass(frozen=True)
class TrainKeypoints:
    """Train the keypoint network on renders.

    mot-sim train-keypoints --out out/keypoints

    mot-sim train-keypoints --out out/keypoints --resume

    Crops of cars are drawn first, then learned from; both go on where they were stopped. The
    defaults are those of the shipped network. Needs PyTorch: pip install 'mot-sim[train]'.
    """

    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Gets hourglass.onnx and .json, the learning curve (CSV, PNG), crops and checkpoint."""
    crops: int = 5800
    """Cars that are drawn; as many again are made by mirroring."""
    epochs: int = 15
    """How often every crop is shown, each time with other paint, light, noise and box."""
    seed: int = 0
    """Of the crops and of the training."""
    size: str = "shipped"
    """Of the network: shipped, or small (for a try)."""
    held_out: int = 1400
    """More crops, of other places and cars, to judge on."""
    resume: Flag = False
    """Go on from the checkpoint in --out, which must be of the same training."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Train, write, and say how good it is."""
        from mot_sim.training.keypoints import train_keypoints
        from mot_sim.training.plan import TrainingPlan

        plan = TrainingPlan(
            crops=self.crops, epochs=self.epochs, seed=self.seed, size=self.size,
            held_out=self.held_out,
        )  # fmt: skip
        with terminal.progress() as tell:
            judged = train_keypoints(plan, self.out, tell, self.resume)
        terminal.write(
            f"{self.out / 'hourglass.onnx'}: PCK@0.1 {judged.pck:.3f} of {judged.seen.sum()} "
            f"visible keypoints of {len(judged.seen)} held-out crops; confidences off by "
            f"{judged.doubt:.3f} on average\n"
        )
        return OK
