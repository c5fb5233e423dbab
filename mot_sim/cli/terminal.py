"""What a command says: results on stdout, everything else on stderr."""

import json
import logging
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property, partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from mot_sim.cli.streams import writing_stderr, writing_stdout
from tracker.errors import MotionWarning

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.progress import Progress

OK, BROKEN, WRONG, INTERRUPTED = 0, 1, 2, 130
STDOUT = "-"
LEVELS = (logging.WARNING, logging.INFO, logging.DEBUG)
LOGGERS = ("mot_sim", "tracker")
REDRAW_SECONDS = 0.1  # between redraws of the bar; faster trackers must not wait for it
NOTE_SECONDS = 30.0  # between lines about the progress where no bar can be drawn


class Terminal:
    """The two streams of this process. Text is shown as it is: no markup, no highlighting."""

    @cached_property
    def out(self) -> "Console":
        """Where results go: stdout."""
        from mot_sim.cli.consoles import stdout_console

        return stdout_console()

    @cached_property
    def err(self) -> "Console":
        """Where everything else goes: stderr."""
        from mot_sim.cli.consoles import stderr_console

        return stderr_console()

    def show(self, what: "RenderableType") -> None:
        """A table on stdout, folded to the width of the terminal where there is one."""
        with writing_stdout():
            self.out.print(what, crop=False)

    def write(self, text: str) -> None:
        """Text on stdout, unchanged."""
        with writing_stdout():
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
        with writing_stderr():
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
        show = warnings.showwarning
        warnings.showwarning = partial(self._show_warning, show)
        for logger in loggers:
            logger.addHandler(handler)
            logger.setLevel(level)
        try:
            yield
        finally:
            warnings.showwarning = show
            for logger, old in zip(loggers, before, strict=True):
                logger.removeHandler(handler)
                logger.setLevel(old)

    def _show_warning(
        self, others: Callable[..., None], message: Warning | str, *details: Any, **more: Any
    ) -> None:
        """One line for motion that the boxes contradict; others as Python shows them."""
        if isinstance(message, MotionWarning):
            self.note(f"warning: {message}")
        else:
            others(message, *details, **more)

    @contextmanager
    def progress(
        self, total: int | None = None, *, unit: str = "", lines: bool = False
    ) -> "Iterator[ProgressBar]":
        """A bar on stderr, to be called as the work goes on; see `ProgressBar`.

        total: how much there is to do, where that is known. unit: what is counted; its rate is
        shown. lines: where no bar can be drawn, a line says now and then how far it is.
        """
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        bar = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[words]}", markup=False),
            console=self.err,
            transient=True,
            disable=not self.err.is_terminal,
        )
        with bar:
            yield ProgressBar(bar, self.note if lines and bar.disable else None, total, unit)


class ProgressBar:
    """What is under way, how much of it is done, and how long the rest takes."""

    def __init__(
        self, bar: "Progress", note: Callable[[str], None] | None, total: int | None, unit: str
    ) -> None:
        self.bar, self.note, self.total, self.unit = bar, note, total, unit
        self.task = bar.add_task("", total=total, words="")
        self.what, self.done = "", 0
        self.start, self.before = perf_counter(), 0  # when this work began, and with how much
        self.drawn, self.noted = 0.0, self.start

    def __call__(self, what: str, done: int | None = None, total: int | None = None) -> None:
        """Say what is under way. done: None: one more than before; total: None: as before."""
        now = perf_counter()
        if done is not None and (done < self.done or total != self.total):
            self.start, self.before = now, done  # other work begins
        is_due = done is not None or what != self.what or now - self.drawn > REDRAW_SECONDS
        self.what, self.done = what, self.done + 1 if done is None else done
        self.total = self.total if total is None else total
        if is_due:
            self.drawn = now
            words = ", ".join(self._words(now))
            self.bar.update(
                self.task, completed=self.done, total=self.total, description=what, words=words
            )
        if self.note is not None and now - self.noted > NOTE_SECONDS:
            self.noted = now
            far = what if self.total is None else f"{what}: {self.done:,} of {self.total:,}"
            self.note(", ".join([far, *self._words(now)]))

    def _words(self, now: float) -> list[str]:
        """The rate, and the time that is left."""
        seconds, count = now - self.start, self.done - self.before
        rate = [f"{count / max(seconds, 1e-9):,.0f} {self.unit}/s"] if self.unit else []
        if self.total is None or count <= 0:
            return rate
        return [*rate, f"{seconds / count * (self.total - self.done):,.0f} s left"]


class _LineHandler(logging.Handler):
    def __init__(self, terminal: Terminal) -> None:
        super().__init__()
        self.terminal = terminal

    def emit(self, record: logging.LogRecord) -> None:
        self.terminal.note(f"{record.levelname.lower()}: {record.getMessage()}")
