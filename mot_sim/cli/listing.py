"""`mot-sim list`: the names that the other commands take."""

from dataclasses import dataclass
from inspect import getdoc, getmodule
from typing import TYPE_CHECKING, Any

from mot_sim.cli.options import Flag, Verbose
from mot_sim.cli.terminal import OK, Terminal

if TYPE_CHECKING:
    from mot_sim.files.named_objects import NameRegister


@dataclass(frozen=True)
class List:
    """Show the names that options take.

    mot-sim list

    Scenes, renderers, trackers, costs, associations, suites, detectors, sources of ego-motion,
    rules, export formats; of mot-sim and of installed packages. Where a scene, tracker, cost,
    association, suite or renderer is wanted, MODULE:NAME of your own will do as well.
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
    """By option: the names it takes, and the first line of what each is, or what is wrong."""
    from mot_sim.cli.export import FORMATS
    from mot_sim.datasets import DETECTORS, EGO
    from mot_sim.datasets.box_writers import BOX_WRITERS
    from mot_sim.experiments.stress.suites import read_suites, suite_names
    from mot_sim.files.named_objects import ASSOCIATION_NAMES, COST_NAMES, TRACKER_NAMES
    from mot_sim.metrics import RULES
    from mot_sim.simulation.registry import SCENE_NAMES
    from mot_sim.simulation.renderers import AUTO, RENDERER_NAMES

    rows = {name: f"rows of {' '.join(form.columns[:7])}" for name, form in DETECTORS.items()}
    return {
        "SCENE": _named(SCENE_NAMES),
        "--renderer": _named(RENDERER_NAMES) | {AUTO: "mesh where there is OpenGL, else raster"},
        "--tracker": _named(TRACKER_NAMES),
        "--costs": _named(COST_NAMES),
        "--association": _named(ASSOCIATION_NAMES),
        "SUITE": _named(suite_names(read_suites())),
        "--detections": dict(sorted(rows.items())),
        "--ego": {name: _about(type(source)) for name, source in sorted(EGO.items())},
        "--rules": {name: _about(rules) for name, rules in sorted(RULES.items())},
        "--to": {name: _about(form) for name, form in sorted({**FORMATS, **BOX_WRITERS}.items())},
    }


def _named(register: "NameRegister") -> dict[str, str]:
    """Of what goes by name."""
    broken = {name: f"broken: {why}" for name, why in register.broken().items()}
    whole = [name for name in register.names() if name in register.ours or name not in broken]
    told = {}
    for name in sorted(whole):
        thing = register.find(name)
        is_in_its_module = isinstance(register.ours.get(name), str)
        told[name] = _about(getmodule(thing) if is_in_its_module else thing)
    return told | {name: why for name, why in broken.items() if name not in told}


def _about(thing: Any) -> str:
    """The first line of what a thing says of itself."""
    return str(getattr(thing, "about", None) or getdoc(thing) or "").split("\n")[0]
