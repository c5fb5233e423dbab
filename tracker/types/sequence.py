"""One frame as a tracker receives it, and the protocol of what delivers frames."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from tracker.types.camera import Camera
from tracker.types.detections import Detections


@dataclass(frozen=True, eq=False)
class Frame:
    """Everything that an online tracker may know about one moment. Truth is never in here.

    index: counts from 0. time: seconds. T_now_before: moves points of the camera frame of the
    last frame that was DELIVERED into the camera frame of this one; None when it is unknown how
    the camera moved, and at the first frame. motion_cov: covariance of its left perturbation
    (translation, then rotation vector) in the camera frame of now; metres, radians.
    image: RGB, or None.
    """

    index: int
    time: float
    detections: Detections
    T_now_before: Float[Array, "4 4"] | None = None
    motion_cov: Float[Array, "6 6"] | None = None
    image: UInt8[Array, "h w 3"] | None = None


@runtime_checkable
class Sequence(Protocol):
    """A drive: a camera, and frames in the order of time. A KITTI sequence and a synthetic
    episode are the same thing to a tracker; ground truth lies apart from it."""

    @property
    def name(self) -> str:
        """How tables and files name this sequence."""
        ...

    @property
    def camera(self) -> Camera:
        """The camera that saw all of it."""
        ...

    def __len__(self) -> int:
        """The number of frames."""
        ...

    def __iter__(self) -> Iterator[Frame]:
        """The frames, images loaded only when they are asked for."""
        ...


@dataclass(frozen=True, eq=False)
class SequenceWrapper:
    """Another sequence under its own name; what wraps one to change its frames begins here."""

    sequence: Sequence

    @property
    def name(self) -> str:
        """The wrapped sequence's."""
        return self.sequence.name

    @property
    def camera(self) -> Camera:
        """The wrapped sequence's."""
        return self.sequence.camera

    def __len__(self) -> int:
        return len(self.sequence)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self.sequence)
