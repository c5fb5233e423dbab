"""Frames that never come, come with a wrong time stamp, or tell of a moment that is past."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.checks import require_rates, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import FRAME_ID, Autocorrelation, bursts
from tracker.errors import BadConfig
from tracker.types import Frame, SequenceWrapper

MAX_STAMP_ERROR_STEPS = 0.45  # steps that a time stamp is off at most, so that time goes forward


@dataclass(frozen=True)
class Timing:
    """Which frames come, with what time stamp, and how old their detections are."""

    drops: float = 0.0
    """Rate of lost frames, 0 to 1; more: more frames never come (the first always does)."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How losses are correlated over time; slower: more frames are lost in a row."""
    jitter: float = 0.0
    """Std of a time stamp's error, seconds, >= 0; at most 0.45 of a step is applied."""
    latency: float = 0.0
    """Seconds, >= 0, by which detections are older than their frame, rounded to whole frames."""
    every: int = 1
    """The detector looks at every so-many-th frame, 1 or more; others come without detections, as
    frames that nobody looked at."""

    def __post_init__(self) -> None:
        if self.every < 1:
            raise BadConfig(f"timing every {self.every}: give a whole number of frames, 1 or more")
        require_rates("timing drops", self.drops)
        require_sigmas("timing jitter, latency", self.jitter, self.latency)

    def delivered(self, frame_count: int, seed: int, step: float) -> Int[Array, " k"]:
        """The frames that come; the first always does."""
        frames = np.arange(frame_count)
        rates = np.where(frames > 0, self.drops, 0.0)
        owner = np.full_like(frames, FRAME_ID)
        return frames[~bursts(rates, seed, "drop", owner, frames, self.autocorrelation, step)]

    def stamps(self, frames: Int[Array, " k"], seed: int, step: float) -> Float[Array, " k"]:
        """The times that are written on frames; they increase."""
        if self.jitter == 0.0:
            return frames * step
        error = (
            self.jitter
            * random_numbers.normal(seed, "stamp", np.full_like(frames, FRAME_ID), frames)[:, 0]
        )
        return frames * step + error.clip(
            -MAX_STAMP_ERROR_STEPS * step, MAX_STAMP_ERROR_STEPS * step
        )

    def __call__(self, sequence: RecordedSequence, seed: int) -> "Timed":
        """The sequence as it arrives."""
        step = 1.0 / sequence.frame_rate
        kept = np.intersect1d(
            sequence.frame_indices, self.delivered(sequence.frame_count, seed, step)
        )
        stamps = self.stamps(kept, seed, step)
        return Timed(sequence.subset(kept.tolist()), stamps, round(self.latency / step), self.every)


@dataclass(frozen=True, eq=False)
class Timed(SequenceWrapper):
    """A sequence with time stamps of its own, and with old detections."""

    sequence: RecordedSequence
    """The frames that come."""
    stamps: Float[Array, " k"]
    """Time stamp of each frame, seconds, increasing."""
    late: int = 0
    """How many frames older than their frame the detections are, >= 0."""
    every: int = 1
    """Frames whose index is a multiple of it have detections."""

    def __iter__(self) -> Iterator[Frame]:
        for frame, stamp in zip(self.sequence, self.stamps.tolist(), strict=True):
            detections = frame.detections
            if self.late:
                detections = self.sequence.detections_at(frame.index - self.late)
            if frame.index % self.every:
                detections = None
            yield replace(frame, time=stamp, detections=detections)
