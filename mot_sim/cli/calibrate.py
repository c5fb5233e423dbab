"""`mot-sim calibrate`: a noise profile fitted to detections with labels."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mot_sim.cli.evaluate import require_targets
from mot_sim.cli.options import DETECTIONS, File, KittiOptions, Verbose, option
from mot_sim.cli.terminal import OK, Terminal

if TYPE_CHECKING:
    import mot_sim.datasets
    import mot_sim.simulation.sensors.fitting.fit_report
    import mot_sim.simulation.sensors.fitting.measure
    import mot_sim.tables

SIMULATIONS = 5  # compared with the real detections


@dataclass(frozen=True)
class Calibrate:
    """Fit a noise profile to detections with labels.

    Shows how well it fits: recall, gaps, box errors, scores and false positives, real beside
    simulated.

    mot-sim calibrate --root KITTI --detections rrc --out rrc.toml --plot rrc.png

    Sequences without labels are left out. The file can be given wherever a profile is named:
    Detector("rrc.toml"). At least 500 detections must match labelled cars.
    """

    kitti: KittiOptions = field(default_factory=KittiOptions)
    """The sequences, and what is known about them."""
    out: Annotated[Path | None, option("FILE", "the profile is not kept")] = None
    """The profile as TOML."""
    plot: Annotated[Path | None, option("FILE", "no picture")] = None
    """Curves of the real and the simulated detections, as PNG."""
    json: File = None
    """The figures as JSON into a file; - prints them instead of the table."""
    csv: File = None
    """The table as CSV into a file; - prints it instead of the table."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Fit, compare, show and keep."""
        from mot_sim.files.writing import require_writable, write_lines
        from mot_sim.plotting import write_image
        from mot_sim.simulation.sensors.fitting.calibrate import fit_profile, simulate
        from mot_sim.simulation.sensors.fitting.fit_report import curves, fit_lines, fit_picture
        from mot_sim.simulation.sensors.fitting.measure import measure
        from mot_sim.simulation.sensors.profile import profile_lines

        require_targets(self.json, self.csv)
        for path in (self.out, self.plot):
            if path is not None:
                require_writable(path)
        _require_picture(self.plot)
        drives = self._drives()
        name = Path(self.kitti.detections or DETECTIONS).stem
        with terminal.progress() as advance:
            profile = fit_profile(drives, name, tell=advance)
            real = measure(drives)
            made = measure(
                [drive for seed in range(SIMULATIONS) for drive in simulate(profile, drives, seed)]
            )
        profile = replace(profile, source=f"mot-sim calibrate: {name}, {profile.source}")
        if self.out is not None:
            write_lines(self.out, profile_lines(profile))
        if self.plot is not None:
            write_image(self.plot, fit_picture(curves(real, made)))
        self._show(terminal, fit_lines(real, made), name)
        for path in (self.out, self.plot):
            if path is not None:
                terminal.note(f"written: {path}")
        return OK

    def _drives(self) -> "list[mot_sim.simulation.sensors.fitting.measure.LabelledDetections]":
        """The labelled drives."""
        from mot_sim.simulation.sensors.fitting.measure import LabelledDetections

        return [
            LabelledDetections.of(drive)
            for drive in replace(self.kitti, ego=self.kitti.ego or "none").open("labelled")
            if drive.truth is not None
        ]

    def _show(
        self,
        terminal: Terminal,
        lines: "list[mot_sim.simulation.sensors.fitting.fit_report.FitComparison]",
        name: str,
    ) -> None:
        from mot_sim.cli.evaluate import deliver
        from mot_sim.tables import Column, Table

        columns = (
            Column("figure"),
            *(Column(each, "value", digits=4) for each in ("real", "made")),
        )
        rows = tuple((line.what, line.real, line.made) for line in lines)
        table = Table(columns, rows, f"{name}: real beside made, {SIMULATIONS} simulations")
        content = {line.what: {"real": line.real, "made": line.made} for line in lines}
        deliver(terminal, table, content, self.json, self.csv)


def _require_picture(path: Path | None) -> None:
    """BadConfig for a picture that is no PNG."""
    from tracker.errors import BadConfig

    if path is not None and path.suffix.lower() != ".png":
        raise BadConfig(f"--plot {path}: give a file that ends in .png")
