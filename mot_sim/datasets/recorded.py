"""A recorded drive as a `Sequence`: detections by frame, poses, images loaded when asked for."""

import logging
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import log10
from typing import Protocol, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.datasets.distortion import Distortion
from mot_sim.datasets.images import ImageSource
from tracker.ego import EgoScale
from tracker.errors import BadConfig
from tracker.geometry import adjoint_of, invert
from tracker.types import Camera, Detections, Frame

# That all boxes lie in every Nth frame is no chance if it is less likely than this,
MAX_CHANCE = 1e-3
# and if there are as many such frames.
MIN_LOOKS = 5

log = logging.getLogger(__name__)

# The kind of sequence that a subset is taken of. (Not `Self`: the type checks of the test run
# decorate methods one by one, where `Self` says nothing.)
AnySequence = TypeVar("AnySequence", bound="RecordedSequence")


@dataclass(frozen=True, eq=False)
class DetectionLog:
    """The detections of a whole drive, in the order of frames."""

    frames: Int[Array, " n"]
    """Frame of each row, counted from 0."""
    detections: Detections
    """The boxes, their scores and cues."""

    @classmethod
    def of(cls, frames: Int[Array, " n"], detections: Detections) -> "DetectionLog":
        """The log of rows in any order; inside a frame they keep their order."""
        if (np.diff(frames) < 0).any():
            order = np.argsort(frames, kind="stable")
            frames, detections = frames[order], detections.select(order)
        return cls(frames, detections)

    @classmethod
    def merged(cls, parts: "Iterable[DetectionLog]") -> "DetectionLog":
        """The rows of several detectors in one log; where some say classes, the rest are cars."""
        logs = list(parts)
        frames = np.concatenate([log.frames for log in logs])
        found = [log.detections for log in logs]
        if any(part.kinds is not None for part in found):
            found = [
                part.replaced(kinds=np.full(len(part), "Car")) if part.kinds is None else part
                for part in found
            ]
        return cls.of(frames, Detections.concatenate(found))

    def at(self, frame: int) -> Detections:
        """The detections of one frame, perhaps none."""
        first, last = np.searchsorted(self.frames, [frame, frame + 1])
        return self.detections.select(slice(int(first), int(last)))


# T_now_before and its covariance, see `Frame`; None where unknown.
Motion = tuple[Float[Array, "4 4"] | None, Float[Array, "6 6"] | None]


@runtime_checkable
class MotionSource(Protocol):
    """Gives the camera's motion while a drive is played, not beforehand: visual odometry."""

    def motions(
        self, camera: Camera, log: DetectionLog, frame_count: int, frame_rate: float
    ) -> Iterator[Motion]:
        """The motion of every frame of the recording since the one before it, in turn."""
        ...


@dataclass(frozen=True, eq=False)
class RecordedSequence:
    """A drive read from files; satisfies `tracker.types.Sequence`."""

    name: str
    """How tables and files name it."""
    camera: Camera
    """The camera of the drive."""
    frame_count: int
    """Number of frames of the recording, whether they are delivered or not."""
    log: DetectionLog
    """The detections of all of them."""
    frame_indices: Int[Array, " n"]
    """The frames that are delivered, increasing; all of them unless `subset` chose."""
    Ts_world_cam: Float[Array, "m 4 4"] | None = None
    """One pose per frame of the recording, in any fixed world; None: unknown, or `motion` gives
    it."""
    motion_cov: Float[Array, "6 6"] | None = None
    """Covariance of the left perturbation (translation, rotation vector) of T_now_before over ONE
    frame, metres, rad; None: not stated."""
    images: ImageSource | None = None
    """Where the images come from; None: frames have none."""
    frame_rate: float = 10.0
    """Frames per second, Hz."""
    times: Float[Array, " m"] | None = None
    """When each frame of the recording was taken, s, increasing; None: as the frame rate says."""
    motion: MotionSource | None = None
    """Gives the motion while the drive is played, in place of poses and covariance; None: it does
    not."""
    looked_at: Bool[Array, " m"] | None = None
    """Whether a detector looked at each frame of the recording; None: at all of them."""
    distortion: Distortion | None = None
    """The lens that the boxes of files were seen through; those of `log` and `camera` are of its
    pinhole. None: there is none."""
    kinds: tuple[str, ...] = ("Car",)
    """The classes of the detections, of TRACKED_KINDS; unless it is Car alone, the detections have
    a column `kinds`."""
    ego_scale: EgoScale | None = None
    """Finds the scale of poses that are not in metres while the drive is played, anew each time;
    None: they are in metres."""

    def __len__(self) -> int:
        return len(self.frame_indices)

    def __iter__(self) -> Iterator[Frame]:
        played = self._known_motions() if self.motion is None else self._seen_motions(self.motion)
        if self.ego_scale is not None:
            self.ego_scale.reset()
        for index, (T_now_before, motion_cov) in zip(
            self.frame_indices.tolist(), played, strict=True
        ):
            frame = Frame(
                index=index,
                time=index / self.frame_rate if self.times is None else float(self.times[index]),
                detections=self.detections_at(index),
                T_now_before=T_now_before,
                motion_cov=motion_cov,
                image=None if self.images is None else self.images.load(index),
            )
            yield frame if self.ego_scale is None else self.ego_scale.step(frame)

    def require_cars(self) -> None:
        """BadConfig for detections of other classes, where only cars are known."""
        if self.kinds != ("Car",):
            raise BadConfig(
                f"sequence {self.name}: detections of {', '.join(self.kinds)}, but only cars are "
                "scored here; name a detector of cars (--detections rrc)"
            )

    def detections_at(self, frame: int) -> Detections | None:
        """The detections of a frame, perhaps none at all; None where nothing looked."""
        looked_at = self.looked_at
        if looked_at is not None and 0 <= frame < len(looked_at) and not looked_at[frame]:
            return None
        return self.log.at(frame)

    def looked_at_every(self: AnySequence, every: int | None) -> AnySequence:
        """The same drive with a detector that looked at every so many-th frame only.

        At frame 0, every, ...; or, where all boxes lie in such a row of frames, at those. None:
        as the boxes say, see `looking_interval`; what was decided is logged. Boxes in other
        frames are left out, and counted in a warning. Raises BadConfig for `every` below 1.
        """
        frames = self.log.frames
        chosen = looking_interval(frames) if every is None else every
        if chosen < 1:
            raise BadConfig(f"every {every}: give a whole number of frames, 1 or more")
        if chosen == 1:
            return replace(self, looked_at=None)
        rest = frames % chosen
        first = int(rest[0]) if len(rest) and (rest == rest[0]).all() else 0
        if every is None:
            log.warning(
                "%s: boxes lie in one frame in %d only, from %d on: the others count as frames "
                "that nothing looked at, and get predicted rows; if they were looked at: --every 1",
                self.name, chosen, first,
            )  # fmt: skip
        elif (rest != first).any():
            message = "%s: %d of %d boxes are left out, in frames that were not to be looked at"
            log.warning(message, self.name, np.count_nonzero(rest != first), len(rest))
        return replace(self, looked_at=np.arange(self.frame_count) % chosen == first)

    def subset(self: AnySequence, frame_indices: Iterable[int]) -> AnySequence:
        """The same drive with only these frames delivered; motion is composed over the others.

        Frames keep the index and the time that they have in the recording. Raises BadConfig
        for frames that are not in this sequence, or not in increasing order.
        """
        chosen = np.fromiter(frame_indices, dtype=np.int64)
        missing = chosen[~np.isin(chosen, self.frame_indices)]
        if len(missing):
            raise BadConfig(
                f"sequence {self.name} has no frame {missing[0]}: it has {len(self)} frames "
                f"of 0..{self.frame_count - 1}"
            )
        if (np.diff(chosen) <= 0).any():
            raise BadConfig(f"the frames of a subset of {self.name} must increase: sort them")
        return replace(self, frame_indices=chosen)

    def _known_motions(self) -> Iterator[Motion]:
        """The motions of the delivered frames, from the poses."""
        before: int | None = None
        for index in self.frame_indices.tolist():
            if before is None:
                yield None, None
            else:
                yield self._T_now_before(index, before), self._motion_cov(index, before)
            before = index

    def _seen_motions(self, source: MotionSource) -> Iterator[Motion]:
        """The motions of the delivered frames, composed over the frames in between."""
        every = source.motions(self.camera, self.log, self.frame_count, self.frame_rate)
        numbered = enumerate(every)
        for position, index in enumerate(self.frame_indices.tolist()):
            motion: Motion = (np.eye(4), np.zeros((6, 6)))
            for frame, further in numbered:
                motion = _compose(further, motion)
                if frame == index:
                    break
            yield motion if position else (None, None)

    @cached_property
    def _motions(self) -> Float[Array, "m 4 4"] | None:
        """T_now_before between neighbours of the recording; the first is the identity."""
        if self.Ts_world_cam is None:
            return None
        Ts_now_before = np.empty_like(self.Ts_world_cam)
        Ts_now_before[:1] = np.eye(4)
        Ts_now_before[1:] = invert(self.Ts_world_cam[1:]) @ self.Ts_world_cam[:-1]
        return Ts_now_before

    def _T_now_before(self, now: int, before: int) -> Float[Array, "4 4"] | None:
        if self._motions is None or self.Ts_world_cam is None:
            return None
        if now == before + 1:
            return self._motions[now].copy()
        return invert(self.Ts_world_cam[now]) @ self.Ts_world_cam[before]

    def _motion_cov(self, now: int, before: int) -> Float[Array, "6 6"] | None:
        """The covariances of the single motions, each in the camera frame of `now`, summed."""
        if self._motions is None or self.motion_cov is None:
            return None
        covariance = self.motion_cov.copy()
        for middle in range(before + 2, now + 1):
            adjoint = adjoint_of(self._motions[middle])
            covariance = adjoint @ covariance @ adjoint.T + self.motion_cov
        return covariance


def looking_interval(frames: Int[Array, " n"]) -> int:
    """The N of a detector that ran on every Nth frame, by the numbers of the frames with boxes.

    1 where the boxes of a detector that looks at all frames would lie so with a chance above one
    in a thousand: frames without a box are common, a gap before every box is not.
    """
    numbers = np.unique(frames)
    interval = int(np.gcd.reduce(np.diff(numbers))) if len(numbers) >= MIN_LOOKS else 1
    surely = interval > 1 and (len(numbers) - 1) * log10(interval) >= -log10(MAX_CHANCE)
    return interval if surely else 1


def _compose(now: Motion, before: Motion) -> Motion:
    """One motion after another; unknown if either is. Covariances live in the frame of now."""
    if now[0] is None or before[0] is None:
        return None, None
    if now[1] is None or before[1] is None:
        return now[0] @ before[0], None
    adjoint = adjoint_of(now[0])
    return now[0] @ before[0], adjoint @ before[1] @ adjoint.T + now[1]
