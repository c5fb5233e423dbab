"""`train_keypoints`: from a plan to the files that the tracker loads, ONNX and its JSON card."""

import hashlib
import io
import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import UInt8
from numpy import ndarray as Array

from mot_sim.files.writing import require_writable, write_bytes, write_lines
from mot_sim.plotting import write_image
from mot_sim.plotting.canvas import draw_line, draw_text
from mot_sim.training.keypoint_crops import FIRST_HELD_OUT_SEED, gather_crops
from mot_sim.training.learning import CHECKPOINT_FILE, KeypointScores, Progress, TrainingPlan, train
from mot_sim.training.network import load_torch, module
from tracker.errors import BadOutput, OutputExists
from tracker.shape import Hourglass

PLACES_PER_SEED = 1_000
WEIGHTS_FILE = "hourglass.onnx"
CURVE_FILE = "curve.csv"
CURVE_PICTURE_FILE = "curve.png"
CROPS_FOLDER = "crops"
CURVE_PANEL_PIXELS = (420, 260)
CURVE_MARGIN_PIXELS = 44
INK_COLOUR = (60, 60, 60)
PAPER_COLOUR = (255, 255, 255)
LINE_COLOUR = (31, 90, 180)
ONNX_OPSET = 13
OUTPUT_NAMES = ("heatmaps", "activations")
MAX_NETWORK_BYTES = 8_000_000
CARD_FORMAT = 1


def train_keypoints(
    plan: TrainingPlan, out: Path, tell: Progress, resume: bool = False, start: Path | None = None
) -> KeypointScores:
    """Draw crops, train, score on held-out ones; write ONNX, JSON and the learning curve.

    start: an ONNX file of an earlier training that this one goes on from. Files of the same plan
    that are already in `out` are used again. Raises NoTorch, OutputExists for a checkpoint without
    `resume`, BadOutput for a folder that cannot be written to, BadWeights for `start`.
    """
    torch = load_torch()
    if start is not None:
        plan = replace(plan, start=Hourglass.load(start).sha256)
    require_writable(out / WEIGHTS_FILE)
    if not resume and (out / CHECKPOINT_FILE).exists():
        raise OutputExists(
            f"{out / CHECKPOINT_FILE} is of an earlier training: go on with --resume, or take "
            "another --out"
        )
    torch.set_num_threads(1)  # more threads help little in so small a network, and change bits
    cv2.setNumThreads(1)
    first = plan.seed * PLACES_PER_SEED
    crops = gather_crops(out / CROPS_FOLDER, first, plan.crops, tell)
    held_out = gather_crops(out / CROPS_FOLDER, FIRST_HELD_OUT_SEED + first, plan.held_out, tell)
    trainer = train(plan, crops, held_out, out, tell, resume, start=start)
    write_curve(trainer.curve, out)
    scores = trainer.score(held_out)
    facts = {
        "training": plan.as_dict(),
        "pck_synthetic": round(scores.pck, 4),
        "doubt_synthetic": round(scores.calibration_error, 4),
    }
    export_network(trainer.mean, out / WEIGHTS_FILE, facts)
    return scores


def write_curve(curve: list[dict[str, float]], out: Path) -> None:
    """The learning curve as CSV and as a picture."""
    if curve:
        rows = [",".join(f"{value:.6g}" for value in row.values()) for row in curve]
        write_lines(out / CURVE_FILE, [",".join(curve[0]), *rows])
        write_image(out / CURVE_PICTURE_FILE, curve_picture(curve))


def curve_picture(rows: Sequence[dict[str, float]]) -> UInt8[Array, "h w 3"]:
    """One panel per column after the first, drawn over the first; see `KeypointTrainer.curve`."""
    over, *columns = rows[0]
    x = np.array([row[over] for row in rows])
    panels = [_panel(name, over, x, np.array([row[name] for row in rows])) for name in columns]
    return np.ascontiguousarray(np.hstack(panels))


def _panel(name: str, over: str, x: Array, y: Array) -> UInt8[Array, "h w 3"]:
    """One column."""
    width, height = CURVE_PANEL_PIXELS
    canvas = np.full((height, width, 3), PAPER_COLOUR, np.uint8)
    across, down = width - 2 * CURVE_MARGIN_PIXELS, height - 2 * CURVE_MARGIN_PIXELS
    low, high = min(0.0, float(y.min())), max(float(y.max()), 1e-6)
    axes = np.array(
        [
            [CURVE_MARGIN_PIXELS, CURVE_MARGIN_PIXELS],
            [CURVE_MARGIN_PIXELS, CURVE_MARGIN_PIXELS + down],
            [CURVE_MARGIN_PIXELS + across, CURVE_MARGIN_PIXELS + down],
        ]
    )
    draw_line(canvas, axes.astype(float), INK_COLOUR)
    u = CURVE_MARGIN_PIXELS + across * x / max(float(x.max()), 1e-9)
    v = CURVE_MARGIN_PIXELS + down * (1.0 - (y - low) / (high - low))
    draw_line(canvas, np.stack((u, v), axis=1), LINE_COLOUR, 2)
    draw_text(
        canvas,
        f"{name}, at last {y[-1]:.4g}",
        (CURVE_MARGIN_PIXELS, CURVE_MARGIN_PIXELS - 16),
        INK_COLOUR,
        14,
    )
    draw_text(canvas, f"{high:.3g}", (4, CURVE_MARGIN_PIXELS + 6), INK_COLOUR, 12)
    draw_text(
        canvas,
        f"{over} {x.max():.4g}",
        (width - CURVE_MARGIN_PIXELS - 50, height - CURVE_MARGIN_PIXELS + 18),
        INK_COLOUR,
        12,
    )
    return canvas


def export_network(network: Any, path: Path, facts: Mapping[str, Any]) -> Path:
    """Write a network as ONNX, and beside it a JSON with its hash, shapes and `facts`.

    Normalisation is folded into the convolutions. It takes any number of crops at once.
    """
    torch = load_torch()
    shipped = module("Shipped", _last_maps, {"network": network}).eval().float()
    crops = torch.zeros(2, 3, 64, 64)
    with torch.no_grad():
        shapes = [list(output.shape[1:]) for output in shipped(crops)]
    target = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(
            shipped,
            crops,
            target,
            input_names=["crops"],
            output_names=list(OUTPUT_NAMES),
            dynamic_axes={name: {0: "n"} for name in ("crops", *OUTPUT_NAMES)},
            opset_version=ONNX_OPSET,
            dynamo=False,
        )
    content = target.getvalue()
    if len(content) > MAX_NETWORK_BYTES:
        raise BadOutput(
            f"{path}: {len(content)} bytes, more than {MAX_NETWORK_BYTES}: a smaller --size"
        )
    card = {
        "format": CARD_FORMAT,
        "sha256": hashlib.sha256(content).hexdigest(),
        **dict(zip(OUTPUT_NAMES, shapes, strict=True)),
        "mot_sim": version("mot-sim"),
        "torch": str(torch.__version__),
        **facts,
    }
    write_bytes(path, content)
    write_lines(path.with_suffix(".json"), json.dumps(card, indent=2).splitlines())
    return path


def _last_maps(self: Any, crops: Any) -> Any:
    every, activations = self.network(crops)
    return every[-1], activations
