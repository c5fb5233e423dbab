"""One frame as a tracker receives it, and the protocol of what delivers frames."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from tracker.errors import BadConfig, BadDetections, BadMotion
from tracker.geometry import covariance_fault
from tracker.types.camera import Camera
from tracker.types.detections import Detections
from tracker.types.validation import as_floats, as_number, as_rigid, as_whole_number

# How far a camera may move: faster than any car or train, and slower than what is no motion but
# another unit or a jump; m/s, and metres besides, for positions that are corrected at once.
MAX_SPEED = 200.0
MAX_CORRECTION = 5.0


@dataclass(frozen=True, eq=False)
class Frame:
    """Everything that an online tracker may know about one moment. Truth is never in here.

    Raises BadMotion for a matrix that is no such thing, BadConfig for an index that is no whole
    number and a time that is not finite, BadDetections for what are no `Detections`.
    """

    index: int
    """Number of the frame in its sequence, counted from 0."""
    time: float
    """When it was taken, s."""
    detections: Detections | None
    """What the detector found in it, perhaps nothing; None: nothing looked at it, so that trackers
    predict, and hold it against no track."""
    T_now_before: Float[Array, "4 4"] | None = None
    """Moves points of the camera frame of the last frame that was DELIVERED into the camera frame
    of this one, rigid; None at the first frame, and where it is unknown."""
    motion_cov: Float[Array, "6 6"] | None = None
    """Covariance of the left perturbation (translation, rotation vector) of `T_now_before` in the
    camera frame of now; metres, rad. None: it is taken as exact."""
    image: UInt8[Array, "h w 3"] | None = None
    """RGB; None where there is none."""

    def __post_init__(self) -> None:
        assign = object.__setattr__
        if type(self.index) is not int:
            assign(self, "index", as_whole_number("frame index", self.index, BadConfig))
        assign(self, "time", as_number(f"frame {self.index}: time", self.time, BadConfig))
        if not (self.detections is None or isinstance(self.detections, Detections)):
            raise BadDetections(
                f"frame {self.index}: detections of type {type(self.detections).__name__}; give "
                "Detections.of(boxes, scores), or None where nothing looked"
            )
        if self.T_now_before is not None:
            name = f"frame {self.index}: T_now_before"
            assign(self, "T_now_before", as_rigid(name, self.T_now_before, BadMotion))
        if self.motion_cov is not None:
            name = f"frame {self.index}: motion_cov"
            assign(self, "motion_cov", _motion_cov(name, self.motion_cov))

    @property
    def looked_at(self) -> bool:
        """Whether a detector looked at this frame, whatever it found."""
        return self.detections is not None

    @property
    def found(self) -> Detections:
        """The detections; none where nothing looked."""
        return Detections.empty() if self.detections is None else self.detections


def _motion_cov(name: str, given: object) -> Float[Array, "6 6"]:
    cov = as_floats(name, given, BadMotion)
    if cov.shape != (6, 6):
        raise BadMotion(
            f"{name}: its shape is {cov.shape}; give 6x6, of translation and rotation vector"
        )
    fault = _fault_of(cov.tobytes())
    if fault is not None:
        raise BadMotion(f"{name}: {fault}")
    return cov


@lru_cache(maxsize=16)
def _fault_of(covariance: bytes) -> str | None:
    """`covariance_fault`; most drives have one and the same in all frames."""
    return covariance_fault(np.frombuffer(covariance).reshape(6, 6))


def max_step(seconds: float) -> float:
    """The metres that no camera on the road moves in so much time."""
    return MAX_SPEED * seconds + MAX_CORRECTION


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
    """What is wrapped."""

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
