"""The learned descriptor: a weighted combination of the keypoint network's activation maps."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Float32, Shaped
from numpy import ndarray as Array

from tracker.descriptors.classical import Classical
from tracker.descriptors.weights import SHIPPED_WEIGHTS, read_weights
from tracker.errors import BadWeights, MissingCue
from tracker.shape import windows_of

COLOURS = Classical(unit=1.0)  # beside the activations


@dataclass(frozen=True, eq=False)
class Learned:
    """psi of eq. 5: activation maps pooled over a grid on the box, and colours, times weights.

    The result is brought to the length 1 / unit, so that its squared distance is a correlation
    (the published code normalises and correlates, too).
    """

    weights: Float32[Array, "f d"]
    """From the features (the channels in every cell, then colours) to the numbers of a
    descriptor."""
    mean: Float32[Array, " f"]
    """Mean of each feature over many cars; it is subtracted first."""
    grid: int
    """Number of cells along each side of the box, >= 1."""
    hourglass: str
    """sha256 of the keypoint network whose activations these weights are for."""
    unit: float = 1.0
    """Distance at which two cars are as likely one as two (`mot-sim train-appearance`), > 0; more:
    all distances become smaller."""

    @classmethod
    def load(cls, path: Path | str | None = None) -> "Learned":
        """The shipped weights, or a file that `mot-sim train-appearance` wrote.

        Raises BadWeights for a file that is missing, damaged, or holds something else.
        """
        return cls(*read_weights(SHIPPED_WEIGHTS if path is None else Path(path)))

    @property
    def needs_activations(self) -> bool:
        """It looks at what the keypoint network saw."""
        return True

    @property
    def length(self) -> int:
        """How many numbers a descriptor has."""
        return self.weights.shape[1]

    def __call__(
        self,
        image: Shaped[Array, "..."],
        boxes: Float[Array, "n 4"],
        activations: Float32[Array, "n c s s"] | None = None,
    ) -> Float[Array, "n d"]:
        """Descriptors of the boxes; NaN rows where the activations are NaN.

        Raises MissingCue without activations, BadWeights for those of another network.
        """
        if activations is None:
            raise MissingCue(
                "the learned descriptor needs the keypoint network's activations: run the network "
                "on these boxes first, or take the classical descriptor"
            )
        channels = activations.shape[1]
        if channels * self.grid**2 + COLOURS.length != len(self.mean):
            wanted = (len(self.mean) - COLOURS.length) // self.grid**2
            raise BadWeights(
                f"{channels} activation maps, the weights of the descriptor are for {wanted}: "
                "learn them for this network, mot-sim train-appearance"
            )
        found = np.full((len(boxes), self.length), np.nan)
        known = np.flatnonzero(np.isfinite(activations[:, 0, 0, 0]))
        given = image, boxes[known], activations[known]
        found[known] = self.project(features_of(*given, self.grid))
        return found

    def project(self, features: Float32[Array, "n f"]) -> Float[Array, "n d"]:
        """The descriptors of features, see `features_of`."""
        seen = ((features - self.mean) @ self.weights).astype(float)
        described: Float[Array, "n d"] = seen / np.maximum(
            np.linalg.norm(seen, axis=1, keepdims=True) * self.unit, 1e-12
        )
        return described


def features_of(
    image: Shaped[Array, "..."],
    boxes: Float[Array, "n 4"],
    activations: Float32[Array, "n c s s"],
    grid: int,
) -> Float32[Array, "n f"]:
    """What the weights are for: pooled activations, and the histograms of `Classical` after them.

    The network learns to find keypoints whatever the paint: it forgets much of the colours.
    """
    colours = COLOURS(image, boxes).astype(np.float32)
    return np.concatenate((pool_maps(activations, boxes, grid), colours), axis=1)


def pool_maps(
    activations: Float32[Array, "n c s s"], boxes: Float[Array, "n 4"], grid: int
) -> Float32[Array, "n f"]:
    """The means of every map's roots over the cells of a grid on each box, a row a box.

    The maps cover the network's square windows, of which the boxes are a part. Activations are
    not negative (a negative one counts as 0); their square roots tell cars apart better.
    """
    n, side = len(boxes), activations.shape[2]
    sides = boxes[:, 2:] - boxes[:, :2]
    shares = sides / windows_of(boxes)[:, 2:]
    edges = 0.5 + (np.arange(grid + 1) / grid - 0.5) * shares[:, :, None]
    maps = np.arange(side) / side
    starts = np.maximum(edges[:, :, :-1, None], maps)
    ends = np.minimum(edges[:, :, 1:, None], maps + 1.0 / side)
    weights = np.maximum(ends - starts, 0.0)
    weights = (weights / weights.sum(axis=3, keepdims=True)).astype(np.float32)
    along, down = weights[:, 0], weights[:, 1]
    roots = np.sqrt(np.maximum(activations, 0.0))
    cells = down[:, None] @ roots @ along.transpose(0, 2, 1)[:, None]
    return cells.reshape(n, activations.shape[1] * grid**2)
