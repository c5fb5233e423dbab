"""Folders that an interrupted command goes on with, checked before more is added to them."""

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, ClassVar, TypeVar

from mot_sim.files.documents import read_json
from mot_sim.files.settings import Settings, holds_something, plain_settings, require_same, versions
from mot_sim.files.writing import write_lines
from tracker.errors import BadConfig, BadFile, BadOutput, OutputExists

Content = TypeVar("Content")
# Not `Self`: the type checks of the test run decorate methods one by one.
AnyFolder = TypeVar("AnyFolder", bound="ResumableFolder")
AnyTextFolder = TypeVar("AnyTextFolder", bound="TextPartsFolder")


def require_ours(file: Path, ours: str) -> bool:
    """Whether a folder holds the file that says what it is; False: it is empty, or not there.

    ours: what is not there, `no run of ours`. Raises OutputExists for a folder with other things
    in it, BadOutput for no folder.
    """
    if not holds_something(file.parent):
        return False
    if not file.is_file():
        raise OutputExists(f"{file.parent}: not empty, and {ours}; choose another folder")
    return True


def read_description(file: Path, ours: str, parse: Callable[[Any], Content]) -> Content:
    """What `parse` makes of the file that says what a folder is; BadFile for any other file."""
    try:
        return parse(read_json(file, ours))
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise BadFile(f"{file}: {ours}: {error!r}; choose another folder") from None


@dataclass(eq=False)
class ResumableFolder(ABC):
    """Results that appear part by part, each as a whole, and a JSON file: how they are made.

    Opening one only looks; entering it as a context writes the file, and leaving it by an
    exception before any part is finished takes back all that was made.
    """

    FILE: ClassVar[str]  # the JSON file
    PARTS: ClassVar[str]  # the entry of the JSON file that names the parts
    STRANGE: ClassVar[str]  # what is said of a folder without that file
    DAMAGED: ClassVar[str]  # what is said of a file that is none
    STANDS: ClassVar[str]  # what is said where neither --resume nor --overwrite was given

    path: Path
    """The folder."""
    settings: Settings
    """How the results are made, as the JSON file keeps it."""
    wanted: Sequence[str]
    """Names of all parts."""
    stale: tuple[str, ...] = ()
    """Parts that are to be replaced."""
    made: tuple[Path, ...] = ()
    """Folders that entering it made."""

    @classmethod
    def standing(
        cls, path: Path, settings: Settings, *, resume: bool, overwrite: bool
    ) -> Mapping[str, Any]:
        """The parts that the JSON file of a folder names; none of an empty folder.

        resume: go on with a run of the same settings. overwrite: replace an earlier run. Raises
        OutputExists for a folder that holds something, BadConfig for a run that was made with
        other settings, BadFile for a JSON file that is none, BadOutput for no folder.
        """
        if resume and overwrite:
            raise BadConfig("--resume goes on with a run, --overwrite replaces it: keep one")
        if not require_ours(path / cls.FILE, cls.STRANGE):
            return {}
        if not (resume or overwrite):
            raise OutputExists(f"{path}: {cls.STANDS}")
        before, parts = read_description(
            path / cls.FILE,
            cls.DAMAGED,
            lambda told: (
                plain_settings(told["settings"]),
                cls.parse(told[cls.PARTS], path / cls.FILE),
            ),
        )
        if resume:
            require_same(path, before, settings)
        return parts

    @classmethod
    @abstractmethod
    def parse(cls, told: Any, file: Path) -> Mapping[str, Any]:
        """The parts by name. Raises ValueError, TypeError, KeyError, BadFile for what is none."""

    @abstractmethod
    def remove(self, name: str) -> None:
        """Remove what there is of a part."""

    @abstractmethod
    def holds_any(self) -> bool:
        """Whether any part is finished."""

    @abstractmethod
    def describe(self) -> tuple[bool, Any]:
        """Whether the run is complete, and the entry PARTS."""

    def __enter__(self: AnyFolder) -> AnyFolder:
        self.made = tuple(place for place in (self.path, *self.path.parents) if not place.exists())
        try:
            for name in self.stale:
                self.remove(name)
            self.write()
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

    def write(self) -> None:
        """Write the JSON file."""
        complete, parts = self.describe()
        described = {
            "settings": dict(self.settings), "versions": versions(),
            "complete": complete, self.PARTS: parts,
        }  # fmt: skip
        write_lines(self.path / self.FILE, [json.dumps(described, indent=2)])

    def _take_back(self) -> None:
        """Remove what was made, unless a part is finished."""
        if self.holds_any():
            return
        with suppress(OSError):
            (self.path / self.FILE).unlink(missing_ok=True)
            for place in self.made:
                place.rmdir()


@dataclass(eq=False)
class TextPartsFolder(ResumableFolder):
    """A resumable folder whose parts are a file `NAME.txt` each."""

    finished: dict[str, Any] = field(default_factory=dict)
    """What is known of each part whose file is in the folder, by name."""

    @classmethod
    def open(
        cls: type[AnyTextFolder],
        path: Path,
        settings: Settings,
        wanted: Sequence[str],
        *,
        resume: bool = False,
        overwrite: bool = False,
    ) -> AnyTextFolder:
        """The folder, checked; nothing is written yet. See `ResumableFolder.standing`."""
        there = cls.standing(path, settings, resume=resume, overwrite=overwrite)
        if overwrite:
            return cls(path, settings, wanted, stale=tuple(there))
        kept = {name: part for name, part in there.items() if (path / f"{name}.txt").is_file()}
        return cls(path, settings, wanted, finished=kept)

    def result(self, name: str) -> Path:
        """Where the file of a part lies."""
        return self.path / f"{name}.txt"

    def remove(self, name: str) -> None:
        """Remove the file of a part."""
        self.result(name).unlink(missing_ok=True)

    def holds_any(self) -> bool:
        """Whether any part is finished."""
        return any(self.result(name).exists() for name in {*self.finished, *self.wanted})
