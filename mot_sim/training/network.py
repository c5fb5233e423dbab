"""The stacked hourglass in PyTorch (Newell et al., ECCV 2016), made of few and small layers.

Its maps are a quarter of a crop's side: OpenCV then needs a few milliseconds a crop.
"""

from dataclasses import dataclass
from typing import Any

from mot_sim.training.pytorch import load_torch
from tracker.errors import UnknownName
from tracker.shape import KEYPOINTS_36

POOLED_CELLS = 8  # cells along a side of the activations


@dataclass(frozen=True)
class NetworkSize:
    """How large a network is. stem: channels of the first layer; wide, narrow: of the rest."""

    stem: int
    wide: int
    narrow: int
    stacks: int
    depth: int  # how often an hourglass halves its maps


SIZES = {
    "small": NetworkSize(stem=8, wide=24, narrow=12, stacks=1, depth=2),  # for tests
    "shipped": NetworkSize(stem=24, wide=64, narrow=32, stacks=2, depth=2),
}


def size_of(name: str) -> NetworkSize:
    """The size of a name; UnknownName for another."""
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
    """A bottleneck beside a straight line."""
    nn = load_torch().nn
    last = nn.Sequential(
        nn.Conv2d(size.narrow, size.wide, 1, bias=False), nn.BatchNorm2d(size.wide)
    )
    nn.init.zeros_(last[1].weight)  # it begins as the straight line
    change = nn.Sequential(
        convolution(size.wide, size.narrow, 1), convolution(size.narrow, size.narrow, 3), last
    )
    return module("Residual", _residual, {"change": change})


def hourglass(size: NetworkSize, depth: int) -> Any:
    """Down to maps half as large, and up again, so many times."""
    inner = residual(size) if depth == 1 else hourglass(size, depth - 1)
    parts = {
        "across": residual(size), "down": residual(size), "inner": inner, "up": residual(size)
    }  # fmt: skip
    return module("Hourglass", _hourglass, parts)


def module(name: str, forward: Any, parts: dict[str, Any], **more: Any) -> Any:
    """A torch module of parts; its class is made here, since torch may not be installed."""
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
