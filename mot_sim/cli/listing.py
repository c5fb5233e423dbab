"""`mot-sim list`: the names that the other commands take."""

from dataclasses import dataclass
from inspect import getdoc

from mot_sim.cli.options import Flag, Verbose
from mot_sim.cli.terminal import OK, Terminal


@dataclass(frozen=True)
class List:
    """Show the names that options take.

    mot-sim list

    Trackers, costs, associations, detectors, sources of ego-motion, rules, export formats.
    """

    json: Flag = False
    """Print them as JSON."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Show the registers."""
        from mot_sim.report.grid import Column, Table

        names = registers()
        if self.json:
            terminal.write_json(names)
            return OK
        rows = tuple(
            (option if number == 0 else "", name, what)
            for option, register in names.items()
            for number, (name, what) in enumerate(register.items())
        )
        terminal.show(Table((Column("option"), Column("name"), Column("what it is")), rows))
        return OK


def registers() -> dict[str, dict[str, str]]:
    """By option: the names it takes, and the first line of what each is."""
    from mot_sim.cli.export import FORMATS
    from mot_sim.datasets import DETECTORS, EGO
    from mot_sim.metrics import RULES
    from tracker import TRACKERS
    from tracker.association import ASSOCIATIONS
    from tracker.costs import COSTS

    rows = {name: f"rows of {' '.join(form.columns[:7])}" for name, form in DETECTORS.items()}
    return {
        "--tracker": _described(TRACKERS),
        "--costs": _described(COSTS),
        "--associate": _described(ASSOCIATIONS),
        "--detections": dict(sorted(rows.items())),
        "--ego": _described({name: type(source) for name, source in EGO.items()}),
        "--rules": _described(RULES),
        "--to": _described(FORMATS),
    }


def _described(register: dict) -> dict[str, str]:
    return {name: (getdoc(thing) or "").split("\n")[0] for name, thing in sorted(register.items())}
