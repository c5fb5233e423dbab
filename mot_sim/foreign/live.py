"""A guest that is given one frame at a time, in a process of its own: for sweeps and tests."""

import json
import select
import subprocess
import tempfile
from os import environ
from typing import IO
from weakref import finalize

import numpy as np

from mot_sim.foreign.failure import ExternalTrackerFailed
from mot_sim.foreign.processes import guest_environ, kill, last_lines
from mot_sim.foreign.register import GUESTS, PYTHON, ExternalTracker
from tracker.errors import BadConfig, UnknownName
from tracker.types import Detections, Frame, Tracks


class ExternalOnlineTracker:
    """A guest with `step(frame)`, like our own trackers; one for every drive.

    guest: a name of GUESTS, or a guest with a `live` command. That command is told the frame rate
    in its first line; then each line is a frame, a JSON list of x1 y1 x2 y2 score, which it
    answers with a line of id x1 y1 x2 y2 score. It starts with the first step (a second or two:
    the package imports slowly) and ends with this object. Speeds are those of
    `ExternalSequenceTracker`;
    here the pipe counts too. Raises BadConfig for a guest that knows only folders.
    """

    def __init__(
        self, guest: str | ExternalTracker, frame_rate: float = 10.0, min_score: float | None = None
    ) -> None:
        if isinstance(guest, str):
            if guest not in GUESTS:
                raise UnknownName.of("guest", guest, GUESTS)
            guest = GUESTS[guest]
        if guest.live is None:
            raise BadConfig(f"guest {guest.name} knows only folders: it cannot be stepped")
        self.guest = guest
        self.frame_rate = frame_rate
        self.min_score = guest.min_score if min_score is None else min_score
        self.output = ""  # the end of what it wrote to stderr, known when it is closed
        self._process: subprocess.Popen[str] | None = None
        self._stderr: IO[bytes] | None = None

    def step(self, frame: Frame) -> Tracks:
        """The rows of this frame.

        Raises ExternalTrackerFailed, with stderr, when it ends, hangs or babbles.
        """
        process = self._process or self._start()
        seen = frame.found.select(frame.found.scores >= self.min_score)
        line = self._ask(process, json.dumps(_rows(seen)))
        try:
            rows = np.array(json.loads(line), dtype=float).reshape(-1, 6)
            is_sound = bool(np.isfinite(rows).all() and (rows[:, 0] % 1.0 == 0.0).all())
        except (ValueError, TypeError):
            is_sound = False
        if not is_sound or (rows[:, 0] < 0.0).any():
            raise self._failed(f"frame {frame.index}: no rows id x1 y1 x2 y2 score: {line[:80]!r}")
        ids = rows[:, 0].astype(np.int64)
        frames = np.full(len(ids), frame.index)
        tracks = Tracks(frames, ids, rows[:, 1:5], rows[:, 5])
        tracks.require_unique_ids(f"guest {self.guest.name}")
        return tracks

    def close(self) -> None:
        """End the process; the next step would start a new one, which knows nothing."""
        if self._process is not None:
            self.output = last_lines(self._stderr) if self._stderr is not None else ""
            self._closing()
        self._process = None

    def _start(self) -> "subprocess.Popen[str]":
        """The process, which was told the frame rate."""
        python = self.guest.interpreter()
        words = [word.replace(PYTHON, python) for word in self.guest.live or ()]
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115
        try:
            self._process = subprocess.Popen(
                words,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._stderr,
                env=guest_environ(environ),
                start_new_session=True,
                text=True,
            )
        except OSError as error:
            raise self._failed(f"{words[0]!r} cannot be started: {error.strerror}") from None
        self._closing = finalize(self, _end, self._process, self._stderr)
        self._tell(self._process, f"{self.frame_rate}")
        return self._process

    def _tell(self, process: "subprocess.Popen[str]", line: str) -> None:
        if process.stdin is not None:
            try:
                process.stdin.write(line + "\n")
                process.stdin.flush()
            except OSError:
                raise self._failed("it ended before its drive did") from None

    def _ask(self, process: "subprocess.Popen[str]", line: str) -> str:
        """The answer to a line."""
        self._tell(process, line)
        assert process.stdout is not None
        ready, _, _ = select.select([process.stdout], [], [], self.guest.timeout)
        if not ready:
            raise self._failed(f"no answer for {self.guest.timeout:g} s")
        answer = process.stdout.readline()
        if not answer:
            raise self._failed("it ended before its drive did")
        return answer

    def _failed(self, reason: str) -> ExternalTrackerFailed:
        """The error; the process is ended."""
        process, stderr = self._process, self._stderr
        if process is not None:
            kill(process)
        said = last_lines(stderr) if stderr is not None else ""
        self.close()
        last = said.splitlines()[-1] if said else ""
        return ExternalTrackerFailed(
            self.guest.name, f"{reason}{f'; it said: {last}' if last else ''}", said
        )


def _rows(seen: Detections) -> list[list[float]]:
    """Boxes and scores side by side."""
    return np.column_stack((seen.boxes, seen.scores)).tolist()


def _end(process: "subprocess.Popen[str]", stderr: IO[bytes]) -> None:
    """End a process and let go of its pipes."""
    kill(process)
    for pipe in (process.stdin, process.stdout, stderr):
        if pipe is not None:
            try:
                pipe.close()
            except OSError:  # what it was last told is nobody's concern any more
                continue
