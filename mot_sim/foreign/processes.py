"""Commands run to their end: one core, one thread, a time limit, stderr kept."""

import os
import signal
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from mot_sim.foreign.failure import ExternalTrackerFailed

STDERR_LINES, STDERR_BYTES = 20, 16_384  # how much of the end of stderr is shown
GRACE = 5.0  # seconds that a killed process has to be gone
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")
OURS = ("PYTHONPATH", "PYTHONHOME", "PYTHONSTARTUP", "VIRTUAL_ENV")  # not the guests' business


def run_process(guest: str, command: Sequence[str], timeout: float) -> str:
    """Run a command to its end; gives the end of its stderr.

    stdin is empty, stdout is dropped, numerical libraries have one thread. Raises
    ExternalTrackerFailed
    when it cannot be started, ends with another status than 0, or takes longer than `timeout`
    seconds; then it and all that it started are killed, as they are when we are interrupted.
    """
    with tempfile.TemporaryFile() as stderr:
        try:
            process = subprocess.Popen(
                list(command),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=stderr,
                env=guest_environ(os.environ),
                start_new_session=True,
            )
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise ExternalTrackerFailed(
                guest, f"{command[0]!r} cannot be started: {reason}"
            ) from None
        with process:
            try:
                status = process.wait(timeout)
            except subprocess.TimeoutExpired:
                kill(process)
                said = last_lines(stderr)
                reason = f"not done after {timeout:g} s and killed; --timeout gives it longer"
                raise ExternalTrackerFailed(guest, reason, said) from None
            except BaseException:
                kill(process)
                raise
        said = last_lines(stderr)
    if status != 0:
        raise ExternalTrackerFailed(guest, f"{ending(status)} from {Path(command[0]).name}", said)
    return said


def guest_environ(ours: Mapping[str, str]) -> dict[str, str]:
    """Our environment variables without what is about our own Python, and one thread."""
    kept = {name: value for name, value in ours.items() if name not in OURS}
    return kept | dict.fromkeys(THREADS, "1")


@contextmanager
def one_core() -> Iterator[None]:
    """Keeps this process, and those it starts meanwhile, on one core where the system can."""
    if not hasattr(os, "sched_setaffinity"):  # not on macOS
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def kill(process: "subprocess.Popen[Any]") -> None:
    """End a process and everything that it started; it leads a session of its own."""
    kill_group(process.pid)
    with suppress(subprocess.TimeoutExpired):
        process.wait(GRACE)


def kill_group(leader: int) -> None:
    """End a process that leads a session of its own, or is about to, and all that is in it."""
    for kill_all in (os.killpg, os.kill):
        with suppress(ProcessLookupError, PermissionError):
            kill_all(leader, signal.SIGKILL)


def ending(status: int) -> str:
    """An exit status in words."""
    if status >= 0:
        return f"exit status {status}"
    with suppress(ValueError):
        return f"killed by {signal.Signals(-status).name}, exit status {status}"
    return f"exit status {status}"


def last_lines(stderr: IO[bytes]) -> str:
    """The end of what was written."""
    size = stderr.seek(0, os.SEEK_END)
    stderr.seek(max(size - STDERR_BYTES, 0))
    text = stderr.read().decode("utf-8", errors="replace")
    return "\n".join(text.rstrip().splitlines()[-STDERR_LINES:])
