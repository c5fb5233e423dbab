"""Rich's consoles for the two streams; a file of their own, since help does without rich."""

import sys
from typing import Any

from rich.console import Console

PLAIN: dict[str, Any] = {"highlight": False, "emoji": False}  # `module:car:` is no picture
MAX_COLUMNS = 100_000  # wider than any table


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
    return PipeConsole(**PLAIN, width=None if is_terminal else MAX_COLUMNS)


def stderr_console() -> PipeConsole:
    """As wide as the terminal."""
    return PipeConsole(stderr=True, **PLAIN)
