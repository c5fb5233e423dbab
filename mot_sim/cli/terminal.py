"""What a command says: results on stdout, everything else on stderr."""

import json
import logging
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

from rich.console import Console, RenderableType
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

OK, BROKEN, WRONG, INTERRUPTED = 0, 1, 2, 130
STDOUT = "-"
LEVELS = (logging.WARNING, logging.INFO, logging.DEBUG)
LOGGERS = ("mot_sim", "tracker")
MAX_COLUMNS = 100_000  # wider than any table
REDRAW_SECONDS = 0.1  # between redraws of the bar; faster trackers must not wait for it


class PipeConsole(Console):
    """A console that leaves a broken pipe to its caller (rich would end the process)."""

    def on_broken_pipe(self) -> None:
        """Let the BrokenPipeError through."""
        raise  # noqa: PLE0704


def stdout_console() -> PipeConsole:
    """As wide as the terminal; without a width where stdout is none, so that nothing is folded."""
    try:
        is_terminal = sys.stdout.isatty()
    except ValueError:  # closed
        is_terminal = False
    return PipeConsole(highlight=False, width=None if is_terminal else MAX_COLUMNS)


@dataclass(frozen=True, eq=False)
class Terminal:
    """The two streams of this process. Text is shown as it is: no markup, no highlighting."""

    out: Console = field(default_factory=stdout_console)
    err: Console = field(default_factory=lambda: PipeConsole(stderr=True, highlight=False))

    def show(self, what: RenderableType) -> None:
        """A table on stdout, folded to the width of the terminal where there is one."""
        self.out.print(what, crop=False)

    def write(self, text: str) -> None:
        """Text on stdout, unchanged."""
        sys.stdout.write(text)

    def write_json(self, content: Mapping[str, object] | list) -> None:
        """JSON on stdout."""
        self.write(json.dumps(content, indent=2) + "\n")

    def save(self, text: str, target: str) -> None:
        """Text into a file, as a whole or not at all; `-` is stdout."""
        from mot_sim.files.writing import write_lines

        if target == STDOUT:
            self.write(text)
        else:
            write_lines(Path(target), text.splitlines())

    def note(self, text: str) -> None:
        """One line on stderr."""
        line = " ".join(text.split("\n"))
        self.err.print(line, markup=False, soft_wrap=True)

    def error(self, text: str) -> None:
        """What is wrong, in one line on stderr."""
        self.note(f"error: {text}")

    @contextmanager
    def logging(self, verbose: int) -> Iterator[None]:
        """While it lasts, warnings (1: and news, 2: and details) are single lines on stderr."""
        handler = _LineHandler(self)
        level = LEVELS[min(max(verbose, 0), len(LEVELS) - 1)]
        loggers = [logging.getLogger(name) for name in LOGGERS]
        before = [logger.level for logger in loggers]
        for logger in loggers:
            logger.addHandler(handler)
            logger.setLevel(level)
        try:
            yield
        finally:
            for logger, old in zip(loggers, before, strict=True):
                logger.removeHandler(handler)
                logger.setLevel(old)

    @contextmanager
    def progress(self, total: int | None) -> Iterator[Callable[..., None]]:
        """A bar of frames on stderr; gives advance(what is under way), to be called once a frame.

        total: None until somebody knows: advance(what, total).
        """
        bar = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[speed]}", markup=False),
            TimeRemainingColumn(),
            console=self.err,
            transient=True,
            disable=not self.err.is_terminal,
        )
        start, done, drawn = perf_counter(), 0, 0.0
        with bar:
            task = bar.add_task("", total=total, speed="")

            def advance(what: str, total: int | None = total) -> None:
                nonlocal done, drawn
                done += 1
                now = perf_counter()
                if now - drawn > REDRAW_SECONDS:
                    drawn = now
                    speed = f"{done / max(now - start, 1e-9):,.0f} frames/s"
                    bar.update(task, completed=done, total=total, description=what, speed=speed)

            yield advance


class _LineHandler(logging.Handler):
    def __init__(self, terminal: Terminal) -> None:
        super().__init__()
        self.terminal = terminal

    def emit(self, record: logging.LogRecord) -> None:
        self.terminal.note(f"{record.levelname.lower()}: {record.getMessage()}")
