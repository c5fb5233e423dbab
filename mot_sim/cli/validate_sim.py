"""`mot-sim validate-sim`: whether made drives foretell what trackers do on real ones."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mot_sim.cli.options import DETECTIONS, File, Flag, Jobs, Root, Verbose, help_of, option
from mot_sim.cli.terminal import BROKEN, INTERRUPTED, OK, STDOUT, Terminal

if TYPE_CHECKING:
    import mot_sim.experiments.validation.validate

_MODULE = "mot_sim.experiments.validation.validate"


def _of_plan(field: str) -> object:
    return help_of(_MODULE, "Plan", field)


@dataclass(frozen=True)
class ValidateSim:
    """Check whether simulated drives foretell what trackers do on your data.

    mot-sim validate-sim --root KITTI --detections rrc --out out/validation

    mot-sim validate-sim --root KITTI --trackers default,sort,mine=MODULE:CALLABLE
    --scenes street,intersection

    The labelled drives are re-enacted: their cars are replayed, drawn, and seen by a noise profile
    that is fitted to the other half of the drives. The same trackers run on both kinds: ours,
    variants of ours, and other people's (mot-sim compare --setup all makes their environments,
    once). Shown are every tracker's scores, how far the made ones are off, how the ranks agree,
    and how far ours are ahead of the best guest. A guest that is missing is named, the others go
    on, and the exit code is 1. With --out, the same command goes on where it was interrupted.
    """

    root: Root = None
    """The folder that holds training/ and, beside it, detections/."""
    sequences: Annotated[str, option("NAMES", "labelled")] = "labelled"
    """labelled (those with labels), or names: 0000,0005."""
    detections: Annotated[str, option("NAME|PATH", DETECTIONS)] = DETECTIONS
    """A detector of <root>/detections (mot-sim list), or a folder of SSSS.txt."""
    trackers: Annotated[str | None, option("NAMES", "ours, their variants, and all guests")] = None
    """As for mot-sim compare, and greedy, no-ego, low-memory: variants of default."""
    profile: Annotated[str, option("NAME|FILE", "halves", help=_of_plan("profile"))] = "halves"
    scenes: Annotated[str | None, option("NAMES", "none")] = None
    """Scenes (mot-sim list) whose ranks are compared with the real ones, too."""
    scenes_only: Flag = False
    """Rank trackers in the scenes beside the real drives, and re-enact nothing."""
    seeds: Annotated[int, option("N", "5", help=_of_plan("seeds"))] = 5
    frames: Annotated[int | None, option("N", "the scene's own", help=_of_plan("frames"))] = None
    out: Annotated[Path | None, option("DIR", "nothing is kept")] = None
    """Keeps profiles, drawings and scores, from which the same command goes on, and the result
    for mot-sim report."""
    jobs: Jobs = 1
    json: File = None
    """All figures as JSON into a file; - prints them instead of the tables."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Check and show."""
        from mot_sim.cli.compare import names_in, say_failures
        from mot_sim.cli.evaluate import require_targets
        from mot_sim.cli.options import KittiOptions
        from mot_sim.experiments.validation import find_contestants
        from mot_sim.experiments.validation.validate import Plan, validate

        require_targets(self.json, None)
        plan = Plan(
            find_contestants(names_in(self.trackers)),
            self.seeds,
            self.profile,
            names_in(self.scenes),
            self.frames,
            self.out,
            self.jobs,
            self.scenes_only,
        )
        options = KittiOptions(root=self.root, sequences=self.sequences, detections=self.detections)
        drives = [drive for drive in options.open("labelled") if drive.truth is not None]
        try:
            with terminal.progress(lines=True) as advance:
                found = validate(plan, drives, advance)
        except KeyboardInterrupt:
            kept = "nothing was kept: --out DIR keeps what is done"
            if self.out is not None:
                kept = f"what is done stands in {self.out}; the same command goes on"
            terminal.note(f"interrupted: {kept}")
            return INTERRUPTED
        self._show(terminal, found, f"{self.detections}: {len(drives)} drives, {self.seeds} seeds")
        say_failures(terminal, found.failures)
        return BROKEN if found.failures else OK

    def _show(
        self,
        terminal: Terminal,
        found: "mot_sim.experiments.validation.validate.Validation",
        title: str,
    ) -> None:
        """Tables, JSON, and the result file."""
        import json as jsonlib

        from mot_sim.cli.keeping import keep
        from mot_sim.experiments.validation.agreement_tables import (
            validation_content,
            validation_tables,
        )

        tables = validation_tables(found, title)
        if self.json is not None:
            content = jsonlib.dumps(validation_content(found), indent=2)
            terminal.save(content + "\n", self.json)
        if self.json != STDOUT:
            for table in tables:
                terminal.show(table)
        keep(self.out, "validate-sim", title, tuple(tables))
