"""The guests by name: a command, the environment it runs in, and which boxes it is shown."""

import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path

from mot_sim.experiments.guests.environments import Environment
from tracker.errors import BadConfig, UnknownName

DETECTIONS, RESULTS = "{detections}", "{results}"
PYTHON = "{python}"
ADAPTER = str(Path(__file__).with_name("adapter.py"))


@dataclass(frozen=True)
class ExternalTracker:
    """Another author's tracker: a program that reads a folder and writes one; see docs/guests.md.

    Raises BadConfig for values that are not allowed.
    """

    name: str
    """Its name in tables and on the command line."""
    command: tuple[str, ...]
    """The words of its command: {detections} and {results} become folders, both are required;
    {python} becomes the interpreter of its environment."""
    environment: Environment | None = None
    """The environment whose Python runs it; None: the Python that runs us."""
    min_score: float = 0.3
    """Detector score, 0..1, below which boxes are not shown to it; raising it hides more boxes."""
    timeout: float = 600.0
    """Seconds that it may take for all sequences together, finite and above 0."""
    live: tuple[str, ...] | None = None
    """The command that runs it frame by frame, see `ExternalOnlineTracker`; None: it only reads
    folders."""

    def __post_init__(self) -> None:
        for place in (DETECTIONS, RESULTS):
            if not any(place in word for word in self.command):
                raise BadConfig(
                    f"guest {self.name}: its command {shlex.join(self.command)!r} has no {place}; "
                    f"write, for example, python mine.py {DETECTIONS} {RESULTS}"
                )
        if not 0.0 <= self.min_score <= 1.0:
            raise BadConfig(
                f"guest {self.name}: score {self.min_score:g}; give a probability, 0 to 1"
            )
        if not (isfinite(self.timeout) and self.timeout > 0.0):
            raise BadConfig(f"guest {self.name}: timeout {self.timeout:g} s; give one above 0")

    @classmethod
    def parse(cls, text: str) -> "ExternalTracker":
        """From `NAME=COMMAND`, the command as one would type it."""
        name, _, command = text.partition("=")
        name = name.strip()
        try:
            words = tuple(shlex.split(command))
        except ValueError as error:
            raise BadConfig(f"guest {text!r}: {error}") from None
        if not words or not name or not name.replace("-", "").replace("_", "").isalnum():
            raise BadConfig(
                f"guest {text!r}: write NAME=COMMAND, the name in letters, digits, - and _"
            )
        return cls(name, words)

    def interpreter(self) -> str:
        """Of its environment; ExternalTrackerFailed when that is missing."""
        if self.environment is None:
            return sys.executable
        return str(self.environment.require(self.name))

    def words(self, detections: Path, results: Path) -> list[str]:
        """The command with its places filled in.

        Raises ExternalTrackerFailed when its environment is missing.
        """
        python = self.interpreter()
        filled = []
        for word in self.command:
            for place, value in (
                (DETECTIONS, str(detections)), (RESULTS, str(results)), (PYTHON, python)
            ):  # fmt: skip
                word = word.replace(place, value)  # noqa: PLW2901
            filled.append(word)
        return filled


TRACKERS_PACKAGE = Environment("trackers", ("trackers==2.6.1",))


def _of_the_package(name: str, *settings: str) -> ExternalTracker:
    """A tracker of the package `trackers`; settings: what is not as its authors have it."""
    command = (PYTHON, "-I", ADAPTER, name, DETECTIONS, RESULTS, *settings)
    live = (PYTHON, "-I", ADAPTER, name, "live", *settings)
    return ExternalTracker(name, command, TRACKERS_PACKAGE, live=live)


# Memory, births and `min_score` were chosen by MOTA on KITTI's ten given sequences, RRC boxes
# (`python -m benchmarks.peers`): the best that each can do there, not its authors' defaults.
# lost_track_buffer counts frames at 30 Hz: 90 are 3 seconds.
GUESTS: dict[str, ExternalTracker] = {
    guest.name: guest
    for guest in (
        _of_the_package("sort", "minimum_consecutive_frames=1"),
        _of_the_package("bytetrack", "lost_track_buffer=90"),
        _of_the_package("oc-sort", "minimum_consecutive_frames=1"),
        _of_the_package("c-biou"),
    )
}


def parse_scores(text: str) -> dict[str, float]:
    """The least scores that guests are shown, from `0.3` (for all: name "") or `sort=0.3,...`."""
    scores: dict[str, float] = {}
    for part in text.split(","):
        name, equals, number = (word.strip() for word in part.rpartition("="))
        try:
            score = float(number)
        except ValueError:
            score = float("nan")
        if name in scores or not isfinite(score) or (equals and not name):
            raise BadConfig(f"guest scores {text!r}: write 0.3, or sort=0.3,bytetrack=0.5")
        scores[name] = score
    return scores


def with_scores(
    guests: Mapping[str, ExternalTracker], scores: Mapping[str, float]
) -> dict[str, ExternalTracker]:
    """The guests with other least scores; UnknownName for one that is not among them."""
    for name in scores:
        if name and name not in guests:
            raise UnknownName.of("guest", name, guests)
    return {
        name: replace(guest, min_score=scores.get(name, scores.get("", guest.min_score)))
        for name, guest in guests.items()
    }
