"""The command line: one file a command; `COMMANDS` is the register.

A command's file, and what parses its options, are imported when the command is asked for; what is
heavy is imported only when it runs. So `--help` answers at once.
"""

import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Protocol, runtime_checkable

from mot_sim.cli.streams import prepare_streams, writing_stdout
from mot_sim.cli.terminal import INTERRUPTED, OK, WRONG, Terminal

DESCRIPTION = (
    "usage: mot-sim COMMAND [OPTIONS]",
    "Camera-only multi-object tracking with geometry, and the testbed for it.",
    "Units: metres, seconds, pixels, degrees. Exit codes: 0 done, 1 (doctor, verify, compare, "
    "sweep, stress, breaking-point) something is wrong, 2 wrong input, 130 interrupted. Help on a "
    "command: mot-sim COMMAND --help. Version: --version.",
)
HELP = ("--help", "-h")


@runtime_checkable
class Command(Protocol):
    """A parsed command: its fields are the options."""

    @property
    def verbose(self) -> int:
        """0: warnings, 1: a line a sequence, 2: details."""
        ...

    def __call__(self, terminal: Terminal) -> int:
        """Do it and give the exit code."""
        ...


class CommandRegister(Mapping[str, Callable[..., Command]]):
    """The commands by name; the file of one is imported when it is looked up."""

    def __init__(self, places: Mapping[str, str]) -> None:
        self.places = places  # file and class

    def __getitem__(self, name: str) -> Callable[..., Command]:
        file, _, kind = self.places[name].partition(":")
        command: Callable[..., Command] = getattr(import_module(f"mot_sim.cli.{file}"), kind)
        return command

    def summary(self, name: str) -> str:
        """The first line of what a command says about itself, read without importing its file."""
        file, _, kind = self.places[name].partition(":")
        source = Path(__file__).with_name(f"{file}.py").read_text(encoding="utf-8")
        found = re.search(rf'^class {kind}:\n    """(.+)$', source, re.MULTILINE)
        return found[1] if found else ""

    def __iter__(self) -> Iterator[str]:
        return iter(self.places)

    def __len__(self) -> int:
        return len(self.places)

    def __contains__(self, name: object) -> bool:
        return name in self.places


COMMANDS = CommandRegister(
    {
        "track": "track:Track",
        "evaluate": "evaluate:Evaluate",
        "kitti": "kitti:Kitti",
        "compare": "compare:Compare",
        "demo": "demo:Demo",
        "show": "show:Show",
        "teaser": "teaser:Teaser",
        "doctor": "doctor:Doctor",
        "cache": "cache:Cache",
        "scenes": "scenes:Scenes",
        "record": "record:Record",
        "verify": "verify:Verify",
        "detect": "detect:Detect",
        "calibrate": "calibrate:Calibrate",
        "calibrate-camera": "calibrate_camera:CalibrateCamera",
        "calibrate-look": "calibrate_look:CalibrateLook",
        "validate-sim": "validate_sim:ValidateSim",
        "sweep": "sweep:Sweep",
        "stress": "stress:Stress",
        "breaking-point": "breaking_point:BreakingPointCommand",
        "diagnose": "diagnose:Diagnose",
        "tune": "tune:Tune",
        "tables": "tables:Tables",
        "report": "report:Report",
        "export": "export:Export",
        "export-car": "export:ExportCar",
        "train-keypoints": "train:TrainKeypoints",
        "list": "listing:List",
        "train-appearance": "train:TrainAppearance",
    }
)


def run(arguments: Sequence[str]) -> int:
    """Run one command line and give the exit code; what is wrong becomes one line on stderr."""
    prepare_streams()
    terminal = Terminal()
    try:
        return _run(arguments, terminal)
    except KeyboardInterrupt:
        terminal.error("interrupted")
        return INTERRUPTED


def _run(arguments: Sequence[str], terminal: Terminal) -> int:
    """Parse and run; the exit code."""
    command, code = None, OK
    try:
        with writing_stdout():
            first = arguments[0] if arguments else ""
            if first == "--version":
                from importlib.metadata import version

                sys.stdout.write(f"mot-sim {version('mot-sim')}\n")
                return OK
            if first in HELP:
                sys.stdout.write(overview())
                return OK
            try:
                command = parse(arguments)
            except SystemExit as leaving:  # tyro has shown the help, or what is wrong
                code = leaving.code if isinstance(leaving.code, int) else OK
    except Exception as error:
        from tracker.errors import BadOutput, UnknownName  # loads what --help must not wait for

        if not isinstance(error, BadOutput | UnknownName):
            raise
        terminal.error(str(error))
        return WRONG
    if command is None:
        return code
    with terminal.logging(command.verbose):
        return run_parsed(command, terminal)


def overview() -> str:
    """What `mot-sim --help` says: every command with its line, folded to the terminal's width."""
    from shutil import get_terminal_size
    from textwrap import fill

    width, column = max(get_terminal_size().columns, 40), max(map(len, COMMANDS)) + 4
    parts = [fill(part, width) + "\n" for part in DESCRIPTION]
    lines = [
        fill(
            COMMANDS.summary(name), width,
            initial_indent=f"  {name}".ljust(column), subsequent_indent=" " * column,
        )
        for name in COMMANDS
    ]  # fmt: skip
    return "\n".join([*parts, "commands:", *lines, ""])


def parse(arguments: Sequence[str]) -> Command:
    """The command that the arguments spell; SystemExit for its --help and for wrong options.

    Raises UnknownName for what is no command.
    """
    name, *options = arguments or [""]
    if name not in COMMANDS:
        from tracker.errors import UnknownName

        if not name:
            raise UnknownName("no command is given; mot-sim --help lists them")
        if name.startswith("-"):
            raise UnknownName(f"{name} is no command; options follow it: mot-sim COMMAND {name}")
        raise UnknownName.of("command", name, COMMANDS)
    import tyro

    config = (
        tyro.conf.FlagCreatePairsOff,
        tyro.conf.OmitArgPrefixes,
        tyro.conf.HelptextFromCommentsOff,
    )
    command: Command = tyro.cli(COMMANDS[name], prog=f"mot-sim {name}", args=options, config=config)
    return command


def run_parsed(command: Command, terminal: Terminal) -> int:
    """Run a command; a TrackingError, or a file that the system refuses, is one line.

    So is what the user's own code raises, a scene, a cost or a tracker of the working folder.
    """
    from mot_sim.files.named_objects import importable, place_of
    from tracker.errors import TrackingError

    try:
        with importable(os.getcwd()):  # the console script does not look there
            return command(terminal)
    except TrackingError as error:
        terminal.error(str(error))
    except OSError as error:
        terminal.error(f"{error.filename or 'input or output'}: {error.strerror or error}")
    except Exception as error:
        place = place_of(error, own=True)
        if place is None:
            raise  # a fault of ours
        terminal.error(f"{place}: {type(error).__name__}: {error}")
    return WRONG


__all__ = ["COMMANDS", "Command", "overview", "parse", "run"]
