"""A tracker in a process of its own: what it breaks, prints or eats is its own affair."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from math import isfinite
from time import monotonic
from typing import Any, Literal

from mot_sim.foreign.answers import BadRows
from mot_sim.foreign.live import ExternalOnlineTracker
from mot_sim.foreign.processes import ending
from mot_sim.foreign.protocol import Steps
from mot_sim.foreign.serving import Request
from mot_sim.foreign.tracker_process import TrackerProcess, let_go, process_for
from tracker import Frame, Tracks
from tracker.errors import BadConfig

Which = Literal["foreign", "all", "none"]
MAX_OUTPUT_MB = 16.0  # that a tracker may print in a trial
MAX_WAITING = 16  # frames that are sent before their answers are awaited
TICK = 0.05  # seconds between looks at a tracker that does not answer
MEGABYTE = 1_000_000.0


@dataclass(frozen=True)
class Isolation:
    """Which trackers run in processes of their own, and what they may take there."""

    which: Which = "foreign"
    """foreign: those that are not ours; all; or none."""
    time_limit: float = 60.0
    """Seconds of waiting that a tracker may take in a trial, above 0."""
    memory_limit: float = 4096.0
    """Megabytes that its process may take in a trial beyond what it has before, above 0; on Linux
    only."""

    def __post_init__(self) -> None:
        for option, value, unit in (
            ("--time-limit", self.time_limit, "seconds"),
            ("--memory-limit", self.memory_limit, "megabytes"),
        ):
            if not (isfinite(value) and value > 0.0):
                raise BadConfig(f"{option} {value:g}: give {unit} above 0")

    def covers(self, is_ours: bool) -> bool:
        """Whether such a tracker gets a process of its own; nobody does where there is no fork."""
        wanted = self.which == "all" or (self.which == "foreign" and not is_ours)
        return wanted and hasattr(os, "fork")


DEFAULT_ISOLATION = Isolation()


class TrackerStopped(BadRows):
    """A tracker in a process of its own that raised, ended, or took more than it may.

    kind: the name of the error's class, "" where it raised none. said: the end of its output.
    """

    def __init__(self, reason: str, kind: str = "", said: str = "") -> None:
        super().__init__(f"{kind}: {reason}" if kind else reason)
        self.reason, self.kind, self.said = reason, kind, said


class IsolatedTracker:
    """A tracker with `step(frame)`, and `finish()` where it has one, in a process of its own.

    make: builds it, in that process; can be pickled. kind: trackers of one kind (of the same code)
    are served by one process, one after another, as long as none fails. Raises TrackerStopped where
    that fails, as every call does. `close` ends the tracker; the end of this object ends the
    process.
    """

    def __init__(self, make: Callable[[], Steps], limits: Isolation, kind: str) -> None:
        self.limits = limits
        self.output = ""  # the end of what it printed, known when it is closed
        self.cpu_seconds = 0.0  # that it took in its process
        self._kind = kind
        self._waited = 0.0
        self._process: TrackerProcess | None = process_for(kind, limits.memory_limit * MEGABYTE)
        self._is_late = bool(self._answer_to(("make", make)))

    def step(self, frame: Frame) -> Tracks:
        """What it answers to the frame."""
        found: Tracks = self._answer_to(("step", frame))
        return found

    def steps(self, frames: Iterable[Frame], asked: Callable[[Frame], None]) -> Iterator[Tracks]:
        """What it answers to each frame; the next ones wait in its process already.

        So neither process waits for the other to be woken. asked: is told of each frame before
        its answer is awaited.
        """
        waiting: deque[Frame] = deque()
        coming = iter(frames)
        while True:
            for frame in islice(coming, MAX_WAITING - len(waiting)):
                self._ask(("step", frame))
                waiting.append(frame)
            if not waiting:
                return
            asked(waiting.popleft())
            yield self._receive()

    def __getattr__(self, name: str) -> Any:
        if name == "finish" and self._is_late:
            return self._finish
        raise AttributeError(name)

    def _finish(self) -> Tracks:
        """The rows that are left, of one that decides later."""
        found: Tracks = self._answer_to(("finish", None))
        return found

    def close(self, keep: bool = True) -> None:
        """End the tracker; nothing can be asked any more.

        keep: whether its process may serve the next one.
        """
        process, self._process = self._process, None
        if process is None:
            return
        self.output = process.said()
        if keep:
            let_go(process, self._kind)
        else:
            process.end()

    def _running(self) -> TrackerProcess:
        if self._process is None:
            raise TrackerStopped("it was stopped before")
        return self._process

    def _answer_to(self, request: Request) -> Any:
        self._ask(request)
        return self._receive()

    def _ask(self, request: Request) -> None:
        try:
            self._running().send(request, max(self._left(), TICK))
        except TimeoutError:
            raise self._too_long() from None

    def _receive(self) -> Any:
        """What the next message holds. Raises TrackerStopped for an error, and where none comes."""
        process = self._running()
        start, before = monotonic(), self._waited
        message = None
        while message is None:
            try:
                message = process.receive(min(self._left(), TICK))
            except EOFError:
                raise self._ended() from None
            except Exception as error:  # noqa: BLE001 - whatever its pickle raises
                raise self._stopped(f"its answer cannot be read: {error}") from None
            self._waited = before + monotonic() - start
            if message is None:  # it is at work on what we wait for
                self._require_moderation(process.memory(), process.printed_bytes())
                if process.has_ended():
                    raise self._ended()
        kind, content, (seconds, resident, printed) = message
        self._require_moderation(resident, printed)
        self.cpu_seconds += seconds
        if kind == "answer":
            return content
        raise self._stopped(*content)

    def _left(self) -> float:
        return self.limits.time_limit - self._waited

    def _require_moderation(self, resident: float, printed: float) -> None:
        """Raise TrackerStopped for more time, memory or output (bytes) than it may have."""
        if self._left() <= 0.0:
            raise self._too_long()
        if resident - self._running().memory_before > self.limits.memory_limit * MEGABYTE:
            limit = f"{self.limits.memory_limit:g} MB"
            raise self._stopped(f"it took more than {limit} of memory (--memory-limit)")
        if printed > MAX_OUTPUT_MB * MEGABYTE:
            raise self._stopped(f"it printed more than {MAX_OUTPUT_MB:g} MB")

    def _too_long(self) -> TrackerStopped:
        return self._stopped(f"it took longer than {self.limits.time_limit:g} s (--time-limit)")

    def _ended(self) -> TrackerStopped:
        """It is gone, or does not speak to us any more."""
        status = self._running().exit_status()
        if status is None:
            return self._stopped("it closed the pipe that it answers through")
        said = self._running().said().rpartition("\n")[2]
        return self._stopped(f"its process ended: {ending(status)}{said and f'; it said: {said}'}")

    def _stopped(self, reason: str, kind: str = "") -> TrackerStopped:
        """The error; the process is ended."""
        self.close(keep=False)
        return TrackerStopped(reason, kind, self.output)


def steps_of(
    tracker: Steps, frames: Iterable[Frame], asked: Callable[[Frame], None]
) -> Iterator[Tracks]:
    """What a tracker answers to each frame. asked: is told of each before its answer is awaited."""
    if isinstance(tracker, IsolatedTracker):
        yield from tracker.steps(frames, asked)
        return
    for frame in frames:
        asked(frame)
        yield tracker.step(frame)


def close_tracker(tracker: object) -> str:
    """End a tracker that has a process of its own; the end of what it printed."""
    if not isinstance(tracker, IsolatedTracker | ExternalOnlineTracker):
        return ""
    tracker.close()
    return tracker.output


__all__ = [
    "DEFAULT_ISOLATION",
    "IsolatedTracker",
    "Isolation",
    "TrackerStopped",
    "close_tracker",
    "steps_of",
]
