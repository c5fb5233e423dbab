"""The command line: one file a command; `COMMANDS` is the register.

Commands import what is heavy only when they run, so that `--help` answers at once.
"""

import os
import sys
from collections.abc import Sequence
from functools import reduce
from importlib.metadata import version
from operator import or_
from typing import Annotated, Any, Protocol, runtime_checkable

import tyro

from mot_sim.cli.breaking_point import BreakingPointCommand
from mot_sim.cli.calibrate import Calibrate
from mot_sim.cli.compare import Compare
from mot_sim.cli.demo import Demo
from mot_sim.cli.diagnose import Diagnose
from mot_sim.cli.doctor import Doctor
from mot_sim.cli.evaluate import Evaluate
from mot_sim.cli.export import Export, ExportCar
from mot_sim.cli.kitti import Kitti
from mot_sim.cli.listing import List
from mot_sim.cli.record import Record
from mot_sim.cli.report import Report
from mot_sim.cli.scenes import Scenes
from mot_sim.cli.show import Show
from mot_sim.cli.streams import prepare_streams, writing_stdout
from mot_sim.cli.stress import Stress
from mot_sim.cli.sweep import Sweep
from mot_sim.cli.tables import Tables
from mot_sim.cli.teaser import Teaser
from mot_sim.cli.terminal import INTERRUPTED, OK, WRONG, Terminal
from mot_sim.cli.track import Track
from mot_sim.cli.train import TrainAppearance, TrainKeypoints
from mot_sim.cli.tune import Tune
from mot_sim.cli.verify import Verify

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


COMMANDS: dict[str, type[Command]] = {
    "track": Track,
    "evaluate": Evaluate,
    "kitti": Kitti,
    "compare": Compare,
    "demo": Demo,
    "show": Show,
    "teaser": Teaser,
    "doctor": Doctor,
    "scenes": Scenes,
    "record": Record,
    "verify": Verify,
    "calibrate": Calibrate,
    "sweep": Sweep,
    "stress": Stress,
    "breaking-point": BreakingPointCommand,
    "diagnose": Diagnose,
    "tune": Tune,
    "tables": Tables,
    "report": Report,
    "export": Export,
    "export-car": ExportCar,
    "train-keypoints": TrainKeypoints,
    "list": List,
    "train-appearance": TrainAppearance,
}


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
