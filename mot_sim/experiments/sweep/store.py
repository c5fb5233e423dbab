"""A sweep's folder: `sweep.json` says what it is, `trials/` holds a file a finished trial."""

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from shutil import rmtree
from typing import Any

from mot_sim.files.cache_folder import CacheFolder
from mot_sim.files.fingerprint import SWEEP_FORMAT, code_digest
from mot_sim.files.resumable_folder import read_description, require_ours
from mot_sim.files.settings import differing_settings, versions
from mot_sim.files.writing import write_lines
from tracker.errors import BadConfig, BadFile

SWEEP_FILE, TABLE_FILE = "sweep.json", "table.parquet"
SWEEP_PARTS = ("trials", "truth", "traffic")
NO_SWEEP = "no sweep of ours"  # what is said of a folder or file that is none
MAX_NAMED_DIFFERENCES = 4  # that an error lists


@dataclass(frozen=True, eq=False)
class TrialOutcome:
    """The result of one trial."""

    scores: dict[str, int | float] = field(default_factory=dict)
    """Scores by TrackEval's names; empty where there is an error."""
    error: str | None = None
    """What went wrong, and at which frame; None: nothing."""
    frames: int = 0
    """Number of frames that the tracker was given."""
    detections: int = 0
    """Number of detections in those frames."""
    cpu_seconds: float = 0.0
    """CPU time of building and running the tracker, s, of drives that were followed together an
    equal share a frame; it differs between runs."""
    output: str = ""
    """The end of what the tracker printed in a process of its own; may differ between runs, too."""


@dataclass(frozen=True)
class SweepFolder:
    """The finished trials of a sweep by the hash of what decides them; every file is whole."""

    path: Path
    """The sweep's folder."""

    @classmethod
    def open(
        cls,
        path: Path,
        description: Mapping[str, Any],
        *,
        extend: bool = False,
        overwrite: bool = False,
    ) -> "SweepFolder":
        """The folder of this design, which goes on where it was left.

        extend: another design, or other code, may take the folder over; trials of the same
        content are kept. overwrite: an earlier sweep is removed. Raises OutputExists for a folder
        with other things in it, BadConfig for another sweep, BadFile for another format.
        """
        folder = cls(path)
        if extend and overwrite:
            raise BadConfig("--extend keeps what is there, --overwrite removes it: keep one")
        told = json.loads(json.dumps(description))
        if require_ours(path / SWEEP_FILE, NO_SWEEP):
            if overwrite:
                folder.clear()
            else:
                folder.require_same(told, extend)
        about = {
            "format": SWEEP_FORMAT,
            "code": code_digest(),
            "versions": versions(),
            "design": told,
        }
        write_lines(path / SWEEP_FILE, [json.dumps(about, indent=2)])
        return folder

    def clear(self) -> None:
        """Remove all that a sweep wrote."""
        for part in SWEEP_PARTS:
            rmtree(self.path / part, ignore_errors=True)
        for name in (TABLE_FILE, SWEEP_FILE):
            (self.path / name).unlink(missing_ok=True)

    def require_same(self, description: Mapping[str, Any], extend: bool) -> None:
        """Raise BadFile for a folder of another format, BadConfig for another design or code."""
        file = self.path / SWEEP_FILE
        form, code, design = read_description(
            file, NO_SWEEP, lambda told: (told["format"], str(told["code"]), dict(told["design"]))
        )
        if form != SWEEP_FORMAT:
            raise BadFile(
                f"{file}: a sweep of format {form}, this mot-sim writes {SWEEP_FORMAT}: choose "
                "another folder, or --overwrite"
            )
        if extend:
            return
        cure = "give the same, --extend (keeps the trials that are the same), or another folder"
        if found := differing_settings(design, description):
            more = len(found) - MAX_NAMED_DIFFERENCES
            named = "; ".join(found[:MAX_NAMED_DIFFERENCES]) + f"; and {more} more" * (more > 0)
            raise BadConfig(f"{file}: another sweep: {named}; {cure}")
        if code != code_digest():
            raise BadConfig(
                f"{file}: made by other code or libraries ({code[:8]}, this is "
                f"{code_digest()[:8]}): its trials are not ours; {cure}"
            )

    @property
    def trials(self) -> CacheFolder:
        """The finished trials, by key."""
        return CacheFolder(self.path / "trials", "outcome")

    def finished(self, keys: Iterable[str], *, failed_too: bool = True) -> dict[str, TrialOutcome]:
        """The trials among these that stand here; failed_too: those with an error as well."""
        found = {key: self.read(key) for key in dict.fromkeys(keys)}
        return {
            key: outcome
            for key, outcome in found.items()
            if outcome is not None and (failed_too or outcome.error is None)
        }

    def write(self, key: str, outcome: TrialOutcome, about: Mapping[str, Any]) -> None:
        """Keep a trial; about: what a person wants to know who opens the file."""
        self.trials.write(key, asdict(outcome), format=SWEEP_FORMAT, about=dict(about))

    def read(self, key: str) -> TrialOutcome | None:
        """A trial; None where there is none, or where a crash of the machine left half of one."""
        return self.trials.read(key, lambda content: TrialOutcome(**content))

    def sweep_up(self) -> None:
        """Remove what killed processes left half written; for when nobody works here any more."""
        for part in SWEEP_PARTS:
            for half in (self.path / part).rglob(".*.half"):
                with suppress(OSError):
                    half.unlink()
