"""The life of a tracker's own process: it builds trackers one after another, and answers."""

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
import traceback
import warnings
from collections.abc import Callable
from contextlib import suppress
from time import process_time
from typing import IO, Any, Literal, NoReturn

import numpy as np

from mot_sim.foreign.answers import BadRows
from mot_sim.foreign.protocol import Steps, has_call
from tracker.errors import MotionWarning

# What comes from the process: answer or error, what it is, and CPU seconds, bytes of memory and
# bytes printed by then.
Message = tuple[str, Any, tuple[float, float, float]]
# What is asked for, with what it needs: make (what builds a fresh tracker; the answer is whether it
# decides later), step (a frame), finish (None: the rows that are left), forget (None: the tracker).
Request = tuple[Literal["make", "step", "finish", "forget"], Any]
IDLE_SECONDS = 5.0  # after which a process without a tracker ends
NOBODY_ASKS = 75  # the exit status of a process that was asked nothing more
LENGTH = struct.Struct("!Q")  # before every message
LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1  # of Linux: the signal that a process gets when its parent dies


def packed(content: Request | Message) -> bytes:
    """A request or a message as it goes through the pipe."""
    body = pickle.dumps(content, pickle.HIGHEST_PROTOCOL)
    return LENGTH.pack(len(body)) + body


def resident(pid: int) -> float:
    """Bytes of memory that a process has; 0 where that is not known."""
    try:
        with open(f"/proc/{pid}/statm", "rb", buffering=0) as file:
            pages = file.read().split()[1]
    except (OSError, IndexError):
        return 0.0
    return float(int(pages) * os.sysconf("SC_PAGE_SIZE"))


def serve(pipe: socket.socket, printed: IO[bytes]) -> NoReturn:
    """Answer what comes through the pipe until nobody asks any more, and leave no trace.

    printed: the file for all that the process prints.
    """
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
        warnings.simplefilter("ignore", MotionWarning)
        _answer_all(pipe)
        status = NOBODY_ASKS
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


def _answer_all(pipe: socket.socket) -> None:
    """Answer every request, until nobody asks."""
    mine, requests = os.getpid(), pipe.makefile("rb")
    tracker: Any = None
    while True:
        pipe.settimeout(IDLE_SECONDS if tracker is None else None)
        try:
            head = requests.read(LENGTH.size)
            body = requests.read(LENGTH.unpack(head)[0]) if len(head) == LENGTH.size else b""
        except TimeoutError:
            return
        if not body:
            return
        start = process_time()
        try:
            verb, given = pickle.loads(body)
            if verb in ("make", "forget"):
                tracker = None
                gc.collect()
                tracker = _fresh(given) if verb == "make" else None
                content: Any = has_call(tracker, "finish")
            else:
                start = process_time()
                content = tracker.finish() if verb == "finish" else tracker.step(given)
            message: Any = ("answer", content)
        except BadRows as error:
            message = ("error", (str(error),))
        except (Exception, SystemExit) as error:  # noqa: BLE001
            message = ("error", (str(error), type(error).__name__))
        if os.getpid() != mine:  # a copy that the tracker made of itself came back too
            os._exit(0)
        _send(pipe, (*message, _used(start)))


def _fresh(make: Callable[[], Steps]) -> Steps:
    """A tracker that draws the same numbers in whatever process its trial is done."""
    random.seed(0)
    np.random.seed(0)  # noqa: NPY002 - of trackers that draw from there
    return make()


def _used(start: float) -> tuple[float, float, float]:
    """CPU seconds since then, bytes of memory, and bytes printed, of this process."""
    printed = 0.0
    with suppress(OSError, ValueError, AttributeError):  # a tracker may have closed it
        sys.stdout.flush()
        printed = float(os.fstat(1).st_size)
    return process_time() - start, resident(os.getpid()), printed


def _send(pipe: socket.socket, message: Message) -> None:
    """Send a message; one that cannot be packed becomes the error that says so."""
    try:
        ready = packed(message)
    except Exception as error:  # noqa: BLE001 - whatever its objects raise
        ready = packed(("error", (f"its answer cannot be sent: {error}",), message[2]))
    pipe.settimeout(None)
    pipe.sendall(ready)


__all__ = ["LENGTH", "Message", "Request", "packed", "resident", "serve"]
