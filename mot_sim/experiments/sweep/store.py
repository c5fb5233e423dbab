"""A sweep's folder: `sweep.json` says what it is, `trials/` holds a file a finished trial."""

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from shutil import rmtree
from typing import Any

from mot_sim.experiments.sweep.trial import TrialOutcome
from mot_sim.files.documents import read_json
from mot_sim.files.fingerprint import FORMAT, code_digest
from mot_sim.files.settings import holds_something, versions
from mot_sim.files.writing import write_lines
from tracker.errors import BadConfig, BadFile, OutputExists

SWEEP_FILE, TABLE_FILE = "sweep.json", "table.parquet"
PARTS = ("trials", "truth", "traffic")
MOST_NAMED = 4  # differences that an error lists


@dataclass(frozen=True)
class SweepFolder:
    """Trials by the hash of all that decides them; each file is whole, or it is not there."""

    path: Path

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
        if holds_something(path):
            if not (path / SWEEP_FILE).is_file():
                raise OutputExists(
                    f"{path}: not empty, and no sweep of ours; choose another folder"
                )
            if overwrite:
                folder.clear()
            else:
                folder._require_same(told, extend)
        about = {"format": FORMAT, "code": code_digest(), "versions": versions(), "design": told}
        write_lines(path / SWEEP_FILE, [json.dumps(about, indent=2)])
        return folder

    def clear(self) -> None:
        """Remove all that a sweep wrote."""
        for part in PARTS:
            rmtree(self.path / part, ignore_errors=True)
        for name in (TABLE_FILE, SWEEP_FILE):
            (self.path / name).unlink(missing_ok=True)

    def _require_same(self, description: Mapping[str, Any], extend: bool) -> None:
        """Raise BadFile for a folder of another format, BadConfig for another design or code."""
        file = self.path / SWEEP_FILE
        try:
            about = read_json(file, "no sweep of ours")
            form, code, design = about["format"], str(about["code"]), dict(about["design"])
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise BadFile(f"{file}: no sweep of ours: {error!r}; choose another folder") from None
        if form != FORMAT:
            raise BadFile(
                f"{file}: a sweep of format {form}, this mot-sim writes {FORMAT}: choose another "
                "folder, or --overwrite"
            )
        if extend:
            return
        cure = "give the same, --extend (keeps the trials that are the same), or another folder"
        differing = [
            f"{name} was {design.get(name)!r} and is {description.get(name)!r}"
            for name in sorted({*design, *description})
            if design.get(name) != description.get(name)
        ]
        if differing:
            more = f"; and {len(differing) - MOST_NAMED} more" * (len(differing) > MOST_NAMED)
            named = "; ".join(differing[:MOST_NAMED])
            raise BadConfig(f"{file}: another sweep: {named}{more}; {cure}")
        if code != code_digest():
            raise BadConfig(
                f"{file}: made by other code or libraries ({code[:8]}, this is "
                f"{code_digest()[:8]}): its trials are not ours; {cure}"
            )

    def trial(self, key: str) -> Path:
        """Where a trial lies, or will lie."""
        return self.path / "trials" / key[:2] / f"{key}.json"

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
        content = asdict(outcome)
        whole = {"format": FORMAT, "about": about, "sha256": _hash(content), "outcome": content}
        write_lines(self.trial(key), [json.dumps(whole)])

    def read(self, key: str) -> TrialOutcome | None:
        """A trial; None where there is none, or where a crash of the machine left half of one."""
        try:
            whole = read_json(self.trial(key))
            content = whole["outcome"]
            return TrialOutcome(**content) if whole["sha256"] == _hash(content) else None
        except (BadFile, ValueError, TypeError, KeyError):
            return None

    def sweep_up(self) -> None:
        """Remove what killed processes left half written; for when nobody works here any more."""
        for part in PARTS:
            for half in (self.path / part).rglob(".*.half"):
                with suppress(OSError):
                    half.unlink()


def _hash(content: Mapping[str, Any]) -> str:
    return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
