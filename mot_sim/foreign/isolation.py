"""A tracker in a process of its own: what it breaks, prints or eats is its own affair.

The process is forked, so that it starts in milliseconds and the module of a tracker is imported
there alone. It leads a session of its own, and dies with whoever asks it.
"""

import ctypes
import faulthandler
import gc
import os
import pickle
import random
import signal
import socket
import struct
import sys
import tempfile
import traceback
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from math import isfinite
from pathlib import Path
from time import monotonic, process_time, sleep
from typing import IO, Any, Literal, NoReturn
from weakref import finalize

import numpy as np

from mot_sim.foreign.answers import BadRows
from mot_sim.foreign.live import ExternalOnlineTracker
from mot_sim.foreign.processes import ending, kill_group, last_lines
from mot_sim.foreign.protocol import Steps, has_call
from tracker import Frame, Tracks
from tracker.errors import BadConfig, MotionWarning

Which = Literal["foreign", "all", "none"]
# What comes from the process: answer or error, what it is, and CPU seconds, bytes of memory and
# bytes printed by then.
Message = tuple[str, Any, tuple[float, float, float]]
MAX_OUTPUT_MB = 16.0  # that a tracker may print in a trial
MAX_WAITING = 16  # frames that are sent before their answers are awaited
TICK = 0.05  # seconds between looks at a tracker that does not answer
GRACE = 1.0  # seconds in which a process whose pipe is closed must be gone
LENGTH = struct.Struct("!Q")  # before every message
MEGABYTE = 1_000_000.0
LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1  # of Linux: the signal that a process gets when its parent dies


@dataclass(frozen=True)
class Isolation:
    """Which trackers run in processes of their own, and what they may take there."""

    which: Which = "foreign"
    """foreign: those that are not ours; all; or none."""
    time_limit: float = 60.0
    """Seconds of waiting that a tracker may take in a trial, above 0."""
    memory_limit: float = 4096.0
    """Megabytes that its process may take beyond what it starts with, above 0; on Linux only."""

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

    make: builds it, in that process. Raises TrackerStopped where that fails, as every call does.
    `close` ends the process and all that it started; so does the end of this object.
    """

    def __init__(self, make: Callable[[], Steps], limits: Isolation) -> None:
        self.limits = limits
        self.output = ""  # the end of what it printed, known when it is closed
        self.cpu_seconds = 0.0  # that it took in its process
        self._waited = 0.0
        self._read = bytearray()
        self._printed: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115
        self._socket, theirs = socket.socketpair()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # that we have threads
            self._pid = os.fork()
        if self._pid == 0:
            _serve(make, theirs, self._printed)
        self._memory_before = _resident(self._pid)
        theirs.close()
        self._closing = finalize(self, _end, self._pid, os.getpid(), self._socket, self._printed)
        self._is_late = bool(self._receive())

    def step(self, frame: Frame) -> Tracks:
        """What it answers to the frame."""
        self._ask(frame)
        return self._receive()

    def steps(self, frames: Iterable[Frame], asked: Callable[[Frame], None]) -> Iterator[Tracks]:
        """What it answers to each frame; the next ones wait in its process already.

        So neither process waits for the other to be woken. asked: is told of each frame before
        its answer is awaited.
        """
        waiting: deque[Frame] = deque()
        coming = iter(frames)
        while True:
            for frame in islice(coming, MAX_WAITING - len(waiting)):
                self._ask(frame)
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
        self._ask(None)
        return self._receive()

    def close(self) -> None:
        """End the process; nothing can be asked any more."""
        if self._closing.alive:
            self.output = last_lines(self._printed)
            self._closing()

    def _ask(self, frame: Frame | None) -> None:
        """Send a frame; None: ask for the rows that are left."""
        if not self._closing.alive:
            raise TrackerStopped("it was stopped before")
        packed = pickle.dumps(frame, pickle.HIGHEST_PROTOCOL)
        self._socket.settimeout(max(self._left(), TICK))
        try:
            self._socket.sendall(LENGTH.pack(len(packed)) + packed)
        except TimeoutError:
            raise self._too_long() from None
        except OSError:
            return  # it is gone; the answers that it gave before come first

    def _receive(self) -> Any:
        """The next message. Raises TrackerStopped for one of an error, and where none comes."""
        start, before = monotonic(), self._waited
        while (message := self._message()) is None:
            self._socket.settimeout(max(min(self._left(), TICK), 0.001))
            try:
                part = self._socket.recv(1 << 20)
            except TimeoutError:
                part = None
            except OSError:
                part = b""
            self._waited = before + monotonic() - start
            if part == b"":
                raise self._ended()
            if part is None:  # it is at work on what we wait for
                taken = sum(_resident(pid) for pid in _family(self._pid))
                self._require_moderation(taken, os.fstat(self._printed.fileno()).st_size)
                if os.waitid(os.P_PID, self._pid, os.WEXITED | os.WNOHANG | os.WNOWAIT):
                    raise self._ended()
            else:
                self._read += part
        kind, content, (seconds, resident, printed) = message
        self._require_moderation(resident, printed)
        self.cpu_seconds += seconds
        if kind == "answer":
            return content
        raise self._stopped(*content)

    def _message(self) -> Message | None:
        """The message that has come as a whole; None: there is none yet."""
        if len(self._read) < LENGTH.size:
            return None
        end = LENGTH.size + LENGTH.unpack(self._read[: LENGTH.size])[0]
        if len(self._read) < end:
            return None
        packed, self._read = bytes(self._read[LENGTH.size : end]), self._read[end:]
        try:
            found: Message = pickle.loads(packed)
        except Exception as error:  # noqa: BLE001 - whatever its pickle raises
            raise self._stopped(f"its answer cannot be read: {error}") from None
        return found

    def _left(self) -> float:
        return self.limits.time_limit - self._waited

    def _require_moderation(self, resident: float, printed: float) -> None:
        """Raise TrackerStopped for more time, memory or output (bytes) than it may have."""
        if self._left() <= 0.0:
            raise self._too_long()
        if resident - self._memory_before > self.limits.memory_limit * MEGABYTE:
            limit = f"{self.limits.memory_limit:g} MB"
            raise self._stopped(f"it took more than {limit} of memory (--memory-limit)")
        if printed > MAX_OUTPUT_MB * MEGABYTE:
            raise self._stopped(f"it printed more than {MAX_OUTPUT_MB:g} MB")

    def _too_long(self) -> TrackerStopped:
        return self._stopped(f"it took longer than {self.limits.time_limit:g} s (--time-limit)")

    def _ended(self) -> TrackerStopped:
        """It is gone, or does not speak to us any more."""
        deadline, status = monotonic() + GRACE, None
        while status is None and monotonic() < deadline:
            found = os.waitid(os.P_PID, self._pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
            if found is None:
                sleep(0.001)
                continue
            is_exit = found.si_code == os.CLD_EXITED
            status = found.si_status if is_exit else -found.si_status
        if status is None:
            return self._stopped("it closed the pipe that it answers through")
        said = last_lines(self._printed).rpartition("\n")[2]
        return self._stopped(f"its process ended: {ending(status)}{said and f'; it said: {said}'}")

    def _stopped(self, reason: str, kind: str = "") -> TrackerStopped:
        """The error; the process is ended."""
        self.close()
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
    """End the process of a tracker that has one of its own; the end of what it printed."""
    if not isinstance(tracker, IsolatedTracker | ExternalOnlineTracker):
        return ""
    tracker.close()
    return tracker.output


def _end(pid: int, owner: int, pipe: socket.socket, printed: IO[bytes]) -> None:
    """End a process and everything that it started, and let go of what we share with it."""
    if os.getpid() != owner:  # a copy of ours, in some other tracker's process
        return
    kill_group(pid)
    with suppress(ChildProcessError):
        os.waitpid(pid, 0)
    pipe.close()
    printed.close()


def _resident(pid: int) -> float:
    """Bytes of memory that a process has; 0 where that is not known."""
    try:
        pages = Path(f"/proc/{pid}/statm").read_bytes().split()[1]
    except (OSError, IndexError):
        return 0.0
    return float(int(pages) * os.sysconf("SC_PAGE_SIZE"))


def _family(pid: int) -> list[int]:
    """A process and those that it started, as far as the system tells."""
    found, new = [pid], [pid]
    while new:
        try:
            text = Path(f"/proc/{new[-1]}/task/{new.pop()}/children").read_text()
        except OSError:
            continue
        children = [int(word) for word in text.split()]
        found += children
        new += children
    return found


def _serve(make: Callable[[], Steps], pipe: socket.socket, printed: IO[bytes]) -> NoReturn:
    """The life of the process: build the tracker, answer, leave no trace."""
    status = 1
    try:
        os.setsid()
        if sys.platform == "linux":
            LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        gc.freeze()  # what we were forked from is shared, and none of ours to tidy up
        faulthandler.disable()
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        _redirect(printed)
        random.seed(0)  # the same numbers in whatever process the trial is done
        np.random.seed(0)  # noqa: NPY002 - of trackers that draw from there
        warnings.simplefilter("ignore", MotionWarning)
        _answer_all(make, pipe)
        status = 0
    except BaseException:  # noqa: BLE001
        traceback.print_exc()
    finally:
        with suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(status)


def _redirect(printed: IO[bytes]) -> None:
    """Nothing to read, and one file for all that is printed, by Python or below it.

    The streams are new: those of ours may be locked by threads that this process has not.
    """
    for number, source in (
        (0, os.open(os.devnull, os.O_RDONLY)),
        (1, printed.fileno()),
        (2, printed.fileno()),
    ):
        os.dup2(source, number)
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stdout = open(1, "w", 1, encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", 1, encoding="utf-8", closefd=False)  # noqa: SIM115


def _used(start: float) -> tuple[float, float, float]:
    """CPU seconds since then, bytes of memory, and bytes printed, of this process."""
    printed = 0.0
    with suppress(OSError, ValueError, AttributeError):  # a tracker may have closed it
        sys.stdout.flush()
        printed = float(os.fstat(1).st_size)
    return process_time() - start, _resident(os.getpid()), printed


def _answer_all(make: Callable[[], Steps], pipe: socket.socket) -> None:
    """Say whether the tracker decides later; then answer every frame until nobody asks."""
    mine = os.getpid()
    pipe.settimeout(None)
    requests = pipe.makefile("rb")
    tracker: Any = None
    while True:
        start = process_time()
        try:
            if tracker is None:
                tracker = make()
                message: Any = ("answer", has_call(tracker, "finish"))
            else:
                head = requests.read(LENGTH.size)
                if len(head) < LENGTH.size:
                    return
                frame = pickle.loads(requests.read(LENGTH.unpack(head)[0]))
                start = process_time()
                message = ("answer", tracker.finish() if frame is None else tracker.step(frame))
        except BadRows as error:
            message = ("error", (str(error),))
        except (Exception, SystemExit) as error:  # noqa: BLE001
            message = ("error", (str(error), type(error).__name__))
        if os.getpid() != mine:  # a copy that the tracker made of itself came back too
            os._exit(0)
        _send(pipe, (*message, _used(start)))


def _send(pipe: socket.socket, message: Message) -> None:
    """Send a message; one that cannot be packed becomes the error that says so."""
    try:
        packed = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
    except Exception as error:  # noqa: BLE001 - whatever its objects raise
        packed = pickle.dumps(("error", (f"its answer cannot be sent: {error}",), message[2]))
    pipe.sendall(LENGTH.pack(len(packed)) + packed)


__all__ = [
    "DEFAULT_ISOLATION",
    "IsolatedTracker",
    "Isolation",
    "TrackerStopped",
    "close_tracker",
    "steps_of",
]
