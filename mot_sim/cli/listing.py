"""`mot-sim list`: the names that the other commands take."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from inspect import getdoc

from mot_sim.cli.options import Flag, Verbose
from mot_sim.cli.terminal import OK, Terminal


@dataclass(frozen=True)
class List:
    """Show the names that options take.

    mot-sim list

    Scenes, renderers, trackers, costs, associations, detectors, sources of ego-motion, rules,
    export formats.
    """

    json: Flag = False
    """Print them as JSON."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Show the registers."""
        from mot_sim.tables import Column, Table

        names = registers()
        if self.json:
            terminal.write_json(names)
            return OK
        rows = tuple(
            (option if number == 0 else "", name, what)
            for option, register in names.items()
            for number, (name, what) in enumerate(register.items())
        )
        terminal.show(
            Table((Column("option", "name"), Column("name", "name"), Column("what it is")), rows)
        )
        return OK


def registers() -> dict[str, dict[str, str]]:
    """By option: the names it takes, and the first line of what each is."""
    from mot_sim.cli.export import FORMATS
    from mot_sim.datasets import DETECTORS, EGO
    from mot_sim.metrics import RULES
    from mot_sim.simulation.registry import SCENES
    from mot_sim.simulation.renderers import AUTO, RENDERERS
    from tracker import FRAMEWORKS, TRACKERS
    from tracker.costs import COSTS

    rows = {name: f"rows of {' '.join(form.columns[:7])}" for name, form in DETECTORS.items()}
    return {
        "SCENE": _first_lines(SCENES),
        "--renderer": _first_lines(RENDERERS) | {AUTO: "mesh where there is OpenGL, else raster"},
        "--tracker": _described(TRACKERS),
        "--costs": _described(COSTS),
        "--association": _described(FRAMEWORKS),
        "--detections": dict(sorted(rows.items())),
        "--ego": _described({name: type(source) for name, source in EGO.items()}),
        "--rules": _described(RULES),
        "--to": _described(FORMATS),
    }


def _first_lines(register: Mapping[str, str]) -> dict[str, str]:
    """Of the modules that a register names by string."""
    modules = {name: place.partition(":")[0] for name, place in sorted(register.items())}
    return {
        name: (getdoc(import_module(module)) or "").split("\n")[0]
        for name, module in modules.items()
    }


def _described(register: dict) -> dict[str, str]:
    return {name: (getdoc(thing) or "").split("\n")[0] for name, thing in sorted(register.items())}
