"""A network that goes on learning from the weights of an ONNX file, as `export_network` wrote it.

The file holds convolutions into which the normalisation was folded. It is unfolded again: what a
layer gives over some crops tells the mean and the spread that the normalisation takes away, and
its own scale and offset put them back, so that the network begins with exactly those outputs.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy import ndarray as Array

from mot_sim.training.augmentation import augmented_crops
from mot_sim.training.keypoint_crops import Crops
from mot_sim.training.network import CURE, load_torch
from tracker.errors import BadWeights, NoTorch
from tracker.shape import Hourglass, network_input

CALIBRATION_CROPS = 320  # and their mirror images
CALIBRATION_BATCH = 64
MIN_VARIANCE = 1e-6


def begin_with(network: Any, path: Path, crops: Crops, seed: int) -> None:
    """Give a network, in place, the weights of a file.

    crops: the crops to be learned from; some of them tell the layers' spreads. Raises BadWeights
    for files that `Hourglass.load` refuses or that hold a network of another size, and NoTorch
    where `onnx` is not installed.
    """
    Hourglass.load(path)
    torch = load_torch()
    modules, folded = dict(network.named_modules()), _convolutions(path)
    order = _in_order(network, torch)
    shapes = [tuple(modules[name].weight.shape) for name in order]
    if shapes != [weight.shape for weight, _ in folded]:
        raise BadWeights(
            f"{path} holds {len(folded)} convolutions of other shapes than this network's "
            f"{len(order)}: give the --size that it was trained with"
        )
    normalised: dict[str, Any] = {}
    for name, (weight, bias) in zip(order, folded, strict=True):
        modules[name].weight.data.copy_(torch.tensor(weight))
        if modules[name].bias is not None:
            modules[name].bias.data.copy_(torch.tensor(bias))
            continue
        parent, _, number = name.rpartition(".")
        layer = normalised[name] = modules[f"{parent}.{int(number) + 1}"]
        layer.weight.data.fill_((1.0 + layer.eps) ** 0.5)
        layer.bias.data.copy_(torch.tensor(bias))
        layer.running_mean.zero_()
        layer.running_var.fill_(1.0)
    _unfold(network, modules, normalised, crops, seed)


def _convolutions(path: Path) -> list[tuple[Array, Array]]:
    """Weights and biases of a file's convolutions, in the order in which they are computed."""
    try:
        onnx, numpy_helper = import_module("onnx"), import_module("onnx.numpy_helper")
    except ImportError as error:
        raise NoTorch(f"beginning with weights needs onnx ({error}): {CURE}") from error
    graph = onnx.load(str(path)).graph
    held = {each.name: numpy_helper.to_array(each) for each in graph.initializer}
    return [
        (held[node.input[1]], held[node.input[2]])
        for node in graph.node
        if node.op_type == "Conv" and len(node.input) == 3
    ]


def _in_order(network: Any, torch: Any) -> list[str]:
    """Names of a network's convolutions, in the order in which they are computed."""
    order: list[str] = []
    hooks = [
        module.register_forward_hook(lambda *_, name=name: order.append(name))
        for name, module in network.named_modules()
        if isinstance(module, torch.nn.Conv2d)
    ]
    network.eval()
    with torch.no_grad():
        network(torch.zeros(1, 3, 64, 64))
    for hook in hooks:
        hook.remove()
    return order


def _unfold(
    network: Any, modules: dict[str, Any], normalised: dict[str, Any], crops: Crops, seed: int
) -> None:
    """Set means and spreads of the normalisations; what the network gives stays the same."""
    torch = load_torch()
    sums: dict[str, list[Any]] = {name: [0, 0.0, 0.0] for name in normalised}

    def note(name: str) -> Any:
        def hook(_module: Any, _inputs: Any, given: Any) -> None:
            count, total, squares = sums[name]
            values = given.double()
            sums[name] = [
                count + values.numel() // values.shape[1],
                total + values.sum((0, 2, 3)),
                squares + values.square().sum((0, 2, 3)),
            ]

        return hook

    hooks = [modules[name].register_forward_hook(note(name)) for name in normalised]
    step = max(len(crops) // CALIBRATION_CROPS, 1)
    shown = augmented_crops(crops, np.arange(0, len(crops), step)[:CALIBRATION_CROPS], seed, 0)
    with torch.no_grad():
        for start in range(0, len(shown.images), CALIBRATION_BATCH):
            some = shown.images[start : start + CALIBRATION_BATCH]
            network(torch.from_numpy(network_input(some)))
    for hook in hooks:
        hook.remove()
    for name, layer in normalised.items():
        count, total, squares = sums[name]
        mean = total / count
        variance = (squares / count - mean**2).clamp_min(MIN_VARIANCE)
        layer.running_mean.copy_(mean.float())
        layer.running_var.copy_(variance.float())
        layer.weight.data.copy_((variance + layer.eps).sqrt().float())
        layer.bias.data.add_(mean.float())
