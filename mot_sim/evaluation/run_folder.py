"""A folder of results: `SSSS.txt` a finished sequence, and `run.json`, how they were made."""

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from types import TracebackType
from typing import Any

from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.kitti.labels import write_results
from mot_sim.files.documents import read_json
from mot_sim.files.settings import (
    Settings,
    holds_something,
    plain_settings,
    require_same,
    versions,
)
from mot_sim.files.writing import write_lines
from tracker.errors import BadConfig, BadFile, BadOutput, OutputExists
from tracker.types import Tracks

RUN_FILE = "run.json"
LONGEST_NAME = 100  # letters of a sequence; file systems take 255 bytes


@dataclass(frozen=True)
class SequenceStatistics:
    """What went through a tracker in one sequence; seconds of wall time, reading included.

    pairs: of an expected track and a detection; compared: those whose costs were computed, the
    search areas spared the others. unmeasured: costs that were NaN, their cue missing. stages:
    seconds of those spent on cues in images, by `tracker.front_end.STAGES`.
    """

    frames: int
    detections: int
    rows: int
    ids: int
    seconds: float
    pairs: int = 0
    compared: int = 0
    unmeasured: int = 0
    stages: Mapping[str, float] = field(default_factory=dict)


@dataclass(eq=False)
class RunFolder:
    """Results that appear sequence by sequence, each file as a whole.

    Opening one only looks; entering it as a context writes `run.json`, and leaving it by an
    exception before any sequence is finished takes back all that was made.
    wanted: the names of all sequences of the run. finished: what stands in the folder.
    """

    path: Path
    settings: Settings
    wanted: Sequence[str]
    finished: dict[str, SequenceStatistics] = field(default_factory=dict)
    stale: tuple[str, ...] = ()
    made: tuple[Path, ...] = ()

    @classmethod
    def open(
        cls,
        path: Path,
        settings: Settings,
        wanted: Sequence[str],
        *,
        resume: bool = False,
        overwrite: bool = False,
    ) -> "RunFolder":
        """The folder, checked; nothing is written yet.

        resume: go on with a run of the same settings. overwrite: replace an earlier run.
        Raises OutputExists for a folder that holds something, BadConfig for a run that was made
        with other settings, BadFile for a `run.json` that is none, BadOutput for no folder.
        """
        if resume and overwrite:
            raise BadConfig("--resume goes on with a run, --overwrite replaces it: keep one")
        if not holds_something(path):
            return cls(path, settings, wanted)
        if not (path / RUN_FILE).is_file():
            raise OutputExists(f"{path}: not empty, and no run of ours; choose another folder")
        if not (resume or overwrite):
            raise OutputExists(
                f"{path}: holds a run already; --resume does its rest, --overwrite replaces it"
            )
        before, finished = _read_run(path / RUN_FILE)
        if overwrite:
            return cls(path, settings, wanted, stale=tuple(finished))
        require_same(path, before, settings)
        there = {name: part for name, part in finished.items() if (path / f"{name}.txt").is_file()}
        return cls(path, settings, wanted, there)

    def __enter__(self) -> "RunFolder":
        self.made = tuple(place for place in (self.path, *self.path.parents) if not place.exists())
        try:
            for name in self.stale:
                self.result(name).unlink(missing_ok=True)
            self._write_run({})
        except OSError as error:
            raise BadOutput(f"{self.path}: cannot be written: {error.strerror}") from None
        except BaseException:
            self._take_back()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        if kind is not None:
            self._take_back()

    def add(
        self,
        name: str,
        tracks: Tracks,
        counts: SequenceStatistics,
        T_road_label: Float[Array, "4 4"] | None = None,
    ) -> None:
        """Keep a finished sequence: both files appear as a whole, the results last."""
        self._write_run({name: counts})
        write_results(tracks, self.result(name), T_road_label)
        self.finished[name] = counts

    def result(self, name: str) -> Path:
        """Where the results of a sequence lie."""
        return self.path / f"{name}.txt"

    def _take_back(self) -> None:
        """Remove what was made, unless a sequence is finished."""
        if any(self.result(name).exists() for name in {*self.finished, *self.wanted}):
            return
        with suppress(OSError):
            (self.path / RUN_FILE).unlink(missing_ok=True)
            for place in self.made:
                place.rmdir()

    def _write_run(self, more: Mapping[str, SequenceStatistics]) -> None:
        sequences = {name: asdict(counts) for name, counts in {**self.finished, **more}.items()}
        described = {
            "settings": dict(self.settings),
            "versions": versions(),
            "complete": set(self.wanted) <= sequences.keys(),
            "sequences": dict(sorted(sequences.items())),
        }
        write_lines(self.path / RUN_FILE, [json.dumps(described, indent=2)])


def _read_run(path: Path) -> tuple[Settings, dict[str, SequenceStatistics]]:
    """The settings and the finished sequences that a `run.json` names."""
    try:
        described = read_json(path, "not a run of ours")
        parts = {name: _counts(part) for name, part in described["sequences"].items()}
        settings = plain_settings(described["settings"])
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise BadFile(f"{path}: not a run of ours: {error!r}; choose another folder") from None
    for name in parts:
        if Path(name).name != name or not name.isprintable() or len(name) > LONGEST_NAME:
            told = f"a sequence is named like a path: {name!r:.80}"
            raise BadFile(f"{path}: {told}; choose another folder")
    return settings, parts


def _counts(told: Any) -> SequenceStatistics:
    """The counts that a JSON file tells. Raises ValueError and TypeError for what are none."""
    numbers = {**told, **told.get("stages", {})}
    numbers.pop("stages", None)
    for name, value in numbers.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 2**53:
            raise ValueError(f"{name} is {value!r:.80}")
    wholes = [each.name for each in fields(SequenceStatistics) if each.type is int]
    return SequenceStatistics(
        **{**told, **{name: int(told[name]) for name in wholes if name in told}}
    )
