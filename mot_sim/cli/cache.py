"""`mot-sim cache`: what is kept between runs, and how to be rid of it."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from mot_sim.cli.options import Flag, Verbose, option
from mot_sim.cli.terminal import OK, Terminal

OLD = "old"
PARTS = ("episodes", "kernels", "guests")


@dataclass(frozen=True)
class Cache:
    """List what is kept between runs, remove it, or limit it.

    mot-sim cache --clear old

    episodes: recorded traffic and truth, which sweeps, suites, diagnoses and tests share; those
    used longest ago are removed beyond the limit. kernels: compiled code. guests: environments of
    other people's trackers. All of it is made again when it is needed.
    """

    clear: Annotated[str | None, option("NAMES")] = None
    """Remove episodes, kernels, guests, or all; old: episodes and kernels of other code than this
    one. Several with commas."""
    limit: Annotated[str | None, option("SIZE")] = None
    """From now on keep at most so much of episodes: 500MB, 2GB."""
    json: Flag = False
    """Print the list as JSON."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Do what is asked, then list what is left. BadConfig for names and sizes not known."""
        from mot_sim.files.kept import Kept, keep_within, shown_size, size_limit
        from mot_sim.tables import Column, Table

        folders, names = folders_of(), self._names()
        if self.limit is not None:
            set_limit(self.limit)
        removed = remove(names, folders)
        removed += keep_within(folders["episodes"], size_limit())
        if removed:
            terminal.note(f"removed {shown_size(removed)}")
        found = {part: Kept.of(folder) for part, folder in folders.items()}
        if self.json:
            listed = {
                part: {"folder": str(kept.folder), "files": kept.files, "bytes": kept.size}
                for part, kept in found.items()
            }
            terminal.write_json({"kept": listed, "limit": size_limit()})
            return OK
        limit = f"of at most {shown_size(size_limit())}"
        rows = tuple(
            (part, kept.files, shown_size(kept.size), limit if part == "episodes" else "",
             str(kept.folder))
            for part, kept in found.items()
        )  # fmt: skip
        columns = (Column("what"), Column("files"), Column("size"), Column("limit"))
        terminal.show(Table((*columns, Column("folder")), rows))
        return OK

    def _names(self) -> list[str]:
        """What is to be removed."""
        from tracker.errors import UnknownName

        names = [] if self.clear is None else [name.strip() for name in self.clear.split(",")]
        for name in names:
            if name not in (*PARTS, OLD, "all"):
                raise UnknownName.of("part of the cache", name, [*PARTS, OLD, "all"])
        return names


def folders_of() -> dict[str, Path]:
    """Where each part lies."""
    from mot_sim.experiments.sweep.drives import default_cache
    from mot_sim.foreign.environments import environments_folder
    from tracker.kernels import cache_folder

    return dict(zip(PARTS, (default_cache(), cache_folder(), environments_folder()), strict=True))


def remove(names: list[str], folders: dict[str, Path]) -> int:
    """Remove parts by name; the bytes that were removed. BadConfig where that is forbidden."""
    from mot_sim.files.kept import clear
    from tracker.errors import BadConfig

    chosen = list(folders.values()) if "all" in names else [folders[n] for n in names if n != OLD]
    if OLD in names:
        chosen += old_folders(folders)
    try:
        return clear(chosen)
    except OSError as error:
        raise BadConfig(
            f"{error.filename}: cannot be removed ({error.strerror}): remove it as its owner"
        ) from error


def old_folders(folders: dict[str, Path]) -> Iterator[Path]:
    """The folders of episodes and kernels that this code does not read."""
    from mot_sim.experiments.sweep.drives import Recordings
    from mot_sim.simulation.kernels import PACKAGE
    from tracker.kernels import folders_in_use, modules_of

    used = {Recordings.shared().folder, *folders_in_use([*modules_of(), *modules_of(PACKAGE)])}
    for part in ("episodes", "kernels"):
        if folders[part].is_dir():
            yield from (each for each in folders[part].iterdir() if each not in used)


def set_limit(words: str) -> None:
    """Keep the limit for later runs. BadConfig for what is no size, and where it cannot be kept."""
    from mot_sim.files.kept import limit_file, read_size
    from mot_sim.files.writing import write_lines
    from tracker.errors import BadConfig

    read_size(words, "--limit")
    try:
        limit_file().parent.mkdir(parents=True, exist_ok=True)
        write_lines(limit_file(), [words])
    except OSError as error:
        raise BadConfig(
            f"{limit_file()}: cannot be written ({error.strerror}): set MOT_SIM_CACHE_LIMIT"
        ) from error
