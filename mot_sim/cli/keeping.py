"""What commands leave in their --out folder for `mot-sim report`."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import mot_sim.experiments.sweep
    import mot_sim.tables


def keep(
    folder: Path | None,
    kind: str,
    title: str,
    tables: "tuple[mot_sim.tables.Table, ...]" = (),
    *,
    finished: bool = True,
    trials: tuple[int, int] | None = None,
    form_only: bool = False,
    files: tuple[str, ...] = (),
) -> None:
    """Write `result.json` into the folder, if there is one; see `Result` and `Made`."""
    from mot_sim.experiments.result_file import Result, made_here, write_result

    if folder is not None:
        made = made_here(finished=finished, trials=trials, form_only=form_only)
        write_result(folder, Result(kind, title, made, tables, files))


def keep_sweep(
    folder: Path | None,
    design: "mot_sim.experiments.sweep.Design",
    tables: "tuple[mot_sim.tables.Table, ...]" = (),
    done: int = 0,
) -> None:
    """The same for a sweep. done: trials that are finished."""
    title = f"{design.scene}: {', '.join(design.axes)}"
    trials = done, len(design)
    keep(folder, "sweep", title, tables, finished=done == len(design), trials=trials)


def begun(
    folder: Path,
    design: "mot_sim.experiments.sweep.Design",
    advance: Callable[[str, int, int], None],
) -> Callable[[str, int, int], None]:
    """The progress of a sweep; before it first advances, the folder says what is under way."""
    told = False

    def tell(what: str, done: int, total: int) -> None:
        nonlocal told
        if not told:
            keep_sweep(folder, design)
            told = True
        advance(what, done, total)

    return tell
