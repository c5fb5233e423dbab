"""The sources of noise of a drive, and the same drive with one of them switched off."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.diagnosis.streams import DetectionStream, same_camera
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import drive_of
from mot_sim.simulation.episodes.extra import Extra
from mot_sim.simulation.sensors import EFFECTS, Miscalibration, Odometry, Timing
from tracker.errors import UnknownName
from tracker.types import Detections

# Effects that measure cues, and the columns that each one fills.
CUE_COLUMNS: dict[str, tuple[str, ...]] = {
    "pose": ("yaw", "size"), "keypoints": ("keypoints",), "shape": ("shape",),
    "appearance": ("descriptor",),
}  # fmt: skip
RECORDING_FRAME_RATE = 10.0  # Hz; of recordings
OTHER_SOURCES = ("odometry", "timing", "frame rate", "miscalibration", "rig")
SOURCES = (*EFFECTS, *OTHER_SOURCES)


def active_sources(conditions: Conditions) -> tuple[str, ...]:
    """The sources that these conditions have, in the order of SOURCES."""
    effects, rig = conditions.effects, conditions.rig
    on = {name: getattr(effects, name) is not None for name in EFFECTS}
    on["odometry"] = conditions.odometry != Odometry()
    on["timing"] = conditions.timing != Timing()
    on["frame rate"] = rig.every > 1
    on["miscalibration"] = conditions.miscalibration != Miscalibration()
    on["rig"] = bool(rig.height_error or rig.pitch_error_deg)
    return tuple(name for name in SOURCES if on[name])


def without(conditions: Conditions, source: str) -> Conditions:
    """The conditions with one source off; of cues all four are, see `SourceAblation.stream`.

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
    """A drive as it is, and with each of its sources off for as long as one likes.

    off: by source, the whole drive without it, all other draws equal. silent: without all. whole:
    sources that cannot be switched off for a while, since they are in the camera's calibration.
    """

    stream: DetectionStream
    off: Mapping[str, DetectionStream]
    silent: DetectionStream

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
        """See above."""
        mine = self.stream.camera
        return frozenset(n for n, each in self.off.items() if not same_camera(each.camera, mine))

    def without(self, source: str, first: int, last: int) -> DetectionStream | None:
        """The drive with a source off from a frame to another; None: that changes nothing there.

        A source of `whole` is off in all of the drive.
        """
        other = self.off[source]
        if source in self.whole:
            return other
        if self.stream.same_as(other, first, last):
            return None
        return self.stream.with_frames_of(other, first, last)

    def without_any(self, first: int, last: int) -> DetectionStream:
        """The drive without all sources from a frame to another; the camera is the true one."""
        mixed, camera = self.stream.with_frames_of(self.silent, first, last), self.silent.camera
        if same_camera(camera, mixed.camera):
            return mixed
        return replace(mixed, recorded=replace(mixed.recorded, camera=camera))


def _stream_without(
    conditions: Conditions, recorded: Extra, seed: int, source: str, base: DetectionStream
) -> DetectionStream:
    """The whole drive without a source, of which nothing else is changed."""
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
    """The log with the boxes that it lacks of another one; equal ones are equal to the last bit.

    Nothing but the missed boxes comes: how nearly a car was missed is part of its score, and
    whether it was missed decides on second boxes, so that both would change if nobody were.
    """
    known = set(_keys(base))
    missed = np.flatnonzero([key not in known for key in _keys(cars)])
    both = [base.detections, cars.detections.select(missed)]
    frames = np.concatenate((base.frames, cars.frames[missed]))
    return DetectionLog.of(frames, Detections.concatenate(both))


def _keys(log: DetectionLog) -> list[tuple[int, bytes]]:
    boxes = np.ascontiguousarray(log.detections.boxes)
    return [(frame, box.tobytes()) for frame, box in zip(log.frames.tolist(), boxes, strict=True)]


__all__ = ["CUE_COLUMNS", "SOURCES", "SourceAblation", "active_sources", "without", "without_all"]
