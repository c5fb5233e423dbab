"""psi of eq. 5: what a car looks like, as a vector. `DESCRIPTORS` is the register."""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

from jaxtyping import Float, Float32, Shaped
from numpy import ndarray as Array

from tracker.descriptors.classical import Classical
from tracker.descriptors.learned import Learned, features_of, pool_maps
from tracker.descriptors.patches import can_be_cut, patches, require_rgb
from tracker.descriptors.weights import Weights, read_training, write_weights


@runtime_checkable
class Descriptor(Protocol):
    """Boxes of an image to vectors: the nearer two of them, the likelier they are one car.

    At distance 1 two cars are as likely one as two.
    """

    @property
    def needs_activations(self) -> bool:
        """Whether it is to be given the keypoint network's activations."""
        ...

    @property
    def length(self) -> int:
        """How many numbers a descriptor has."""
        ...

    def __call__(
        self,
        image: Shaped[Array, "..."],
        boxes: Float[Array, "n 4"],
        activations: Float32[Array, "n c s s"] | None = None,
    ) -> Float[Array, "n d"]:
        """A row a box; NaN for a box that shows nothing. Raises BadImage."""
        ...


DESCRIPTORS: dict[str, Callable[[], Descriptor]] = {
    "appearance": Learned.load,
    "classical": Classical,
}

__all__ = [
    "DESCRIPTORS",
    "Classical",
    "Descriptor",
    "Learned",
    "Weights",
    "can_be_cut",
    "features_of",
    "patches",
    "pool_maps",
    "read_training",
    "require_rgb",
    "write_weights",
]
