"""The noise sources of a drive, and the same drive with one of them switched off.

`DetectionStream` is what a tracker is given, in parts that can be exchanged for some frames.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import drive_of
from mot_sim.simulation.episodes.extra import Extra
from mot_sim.simulation.sensors import EFFECTS, Miscalibration, Odometry, Timed, Timing
from tracker.errors import UnknownName
from tracker.geometry import invert
from tracker.types import Camera, Detections, Sequence

MAX_POSE_ROUNDING = 1e-9  # metres, and entries of a rotation matrix
# Effects that measure cues, and the columns that each one fills.
CUE_COLUMNS: dict[str, tuple[str, ...]] = {
    "pose": ("yaw", "size"),
    "keypoints": ("keypoints",),
    "shape": ("shape",),
    "appearance": ("descriptor",),
}
RECORDING_FRAME_RATE = 10.0  # Hz; of recordings
OTHER_SOURCES = ("odometry", "timing", "frame rate", "miscalibration", "rig")
SOURCES = (*EFFECTS, *OTHER_SOURCES)


@dataclass(frozen=True, eq=False)
class DetectionStream:
    """A drive as a tracker receives it, in parts that can be exchanged for some frames."""

    recorded: RecordedSequence
    """Name, camera, poses and their covariance; its detections and frames are replaced by the
    fields below."""
    log: DetectionLog
    """Detections by the frame that delivers them, late or not."""
    frames: Int[Array, " k"]
    """Indices of the delivered frames, increasing."""
    stamps: Float[Array, " m"]
    """Time stamp in seconds of every frame of the recording, delivered or not."""

    @classmethod
    def of(cls, sequence: Sequence) -> "DetectionStream":
        """A recorded sequence, or one as `Timing` delivers it."""
        if not isinstance(sequence, Timed):
            assert isinstance(sequence, RecordedSequence)
            stamps = np.arange(sequence.frame_count) / sequence.frame_rate
            return cls(sequence, sequence.log, sequence.frame_indices, stamps)
        inner = sequence.sequence
        log = inner.log
        if sequence.late:
            late = log.frames + sequence.late
            kept = np.flatnonzero(late < inner.frame_count)
            log = DetectionLog(late[kept], log.detections.select(kept))
        stamps = np.arange(inner.frame_count) / inner.frame_rate
        stamps[inner.frame_indices] = sequence.stamps
        return cls(inner, log, inner.frame_indices, stamps)

    @property
    def camera(self) -> Camera:
        """The camera as the tracker knows it."""
        return self.recorded.camera

    @property
    def frame_count(self) -> int:
        """Of the recording."""
        return self.recorded.frame_count

    @property
    def frame_rate(self) -> float:
        """Of the recording, Hz."""
        return self.recorded.frame_rate

    def until(self, last: int) -> Timed:
        """The frames up to one, as a tracker is given them."""
        frames = self.frames[self.frames <= last]
        whole = replace(self.recorded, log=self.log, frame_indices=frames)
        return Timed(whole, self.stamps[frames])

    def with_frames_of(self, other: "DetectionStream", first: int, last: int) -> "DetectionStream":
        """This stream, with the frames `first` to `last` (both included) of another one.

        Detections, time stamps, which frames are delivered, and the camera's motion are the
        other's inside and this one's outside, to the last bit. The camera stays this one's.
        """
        inside = self._mask(first, last)
        frames = np.concatenate(
            (self.frames[~inside[self.frames]], other.frames[inside[other.frames]])
        )
        return replace(
            self,
            recorded=replace(self.recorded, Ts_world_cam=self._poses_with(other, inside)),
            log=_mixed(self.log, other.log, inside),
            frames=np.sort(frames),
            stamps=np.where(inside, other.stamps, self.stamps),
        )

    def _mask(self, first: int, last: int) -> Bool[Array, " m"]:
        every = np.arange(self.frame_count)
        return (every >= first) & (every <= last)

    def _poses_with(self, other: "DetectionStream", inside: Bool[Array, " m"]) -> Array | None:
        """Poses whose steps are the other's inside; the same array if no pose differs."""
        mine, theirs = self.recorded.Ts_world_cam, other.recorded.Ts_world_cam
        if mine is None or theirs is None or np.array_equal(mine, theirs):
            return mine
        steps = np.where(inside[1:, None, None], _steps(theirs), _steps(mine))
        poses = [mine[0]]
        for step in steps:
            poses.append(poses[-1] @ step)
        return np.array(poses)

    def same_as(self, other: "DetectionStream", first: int, last: int) -> bool:
        """Whether a tracker would be given the same in the frames `first` to `last`."""
        inside = self._mask(first, last)
        mine, theirs = self.recorded.Ts_world_cam, other.recorded.Ts_world_cam
        if mine is not None and theirs is not None and not np.array_equal(mine, theirs):
            off = _steps(mine)[inside[1:]] - _steps(theirs)[inside[1:]]
            if np.abs(off).max(initial=0.0) > MAX_POSE_ROUNDING:
                return False
        delivered = inside & np.isin(np.arange(self.frame_count), (*self.frames, *other.frames))
        a, b = _part(self.log, delivered), _part(other.log, delivered)
        return (
            np.array_equal(self.stamps[inside], other.stamps[inside])
            and np.array_equal(self.frames[inside[self.frames]], other.frames[inside[other.frames]])
            and np.array_equal(a.frames, b.frames)
            and all(_same(vars(a.detections)[n], vars(b.detections)[n]) for n in vars(a.detections))
        )


def same_camera(a: Camera, b: Camera) -> bool:
    """Whether a tracker is given the same calibration of both."""
    return (
        a.image_size == b.image_size
        and np.array_equal(a.K, b.K)
        and np.array_equal(a.T_cam_road, b.T_cam_road)
    )


def _same(a: Array | None, b: Array | None) -> bool:
    if a is None or b is None:
        return a is b
    return np.array_equal(a, b, equal_nan=True)


def _steps(Ts_world_cam: Float[Array, "m 4 4"]) -> Float[Array, "k 4 4"]:
    """T_before_now between neighbours."""
    return invert(Ts_world_cam[:-1]) @ Ts_world_cam[1:]


def _part(log: DetectionLog, inside: Bool[Array, " m"]) -> DetectionLog:
    rows = np.flatnonzero(inside[log.frames])
    return DetectionLog(log.frames[rows], log.detections.select(rows))


def _mixed(mine: DetectionLog, theirs: DetectionLog, inside: Bool[Array, " m"]) -> DetectionLog:
    """The rows of both, inside and outside; cues that one of them lacks are left out."""
    a, b = _part(mine, ~inside), _part(theirs, inside)
    both = type(a.detections).concatenate([a.detections, b.detections])
    return DetectionLog.of(np.concatenate((a.frames, b.frames)), both)


def active_sources(conditions: Conditions) -> tuple[str, ...]:
    """The sources that are on in these conditions, in the order of SOURCES."""
    effects, rig = conditions.effects, conditions.rig
    on = {name: getattr(effects, name) is not None for name in EFFECTS}
    on["odometry"] = conditions.odometry != Odometry()
    on["timing"] = conditions.timing != Timing()
    on["frame rate"] = rig.every > 1
    on["miscalibration"] = conditions.miscalibration != Miscalibration()
    on["rig"] = bool(rig.height_error or rig.pitch_error_deg)
    return tuple(name for name in SOURCES if on[name])


def without(conditions: Conditions, source: str) -> Conditions:
    """The conditions with one source off; one cue switches all four off, see `SourceAblation`.

    Raises UnknownName.
    """
    if source not in SOURCES:
        raise UnknownName.of("source of noise", source, SOURCES)
    if source in CUE_COLUMNS:
        return replace(conditions, detector=replace(conditions.detector, cues=0.0))
    if source in EFFECTS:
        nothing: dict[str, Any] = {source: None}
        return replace(conditions, effects=replace(conditions.effects, **nothing))
    rig = conditions.rig
    off: dict[str, Any] = {
        "odometry": {"odometry": Odometry()},
        "timing": {"timing": Timing()},
        "frame rate": {"rig": replace(rig, frame_rate=RECORDING_FRAME_RATE)},
        "miscalibration": {"miscalibration": Miscalibration()},
        "rig": {"rig": replace(rig, height_error=0.0, pitch_error_deg=0.0)},
    }
    return replace(conditions, **off[source])


def without_all(conditions: Conditions) -> Conditions:
    """The conditions with no noise at all."""
    for source in active_sources(conditions):
        conditions = without(conditions, source)
    return conditions


@dataclass(frozen=True, eq=False)
class SourceAblation:
    """A drive as it is, and with each of its sources off in any window of frames."""

    stream: DetectionStream
    """The drive with all of its sources."""
    off: Mapping[str, DetectionStream]
    """By source, the whole drive without it; all other random draws are equal."""
    silent: DetectionStream
    """The drive without any source."""

    @classmethod
    def of(cls, conditions: Conditions, recorded: Extra, seed: int) -> "SourceAblation":
        """Of a recorded run."""
        stream = DetectionStream.of(drive_of(conditions, recorded, seed).sequence)
        off = {
            source: _stream_without(conditions, recorded, seed, source, stream)
            for source in active_sources(conditions)
        }
        silent = DetectionStream.of(drive_of(without_all(conditions), recorded, seed).sequence)
        return cls(stream, off, silent)

    @property
    def whole(self) -> frozenset[str]:
        """Sources in the camera's calibration, which can only be off in the whole drive."""
        mine = self.stream.camera
        return frozenset(n for n, each in self.off.items() if not same_camera(each.camera, mine))

    def without(self, source: str, first: int, last: int) -> DetectionStream | None:
        """The drive with a source off in frames `first` to `last`; None if that changes nothing.

        A source of `whole` is off in the whole drive.
        """
        other = self.off[source]
        if source in self.whole:
            return other
        if self.stream.same_as(other, first, last):
            return None
        return self.stream.with_frames_of(other, first, last)

    def without_any(self, first: int, last: int) -> DetectionStream:
        """The drive with all sources off in the frames `first` to `last`, and the true camera."""
        mixed, camera = self.stream.with_frames_of(self.silent, first, last), self.silent.camera
        if same_camera(camera, mixed.camera):
            return mixed
        return replace(mixed, recorded=replace(mixed.recorded, camera=camera))


def _stream_without(
    conditions: Conditions, recorded: Extra, seed: int, source: str, base: DetectionStream
) -> DetectionStream:
    """The whole drive without one source; nothing else changes."""
    found = DetectionStream.of(drive_of(without(conditions, source), recorded, seed).sequence)
    if source in CUE_COLUMNS:
        columns = {name: getattr(found.log.detections, name) for name in CUE_COLUMNS[source]}
        log = DetectionLog(base.log.frames, replace(base.log.detections, **columns))
        return replace(found, log=log)
    if source == "misses" and conditions.effects.merges is None:
        alone = without(without(conditions, "misses"), "duplicates")
        cars = DetectionStream.of(drive_of(alone, recorded, seed).sequence)
        return replace(found, log=_with_missed(base.log, cars.log))
    return found


def _with_missed(base: DetectionLog, cars: DetectionLog) -> DetectionLog:
    """The log, and the boxes of another one that it lacks; equal boxes are equal to the last bit.

    Only the missed boxes are added. Simply switching misses off would change more: how nearly a
    car was missed enters its score, and whether it was missed decides about duplicates.
    """
    known = set(_keys(base))
    missed = np.flatnonzero([key not in known for key in _keys(cars)])
    both = [base.detections, cars.detections.select(missed)]
    frames = np.concatenate((base.frames, cars.frames[missed]))
    return DetectionLog.of(frames, Detections.concatenate(both))


def _keys(log: DetectionLog) -> list[tuple[int, bytes]]:
    boxes = np.ascontiguousarray(log.detections.boxes)
    return [(frame, box.tobytes()) for frame, box in zip(log.frames.tolist(), boxes, strict=True)]
