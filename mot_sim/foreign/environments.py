"""Environments of the guests' own: a venv for a list of requirements, made once and kept."""

import hashlib
import json
import os
import shutil
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from mot_sim.files.writing import write_lines
from mot_sim.foreign.failure import ExternalTrackerFailed
from mot_sim.foreign.processes import run_process
from tracker.errors import BadOutput
from tracker.user_cache import user_cache

PLACE = "MOT_SIM_GUESTS"  # the environment variable that names where they are kept
READY = "ready.json"
SETUP_SECONDS = 1800.0


def environments_folder() -> Path:
    """Where the environments are kept: $MOT_SIM_GUESTS, else mot-sim/guests of the user's cache."""
    named = os.environ.get(PLACE)
    if named:
        return Path(named).expanduser().resolve()
    return user_cache("guests")


@dataclass(frozen=True)
class Environment:
    """A Python environment of a guest's own, which holds what it needs and nothing of ours."""

    name: str
    """Beginning of the folder's name; a hash of the requirements and of our Python's version
    follows."""
    requirements: tuple[str, ...]
    """Packages as pip takes them; exact versions keep later comparisons the same."""
    bare: tuple[str, ...] = ()
    """Packages whose own demands are not heeded, as no newer Python could meet them: what they
    import stands in `requirements`."""

    @property
    def path(self) -> Path:
        """Where it lies, or will."""
        described = json.dumps([sys.version_info[:2], *self.requirements, *self.bare])
        digest = hashlib.sha256(described.encode()).hexdigest()[:12]
        return environments_folder() / f"{self.name}-{digest}"

    @property
    def is_ready(self) -> bool:
        """Whether it was set up to the end, and the Python that it was made from is still there."""
        return (self.path / READY).is_file() and self.python.exists()

    @property
    def python(self) -> Path:
        """Its interpreter."""
        return self.path / "bin" / "python"

    def require(self, guest: str) -> Path:
        """Its interpreter; ExternalTrackerFailed, with the cure, when it was not set up."""
        if not self.is_ready:
            cure = f"`mot-sim compare --setup {guest}` makes it, once"
            raise ExternalTrackerFailed(guest, f"no environment in {self.path}; {cure}")
        return self.python

    def set_up(self, guest: str) -> Path:
        """Make it, unless it is there; gives its interpreter.

        Needs a package index that has the requirements (pip's own settings name it). What was
        left half done is made anew. Raises ExternalTrackerFailed with pip's stderr when that fails.
        """
        if self.is_ready:
            return self.python
        self._clear()
        place = str(self.path)
        if find_spec("pip") is None:  # uv's environments have none; Python brings one
            self._run(guest, [sys.executable, "-m", "venv", place])
            pip = [str(self.python), "-m", "pip"]
        else:
            self._run(guest, [sys.executable, "-m", "venv", "--without-pip", place])
            pip = [sys.executable, "-m", "pip", "--python", str(self.python)]
        options = ("--disable-pip-version-check", "--quiet", "install")
        try:
            self._run(guest, [*pip, *options, *self.requirements])
            if self.bare:
                self._run(guest, [*pip, *options, "--no-deps", *self.bare])
        except ExternalTrackerFailed as failed:
            self._clear()
            raise ExternalTrackerFailed(
                guest,
                f"{', '.join((*self.bare, *self.requirements))} cannot be installed; that "
                "needs a package index once: go online, or name a mirror or a folder of wheels "
                "(PIP_INDEX_URL, PIP_FIND_LINKS)",
                failed.stderr,
            ) from None
        write_lines(
            self.path / READY, [json.dumps({"requirements": self.requirements, "bare": self.bare})]
        )
        return self.python

    def _run(self, guest: str, command: list[str]) -> None:
        run_process(guest, command, SETUP_SECONDS)

    def _clear(self) -> None:
        """Remove what is left of an earlier attempt, and make sure that there is a place."""
        try:
            if self.path.exists():
                shutil.rmtree(self.path)
            self.path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BadOutput(
                f"{self.path}: no place for an environment: {error.strerror}; name another: {PLACE}"
            ) from None
