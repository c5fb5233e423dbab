"""The standard streams, whatever stands behind them: a terminal, a pipe that ends, nothing."""

import codecs
import errno
import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TextIO

# How characters of ours are written where the encoding has none of them.
ASCII = {"─": "-", "│": "|", "…": "...", "±": "+-", "×": "x", "°": " deg", "–": "-", "—": "-"}  # noqa: RUF001
PLAIN_ERRORS = "mot_sim_plain"


def prepare_streams() -> None:
    """Make stdout and stderr writable in any surroundings; once, before anything is written.

    A closed stdout tells so when it is written to, a closed stderr swallows what it is told.
    Characters that the encoding lacks are written as plain ones. A `COLUMNS` that is no width
    is ignored.
    """
    while os.open(os.devnull, os.O_RDWR) < 2:  # else files opened later would be the streams
        pass
    if sys.stdout is None:
        sys.stdout = _Closed()
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    codecs.register_error(PLAIN_ERRORS, _plain)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and not stream.encoding.lower().startswith("utf"):
            stream.reconfigure(errors=PLAIN_ERRORS)
    columns = os.environ.get("COLUMNS", "")
    if columns and not (columns.isdecimal() and int(columns) > 0):
        del os.environ["COLUMNS"]


@contextmanager
def writing_stdout() -> Iterator[None]:
    """Whatever is written to stdout inside reaches it by the end.

    A reader that has gone is no error: what it would have read is dropped, now and from then
    on. Raises BadOutput where nothing can be written: a closed stream, a full disk.
    """
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        _drop(sys.stdout)
    except OSError as error:
        from tracker.errors import BadOutput

        _drop(sys.stdout)
        why = error.strerror or error
        raise BadOutput(f"standard output: cannot be written: {why}") from None


@contextmanager
def writing_stderr() -> Iterator[None]:
    """Whatever is written to stderr inside reaches it, or is dropped: nobody could be told."""
    try:
        yield
        sys.stderr.flush()
    except OSError:
        _drop(sys.stderr)


def _drop(stream: TextIO) -> None:
    """From now on, what is written to the stream goes nowhere."""
    with suppress(OSError, ValueError):  # a stream of a test has no number
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _plain(error: UnicodeError) -> tuple[str, int]:
    """What is written in place of characters that an encoding lacks."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(ASCII.get(letter, "?") for letter in lacking), error.end


class _Closed(io.TextIOBase):
    """A standard output that was closed before the process began."""

    def write(self, text: str) -> int:
        """Refuse, as the system would."""
        raise OSError(errno.EBADF, os.strerror(errno.EBADF))
