"""Processes of trackers: forked, so that they start in milliseconds, and kept from trial to trial.

The module of a tracker is imported there alone. A process leads a session of its own, and dies with
whoever asks it.
"""

import fcntl
import os
import pickle
import socket
import sys
import tempfile
import warnings
from collections.abc import Hashable
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep
from typing import IO
from weakref import finalize

from mot_sim.foreign.processes import kill_group, last_lines
from mot_sim.foreign.serving import IDLE_SECONDS, LENGTH, Message, Request, packed, resident, serve

GRACE = 1.0  # seconds in which a process must have forgotten its tracker
ENDING = 5.0  # seconds in which a process whose pipe is closed must be gone, on a busy machine too
MAX_IDLE = 8  # processes that wait for a next trial
IDLE_SHARE = 1.0 / MAX_IDLE  # of the memory limit that one of them may hold


class TrackerProcess:
    """A process that builds trackers and asks them, one after another.

    `end` ends it and all that it started; so does the end of this object.
    """

    def __init__(self) -> None:
        self.printed: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115
        fcntl.fcntl(self.printed, fcntl.F_SETFL, os.O_APPEND)  # it is emptied between trials
        self._socket, theirs = socket.socketpair()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # that we have threads
            self.pid = os.fork()
        if self.pid == 0:
            self._socket.close()
            serve(theirs, self.printed)
        theirs.close()
        self.memory_at_start = resident(self.pid)
        self.memory_before = self.memory_at_start  # when its trial began, bytes
        self.open_requests = 0  # whose answers have not come
        self._idle_since = 0.0
        self._read = bytearray()
        self._ending = finalize(self, _end, self.pid, os.getpid(), self._socket, self.printed)

    def end(self) -> None:
        """End it; nothing can be asked any more."""
        self._ending()

    def said(self) -> str:
        """The end of what it printed in this trial."""
        return last_lines(self.printed) if self._ending.alive else ""

    def printed_bytes(self) -> int:
        """How much it printed in this trial."""
        return os.fstat(self.printed.fileno()).st_size

    def memory(self) -> float:
        """Bytes of memory that it has now, and what it started has beside what it shares."""
        return resident(self.pid) + sum(_private(pid) for pid in _family(self.pid)[1:])

    def send(self, request: Request, seconds: float) -> None:
        """Ask. Raises TimeoutError when the request cannot be sent within so many seconds."""
        body = packed(request)
        self._socket.settimeout(seconds)
        with suppress(BrokenPipeError, ConnectionError):  # the answers from before come first
            self._socket.sendall(body)
        self.open_requests += 1

    def receive(self, seconds: float) -> Message | None:
        """The next message; None when none has come within so many seconds.

        Raises EOFError where no more can come; a message that cannot be read raises what its
        objects do.
        """
        while True:
            if len(self._read) >= LENGTH.size:
                end = LENGTH.size + LENGTH.unpack(self._read[: LENGTH.size])[0]
                if len(self._read) >= end:
                    body, self._read = bytes(self._read[LENGTH.size : end]), self._read[end:]
                    self.open_requests -= 1
                    found: Message = pickle.loads(body)
                    return found
            self._socket.settimeout(max(seconds, 0.001))
            try:
                part = self._socket.recv(1 << 20)
            except TimeoutError:
                return None
            except OSError:
                part = b""
            if part == b"":
                raise EOFError
            self._read += part

    def has_ended(self) -> bool:
        """Whether it is gone."""
        return self._state() is not None

    def exit_status(self) -> int | None:
        """Its exit status, a signal below 0; None: it is there, though its pipe is closed."""
        deadline = monotonic() + ENDING
        while (state := self._state()) is None:
            if monotonic() > deadline:
                return None
            sleep(0.001)
        return state.si_status if state.si_code == os.CLD_EXITED else -state.si_status

    def _state(self) -> os.waitid_result | None:
        return os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)

    def rest(self) -> None:
        """Have it forget its tracker and wait for a next one."""
        self.send(("forget", None), GRACE)
        self._idle_since = monotonic()

    def wake(self, memory: float) -> bool:
        """Whether it can serve another trial: it rests, alone, and holds no more bytes than that.

        memory: beyond what it started with.
        """
        if monotonic() - self._idle_since > IDLE_SECONDS - GRACE:
            return False
        try:
            message = self.receive(GRACE)
        except Exception:  # noqa: BLE001 - whatever it sent
            return False
        if message is None or message[0] != "answer" or _family(self.pid) != [self.pid]:
            return False
        self.memory_before = message[2][1]
        self.printed.truncate(0)
        return self.memory_before - self.memory_at_start <= memory


_idle: dict[Hashable, TrackerProcess] = {}
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_idle.clear)  # they are the parent's


def process_for(kind: str, memory_limit: float) -> TrackerProcess:
    """A process for a trial of that kind of tracker: one that rests, else a new one.

    memory_limit: bytes that a trial may take.
    """
    process = _idle.pop(_circumstances(kind), None)
    if process is not None:
        if process.wake(memory_limit * IDLE_SHARE):
            return process
        process.end()
    return TrackerProcess()


def let_go(process: TrackerProcess, kind: str) -> None:
    """Keep a process for the next trial of that kind; end one that still has to answer."""
    key = _circumstances(kind)
    if process.open_requests or key in _idle:
        process.end()
        return
    try:
        process.rest()
    except OSError:
        process.end()
        return
    _idle[key] = process
    while len(_idle) > MAX_IDLE:
        with suppress(KeyError, StopIteration):
            _idle.pop(next(iter(_idle))).end()


def _circumstances(kind: str) -> Hashable:
    """What a process has from its beginning: one that began in others is of no use here."""
    try:
        here = str(Path.cwd())
    except OSError:  # it was removed
        here = ""
    return kind, here, tuple(sys.path), tuple(sorted(os.environ.items()))


def _end(pid: int, owner: int, pipe: socket.socket, printed: IO[bytes]) -> None:
    """End a process and everything that it started, and let go of what we share with it."""
    if os.getpid() != owner:  # a copy of ours, in some other tracker's process
        return
    kill_group(pid)
    with suppress(ChildProcessError):
        os.waitpid(pid, 0)
    pipe.close()
    printed.close()


def _private(pid: int) -> float:
    """Bytes of memory that a process shares with nobody; 0 where that is not known.

    What was forked shares all that it has not written to with those it was forked from, whose
    memory is counted already.
    """
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0.0
    return 1024.0 * sum(int(line.split()[1]) for line in lines if line.startswith("Private_"))


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


__all__ = ["TrackerProcess", "let_go", "process_for"]
