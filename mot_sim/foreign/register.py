"""The guests by name: a command, the environment it runs in, and which boxes it is shown."""

import json
import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.util import find_spec
from math import isfinite
from pathlib import Path

from mot_sim.foreign.environments import Environment
from tracker.errors import BadConfig, UnknownName

DETECTIONS, RESULTS = "{detections}", "{results}"
PYTHON = "{python}"
ADAPTER = str(Path(__file__).with_name("adapters") / "run.py")


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
        """Of its environment; ours, where that is missing and the package is installed here.

        ExternalTrackerFailed where the package is in neither.
        """
        if self.environment is None or (not self.environment.is_ready and self._is_here()):
            return sys.executable
        return str(self.environment.require(self.name))

    def _is_here(self) -> bool:
        """Whether the package of its environment is installed in ours."""
        return self.environment is not None and find_spec(self.environment.name) is not None

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


# By package: a guest runs in the environment of the package that has its tracker.
ENVIRONMENTS = {  # an environment's name is that of what is imported
    "trackers": Environment("trackers", ("trackers==2.6.1",)),
    # norfair asks for NumPy 1, which Python 3.13 has not; its rows are the same with NumPy 2.
    "norfair": Environment(
        "norfair", ("filterpy==1.4.5", "numpy", "scipy", "rich<15"), bare=("norfair==2.3.0",)
    ),
    "motpy": Environment("motpy", ("motpy==0.0.10", "filterpy==2.0.0")),
}


def _packaged(name: str, tracker: str, *settings: str) -> ExternalTracker:
    """A guest from the class PACKAGE:CLASS; settings: what is not as its authors have it."""
    environment = ENVIRONMENTS[tracker.partition(":")[0]]
    start = (PYTHON, "-I", ADAPTER, tracker)
    command = (*start, DETECTIONS, RESULTS, *settings)
    return ExternalTracker(name, command, environment, live=(*start, "live", *settings))


# norfair counts frames. motpy's noise (pixels, seconds) is that of its manual. Both would go on
# writing rows while nothing is detected: `pointwise_hit_counter_max` and `max_staleness` of 1
# keep them from it.
NORFAIR_SETTINGS = (
    "distance_threshold=0.8", "hit_counter_max=30", "initialization_delay=0",
    "pointwise_hit_counter_max=1",
)  # fmt: skip
MOTPY_NOISE = {"q_var_pos": 1000.0, "r_var_pos": 0.1}
MOTPY_MODEL = {"order_pos": 1, "dim_pos": 2, "order_size": 0, "dim_size": 2, **MOTPY_NOISE}
MOTPY_SETTINGS = (
    f"model_spec={json.dumps(MOTPY_MODEL)}", 'active_tracks_kwargs={"max_staleness": 1}'
)  # fmt: skip

# Memory, births and `min_score` were chosen by MOTA on KITTI's ten given sequences, RRC boxes
# (`python -m benchmarks.peers`): the best that each can do there, not its authors' defaults.
# `sort-3` and `oc-sort-3` confirm a track after three frames, as their authors have it.
# lost_track_buffer counts frames at 30 Hz: 90 are 3 seconds.
GUESTS: dict[str, ExternalTracker] = {
    guest.name: guest
    for guest in (
        _packaged("sort", "trackers:SORTTracker", "minimum_consecutive_frames=1"),
        _packaged("sort-3", "trackers:SORTTracker", "minimum_consecutive_frames=3"),
        _packaged("bytetrack", "trackers:ByteTrackTracker", "lost_track_buffer=90"),
        _packaged("oc-sort", "trackers:OCSORTTracker", "minimum_consecutive_frames=1"),
        _packaged("oc-sort-3", "trackers:OCSORTTracker", "minimum_consecutive_frames=3"),
        _packaged("c-biou", "trackers:CBIoUTracker"),
        _packaged("bot-sort", "trackers:BoTSORTTracker", "enable_cmc=false"),
        _packaged("norfair", "norfair:Tracker", *NORFAIR_SETTINGS),
        _packaged("motpy", "motpy:MultiObjectTracker", *MOTPY_SETTINGS),
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
