"""Trackers that misbehave, in eight kinds: in frame 2, where nothing was detected."""

import os
import signal
import sys
import time
from pathlib import Path
from typing import ClassVar

import numpy as np

from tests.mot_sim.experiments.odd import rows
from tracker import Frame, Tracks

NOTE = "MISBEHAVING_NOTE"  # the variable that names a file for the ids of processes left behind


class Sound:
    """Gives every box as a car of its own, until it misbehaves."""

    def step(self, frame: Frame) -> object:
        if frame.index == 2 and len(frame.found) == 0:
            return self.misbehave(frame)
        return rows(frame, range(len(frame.found)), frame.found.boxes)

    def misbehave(self, frame: Frame) -> object:
        """What is wrong with it."""
        return Tracks.empty()


class Hangs(Sound):
    def misbehave(self, frame: Frame) -> object:
        while True:
            time.sleep(0.1)


class Exits(Sound):
    def misbehave(self, frame: Frame) -> object:
        sys.stderr.write("no licence\n")
        sys.stderr.flush()
        os._exit(3)


class IsKilled(Sound):
    def misbehave(self, frame: Frame) -> object:
        os.kill(os.getpid(), signal.SIGKILL)
        return None


class Forks(Sound):
    """Ends and leaves a copy, which holds all that it held, the pipe for its answers too."""

    def misbehave(self, frame: Frame) -> object:
        copy = os.fork()
        if copy:
            if NOTE in os.environ:
                Path(os.environ[NOTE]).write_text(str(copy))
            os._exit(0)
        time.sleep(60)
        return None


class Eats(Sound):
    def misbehave(self, frame: Frame) -> object:
        self.food = [np.ones(5_000_000) for _ in range(20)]  # 800 MB
        return Tracks.empty()


class Prints(Sound):
    def misbehave(self, frame: Frame) -> object:
        for _ in range(100):
            os.write(1, b"a" * 1_000_000)
        return Tracks.empty()


class Raises(Sound):
    def misbehave(self, frame: Frame) -> object:
        raise ZeroDivisionError("no car at all")


class GivesSizes(Sound):
    def misbehave(self, frame: Frame) -> object:
        corners = np.array([[500.0, 190, 560, 230]])
        return np.column_stack((corners[:, :2], corners[:, 2:] - corners[:, :2], [1]))


class Copies(Sound):
    """A copy of it comes back from the step as well; that is nobody's concern."""

    def misbehave(self, frame: Frame) -> object:
        os.fork()
        return Tracks.empty()


class WaitsForCopies(Sound):
    """Waits for three copies of itself, each with some MB of its own."""

    megabytes = 1

    def misbehave(self, frame: Frame) -> object:
        copies = []
        for _ in range(3):
            copies.append(os.fork())
            if copies[-1] == 0:
                food = np.ones(self.megabytes * 125_000)
                time.sleep(0.5)
                os._exit(len(food) == 0)
        for copy in copies:
            os.waitpid(copy, 0)
        return Tracks.empty()


class WaitsForEatingCopies(WaitsForCopies):
    megabytes = 40


class CannotBeMade(Sound):
    def __init__(self, kind: str = "RuntimeError") -> None:
        raise {"RuntimeError": RuntimeError, "AttributeError": AttributeError}[kind]("no weights")


class Remembers(Sound):
    """Its answers say how many of its kind were in this process, and what was drawn there."""

    made: ClassVar[list[int]] = []
    food: ClassVar[object] = None

    def __init__(self) -> None:
        self.made.append(len(self.made))
        sys.stdout.write(f"made {self.made[-1]} {np.random.randint(1_000_000)}\n")  # noqa: NPY002

    def step(self, frame: Frame) -> object:
        if frame.index == 7:
            self.made.append(os.spawnlp(os.P_NOWAIT, "sleep", "sleep", "60"))
        if frame.index == 8:
            Remembers.food = np.ones(10_000_000)  # 80 MB, of which 300 / 8 may stay
        return rows(frame, [os.getpid()], np.array([[500.0, 190, 560, 230]]))


KINDS = {
    "Hangs": "frame 2: it took longer than 1 s (--time-limit)",
    "Exits": "frame 2: its process ended: exit status 3; it said: no licence",
    "IsKilled": "frame 2: its process ended: killed by SIGKILL, exit status -9",
    "Forks": "frame 2: its process ended: exit status 0",
    "Eats": "frame 2: it took more than 300 MB of memory (--memory-limit)",
    "Prints": "frame 2: it printed more than 16 MB",
    "Raises": "frame 2: ZeroDivisionError: no car at all",
    "GivesSizes": "frame 2: x_max < x_min in 1 of 1 rows (row 0: 500 190 60 40): ",
}
