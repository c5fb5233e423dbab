"""From a trained network to the two files that the tracker loads: ONNX, and what is told of it."""

import hashlib
import io
import json
import warnings
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from mot_sim.files.writing import write_bytes, write_lines
from mot_sim.training.network import module
from mot_sim.training.pytorch import load_torch
from tracker.errors import BadOutput

ONNX_OPSET = 13
OUTPUT_NAMES = ("heatmaps", "activations")
MAX_NETWORK_BYTES = 8_000_000
CARD_FORMAT = 1


def export_network(network: Any, path: Path, told: Mapping[str, Any]) -> Path:
    """Write a network as ONNX, and beside it a JSON with its hash, shapes and `told`.

    Normalisation is folded into the convolutions. Any number of crops can be given at once.
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
            shipped, crops, target, input_names=["crops"], output_names=list(OUTPUT_NAMES),
            dynamic_axes={name: {0: "n"} for name in ("crops", *OUTPUT_NAMES)}, opset_version=ONNX_OPSET,
            dynamo=False,
        )  # fmt: skip
    content = target.getvalue()
    if len(content) > MAX_NETWORK_BYTES:
        raise BadOutput(
            f"{path}: {len(content)} bytes, more than {MAX_NETWORK_BYTES}: a smaller --size"
        )
    card = {
        "format": CARD_FORMAT, "sha256": hashlib.sha256(content).hexdigest(),
        **dict(zip(OUTPUT_NAMES, shapes, strict=True)),
        "mot_sim": version("mot-sim"), "torch": str(torch.__version__), **told,
    }  # fmt: skip
    write_bytes(path, content)
    write_lines(path.with_suffix(".json"), json.dumps(card, indent=2).splitlines())
    return path


def _last_maps(self: Any, crops: Any) -> Any:
    every, activations = self.network(crops)
    return every[-1], activations
