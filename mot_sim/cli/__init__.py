"""The command line: one file a command; `COMMANDS` is the register.

A command's file is imported when it is asked for, and imports what is heavy only when it runs, so
that `--help` answers at once.
"""

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from importlib import import_module
from operator import or_
from typing import Annotated, Any, Protocol, runtime_checkable

import tyro

from mot_sim.cli.streams import prepare_streams, writing_stdout
from mot_sim.cli.terminal import INTERRUPTED, OK, WRONG, Terminal

DESCRIPTION = """\
Camera-only multi-object tracking with geometry, and the testbed for it.

Units: metres, seconds, pixels, degrees. Exit codes: 0 done, 1 (doctor, verify,
compare, sweep, stress, breaking-point) something is wrong, 2 wrong input, 130
interrupted. Help on a command: mot-sim COMMAND --help. Version: --version."""


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


class CommandRegister(Mapping[str, type[Command]]):
    """The commands by name; the file of one is imported when it is looked up."""

    def __init__(self, places: Mapping[str, str]) -> None:
        self.places = places  # file and class

    def __getitem__(self, name: str) -> type[Command]:
        file, _, kind = self.places[name].partition(":")
        command: type[Command] = getattr(import_module(f"mot_sim.cli.{file}"), kind)
        return command

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
        "scenes": "scenes:Scenes",
        "record": "record:Record",
        "verify": "verify:Verify",
        "calibrate": "calibrate:Calibrate",
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
            if list(arguments) == ["--version"]:
                from importlib.metadata import version

                sys.stdout.write(f"mot-sim {version('mot-sim')}\n")
                return OK
            try:
                command = parse(arguments)
            except SystemExit as leaving:  # tyro has shown the help, or what is wrong
                code = leaving.code if isinstance(leaving.code, int) else OK
    except Exception as error:
        from tracker.errors import BadOutput  # loads what --help must not wait for

        if not isinstance(error, BadOutput):
            raise
        terminal.error(str(error))
        return WRONG
    if command is None:
        return code
    with terminal.logging(command.verbose):
        return run_parsed(command, terminal)


def parse(arguments: Sequence[str]) -> Command:
    """The command that the arguments spell; SystemExit for --help and for what is no command."""
    config = (
        tyro.conf.FlagCreatePairsOff,
        tyro.conf.OmitArgPrefixes,
        tyro.conf.HelptextFromCommentsOff,
    )
    name, *options = arguments or [""]
    command: Command
    if name in COMMANDS:
        command = tyro.cli(COMMANDS[name], prog=f"mot-sim {name}", args=options, config=config)
    else:  # no command: tyro shows them all, or says what is wrong
        every: Any = reduce(or_, (_overview(name) for name in COMMANDS))
        command = tyro.cli(
            every, prog="mot-sim", description=DESCRIPTION, args=list(arguments), config=config
        )
    return command


def _overview(name: str) -> Any:
    """A command as tyro wants it, with the first line of what it says about itself."""
    line = (COMMANDS[name].__doc__ or "").split("\n")[0]
    return Annotated[COMMANDS[name], tyro.conf.subcommand(name, description=line)]


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


__all__ = ["COMMANDS", "Command", "parse", "run"]
