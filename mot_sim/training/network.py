"""The stacked hourglass in PyTorch (Newell et al., ECCV 2016), and its loss.

Few and small layers: its maps are a quarter of a crop's side, so that OpenCV needs a few
milliseconds per crop. PyTorch is an extra, imported when a network is trained and not before.
"""

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from jaxtyping import Bool, Float32
from numpy import ndarray as Array

from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.augmentation import AugmentedCrops
from tracker.errors import NoTorch, UnknownName
from tracker.shape import KEYPOINTS_36

CURE = "pip install 'mot-sim[train]' (the CPU build of torch is enough)"
POOLED_CELLS = 8  # cells along a side of the activations
TARGET_STD_CELLS = 0.8  # of the target map around a keypoint


def load_torch() -> Any:
    """The module `torch`. Raises NoTorch where it is not installed."""
    try:
        return import_module("torch")
    except ImportError as error:
        raise NoTorch(f"training needs PyTorch ({error}): {CURE}") from error


@dataclass(frozen=True)
class NetworkSize:
    """How large a network is; larger values make it slower and able to learn more."""

    stem: int
    """Channels of the first layer."""
    wide: int
    """Channels of the hourglasses' maps."""
    narrow: int
    """Channels inside the bottlenecks."""
    stacks: int
    """Number of hourglasses in a row."""
    depth: int
    """How often each hourglass halves its maps."""


SIZES = {
    "small": NetworkSize(stem=8, wide=24, narrow=12, stacks=1, depth=2),  # for tests
    "shipped": NetworkSize(stem=24, wide=64, narrow=32, stacks=2, depth=2),
}


def size_of(name: str) -> NetworkSize:
    """The size with a name. Raises UnknownName."""
    if name not in SIZES:
        raise UnknownName.of("size of the network", name, SIZES)
    return SIZES[name]


def build_network(size: NetworkSize) -> Any:
    """The network, with random weights: crops (n, 3, 64, 64) -> maps of every stack, activations.

    Maps (n, 36, 16, 16) are log odds of a keypoint in a cell against its not being seen.
    """
    torch = load_torch()
    nn = torch.nn
    points = len(KEYPOINTS_36)
    parts = {
        "stem": convolution(3, size.stem, 5, 2),
        "entry": nn.Sequential(
            convolution(size.stem, 2 * size.narrow, 3, 2),
            convolution(2 * size.narrow, size.wide, 1),
            residual(size),
        ),
    }
    for stack in range(size.stacks):
        parts[f"hourglass{stack}"] = hourglass(size, size.depth)
        parts[f"features{stack}"] = residual(size)
        parts[f"maps{stack}"] = nn.Conv2d(size.wide, points, 1)
        if stack + 1 < size.stacks:
            parts[f"back{stack}"] = nn.Conv2d(size.wide + points, size.wide, 1)
    return module("Stacked", _stacked, parts, stacks=size.stacks)


def convolution(inputs: int, outputs: int, kernel: int, stride: int = 1) -> Any:
    """Convolution, normalisation over the batch, rectifier."""
    nn = load_torch().nn
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    )


def residual(size: NetworkSize) -> Any:
    """A bottleneck beside an identity connection."""
    nn = load_torch().nn
    last = nn.Sequential(
        nn.Conv2d(size.narrow, size.wide, 1, bias=False), nn.BatchNorm2d(size.wide)
    )
    nn.init.zeros_(last[1].weight)  # it begins as the identity
    change = nn.Sequential(
        convolution(size.wide, size.narrow, 1), convolution(size.narrow, size.narrow, 3), last
    )
    return module("Residual", _residual, {"change": change})


def hourglass(size: NetworkSize, depth: int) -> Any:
    """Down to maps half as large and up again, `depth` times nested."""
    inner = residual(size) if depth == 1 else hourglass(size, depth - 1)
    parts = {"across": residual(size), "down": residual(size), "inner": inner, "up": residual(size)}
    return module("Hourglass", _hourglass, parts)


def module(name: str, forward: Any, parts: dict[str, Any], **more: Any) -> Any:
    """A torch module of parts; its class is made here because torch may not be installed."""
    kind = type(name, (load_torch().nn.Module,), {"forward": forward})
    made = kind()
    for key, part in parts.items():
        made.add_module(key, part)
    for key, value in more.items():
        setattr(made, key, value)
    return made


def _residual(self: Any, x: Any) -> Any:
    return (x + self.change(x)).relu()


def _hourglass(self: Any, x: Any) -> Any:
    functions = load_torch().nn.functional
    low = self.up(self.inner(self.down(functions.max_pool2d(x, 2))))
    return self.across(x) + functions.interpolate(low, scale_factor=2.0, mode="nearest")


def _stacked(self: Any, x: Any) -> Any:
    torch = load_torch()
    first = self.stem(x)
    x = self.entry(first)
    every = []
    features = x
    for stack in range(self.stacks):
        features = getattr(self, f"features{stack}")(getattr(self, f"hourglass{stack}")(x))
        every.append(getattr(self, f"maps{stack}")(features))
        if stack + 1 < self.stacks:
            x = x + getattr(self, f"back{stack}")(torch.cat((features, every[-1]), 1))
    return every, torch.cat((pooled(first), pooled(features)), 1)


def pooled(maps: Any) -> Any:
    """The means of maps in POOLED x POOLED cells."""
    step = maps.shape[-1] // POOLED_CELLS
    return load_torch().nn.functional.avg_pool2d(maps, int(step))


def target_maps(
    shown: AugmentedCrops, cells: int
) -> tuple[Float32[Array, "n k c"], Bool[Array, "n k"]]:
    """The target probability of each of cells x cells cells and then of `not seen`.

    A visible keypoint is a small hill, any other one is not seen. Second: which are visible.
    """
    seen = shown.states == KeypointVisibility.VISIBLE
    at = np.where(seen[:, :, None], shown.keypoints, 0.5) * cells - 0.5
    off = np.arange(cells) - at[:, :, :, None]
    hills = np.exp(-0.5 * (off / TARGET_STD_CELLS) ** 2)
    hills /= hills.sum(axis=3, keepdims=True)
    maps = hills[:, :, 1, :, None] * hills[:, :, 0, None, :] * seen[:, :, None, None]
    flat = maps.reshape(*seen.shape, cells * cells)
    chances = np.concatenate((flat, ~seen[:, :, None]), axis=2)
    return chances.astype(np.float32), seen


def keypoint_loss(every: list[Any], chances: Any) -> Any:
    """Mean cross-entropy per keypoint over the maps of every stack; `not seen` has log odds 0."""
    torch = load_torch()
    total = 0.0
    for maps in every:
        flat = maps.float().flatten(2)
        odds = torch.cat((flat, torch.zeros_like(flat[:, :, :1])), 2)
        total = total - (chances * odds.log_softmax(2)).sum(2).mean()
    return total / len(every)
