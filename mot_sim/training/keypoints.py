"""From a plan to the files that the tracker loads: crops, training, judgement, export."""

from pathlib import Path

import cv2

from mot_sim.files.writing import require_writable, write_lines
from mot_sim.plotting import write_image
from mot_sim.training.curve import curve_picture
from mot_sim.training.export import export_network
from mot_sim.training.learning import CHECKPOINT_FILE, Progress, train
from mot_sim.training.plan import TrainingPlan
from mot_sim.training.pytorch import load_torch
from mot_sim.training.scores import KeypointScores
from mot_sim.training.shards import FIRST_HELD_OUT_SEED, gather_crops
from tracker.errors import OutputExists

PLACES_PER_SEED = 1_000  # so many places belong to one seed
WEIGHTS_FILE = "hourglass.onnx"
CURVE_FILE = "curve.csv"
CURVE_PICTURE_FILE = "curve.png"
CROPS_FOLDER = "crops"


def train_keypoints(
    plan: TrainingPlan, out: Path, tell: Progress, resume: bool = False
) -> KeypointScores:
    """Draw the crops, train, judge on held-out ones, and write ONNX, JSON and learning curve.

    What is already in `out` of the same plan is used again. Raises NoTorch, OutputExists for a
    checkpoint that `resume` does not ask for, BadOutput for a folder that cannot be written to.
    """
    torch = load_torch()
    require_writable(out / WEIGHTS_FILE)
    if not resume and (out / CHECKPOINT_FILE).exists():
        raise OutputExists(
            f"{out / CHECKPOINT_FILE} is of an earlier training: go on with --resume, or take another "
            "--out"
        )
    torch.set_num_threads(1)  # more threads help little in so small a network, and change bits
    cv2.setNumThreads(1)
    first = plan.seed * PLACES_PER_SEED
    crops = gather_crops(out / CROPS_FOLDER, first, plan.crops, tell)
    held_out = gather_crops(out / CROPS_FOLDER, FIRST_HELD_OUT_SEED + first, plan.held_out, tell)
    learner = train(plan, crops, held_out, out, tell, resume)
    write_curve(learner.curve, out)
    judged = learner.judge(held_out)
    told = {
        "training": plan.told(), "pck_synthetic": round(judged.pck, 4),
        "doubt_synthetic": round(judged.doubt, 4),
    }  # fmt: skip
    export_network(learner.mean, out / WEIGHTS_FILE, told)
    return judged


def write_curve(curve: list[dict[str, float]], out: Path) -> None:
    """The learning curve as CSV and as a picture."""
    if curve:
        rows = [",".join(f"{value:.6g}" for value in row.values()) for row in curve]
        write_lines(out / CURVE_FILE, [",".join(curve[0]), *rows])
        write_image(out / CURVE_PICTURE_FILE, curve_picture(curve))
