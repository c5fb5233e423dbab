"""Image and boxes in, cues out: keypoints, shape and pose, descriptors, as columns."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np
from jaxtyping import Float, Float32
from numpy import ndarray as Array

from tracker.descriptors import DESCRIPTORS, Descriptor, Learned, require_rgb
from tracker.errors import BadConfig, BadImage, BadWeights, UnknownName
from tracker.shape import Hourglass, ShapeFit
from tracker.types import Camera, Frame, SequenceWrapper

POSE = "pose"
# What can be measured in images: keypoints with shape and pose, and one of the descriptors.
CUES = (POSE, *DESCRIPTORS)
# Several cues at once, by one name.
CUE_SETS = {"none": (), "all": (POSE, "appearance")}
STAGES = ("keypoints", "fit", "descriptor")
# Std of a keypoint of the network, as a share of the box's width and height.
KEYPOINT_SHARE = 0.05


def parse_cues(text: str) -> tuple[str, ...]:
    """The cues of `none`, `all`, `classical` or a list such as `pose,appearance`, each once.

    Raises UnknownName, and BadConfig for two descriptors at once.
    """
    found: list[str] = []
    for name in (part.strip() for part in text.split(",")):
        if name not in CUE_SETS and name not in CUES:
            raise UnknownName.of("cue", name, {*CUE_SETS, *CUES})
        found += CUE_SETS.get(name, (name,))
    both = [name for name in DESCRIPTORS if name in found]
    if len(both) > 1:
        raise BadConfig(f"cues {text!r}: {' and '.join(both)} fill one column: keep one of them")
    return tuple(dict.fromkeys(found))


@dataclass(frozen=True, eq=False)
class FrontEnd:
    """What measures cues in images; None: that stage is left out.

    BadConfig when a stage lacks the network that feeds it, BadWeights for a descriptor of another
    network.
    """

    hourglass: Hourglass | None = None
    """The keypoint network."""
    fit: ShapeFit | None = None
    """From keypoints to shape and pose."""
    descriptor: Descriptor | None = None
    """What describes the appearance (eq. 5)."""
    keypoint_share: float = KEYPOINT_SHARE
    """Std of a keypoint at confidence 1, share of the box's sides, 0 < share < 1; more: less
    certain shapes and yaws."""

    def __post_init__(self) -> None:
        needs = self.descriptor is not None and self.descriptor.needs_activations
        if self.hourglass is None and (needs or self.fit is not None):
            raise BadConfig("the fit and the learned descriptor need the keypoint network: give it")
        if not 0.0 < self.keypoint_share < 1.0:
            raise BadConfig(f"keypoint_share {self.keypoint_share:g}: give a share, 0 to 1")
        if isinstance(self.descriptor, Learned) and self.hourglass is not None:
            of, here = self.descriptor.hourglass, self.hourglass.sha256
            if of != here:
                raise BadWeights(
                    f"the descriptor's weights are for the keypoint network {of[:12]}, this one is "
                    f"{here[:12]}: learn them for it, mot-sim train-appearance"
                )

    @classmethod
    def of(cls, cues: str) -> "FrontEnd":
        """What measures these cues (see `parse_cues`), with the shipped weights.

        Raises UnknownName and BadConfig for the cues, BadWeights for a model that is missing.
        """
        named = parse_cues(cues)
        descriptor = next((DESCRIPTORS[name]() for name in named if name in DESCRIPTORS), None)
        needed = POSE in named or (descriptor is not None and descriptor.needs_activations)

        # Mirror images make keypoints better; a descriptor alone needs none.
        hourglass = Hourglass.load(mirrored=POSE in named) if needed else None
        return cls(hourglass, ShapeFit() if POSE in named else None, descriptor)

    def __call__(
        self,
        frame: Frame,
        camera: Camera,
        spent: dict[str, float] | None = None,
        clock: Callable[[], float] = perf_counter,
    ) -> Frame:
        """The frame, its detections with a column for every cue; other columns stay.

        A frame without an image, and a box that shows nothing, has NaN there. spent: seconds of
        the clock are added to it, by the names of STAGES. Raises BadImage for what is not 8-bit
        RGB of the camera's size.
        """
        _check(frame, camera)
        if not frame.looked_at:
            return frame
        seen, watch = frame.found, _Watch(spent, clock)
        keypoints = activations = None
        if self.hourglass is not None:
            keypoints, activations = _look(self.hourglass, frame)
            seen = replace(seen, keypoints=keypoints)
            watch.lap("keypoints")
        if self.fit is not None and keypoints is not None:
            sides = seen.boxes[:, 2:] - seen.boxes[:, :2]
            seen = self.fit(keypoints, camera, self.keypoint_share * sides).onto(seen)
            watch.lap("fit")
        if self.descriptor is not None:
            seen = replace(seen, descriptor=_described(self.descriptor, frame, activations))
            watch.lap("descriptor")
        return replace(frame, detections=seen)


@dataclass(frozen=True, eq=False)
class SequenceWithCues(SequenceWrapper):
    """A drive whose detections get cues while it is played; satisfies `tracker.types.Sequence`."""

    front_end: FrontEnd
    """What measures the cues."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Seconds spent so far, by the names of STAGES."""

    def __iter__(self) -> Iterator[Frame]:
        for frame in self.sequence:
            yield self.front_end(frame, self.camera, self.seconds)


def _check(frame: Frame, camera: Camera) -> None:
    """BadImage for what is not 8-bit RGB, or not of the camera's size."""
    if frame.image is None:
        return
    require_rgb(frame.image)
    height, width = frame.image.shape[:2]
    if (width, height) != camera.image_size:
        raise BadImage(
            f"frame {frame.index}: an image of {width}x{height} pixels, the camera's have "
            f"{camera.image_size[0]}x{camera.image_size[1]}; give images at full size"
        )


def _look(
    hourglass: Hourglass, frame: Frame
) -> tuple[Float[Array, "n 36 3"], Float32[Array, "n c s s"] | None]:
    """What the network sees in the boxes; NaN, and no maps, without an image."""
    if frame.image is None:
        return np.full((len(frame.found), 36, 3), np.nan), None
    bgr = np.ascontiguousarray(frame.image[:, :, ::-1])
    seen = hourglass(bgr, frame.found.boxes)
    return seen.keypoints, seen.activations


def _described(
    descriptor: Descriptor, frame: Frame, activations: Float32[Array, "n c s s"] | None
) -> Float[Array, "n d"]:
    """Descriptors of the boxes; NaN without an image."""
    if frame.image is None:
        return np.full((len(frame.found), descriptor.length), np.nan)
    return descriptor(frame.image, frame.found.boxes, activations)


class _Watch:
    """Adds the time between laps to a tally, if there is one."""

    def __init__(self, tally: dict[str, float] | None, clock: Callable[[], float]) -> None:
        self.tally, self.clock = tally, clock
        self.last = clock()

    def lap(self, stage: str) -> None:
        now = self.clock()
        if self.tally is not None:
            self.tally[stage] = self.tally.get(stage, 0.0) + now - self.last
        self.last = now


__all__ = ["CUES", "CUE_SETS", "POSE", "STAGES", "FrontEnd", "SequenceWithCues", "parse_cues"]
