"""`mot-sim report`: results of other commands as one HTML page."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from mot_sim.cli.options import Flag, Verbose, option
from mot_sim.cli.terminal import OK, Terminal

TITLE = "mot-sim report"


@dataclass(frozen=True)
class Report:
    """Show results as one HTML page: charts, tables, clips, and how they were made.

    mot-sim report out/jitter out/stress --out report.html

    mot-sim report out --out report.html --figures out/figures

    FOLDER is what another command got as --out (sweep, stress, breaking-point, compare, tables,
    tune, diagnose, track), or a folder of such folders; a sweep that is half finished is shown as
    far as it is. The page opens from disk, without a network; clips and pictures are in it as long
    as it stays below 10 MB.
    """

    folders: tyro.conf.Positional[Annotated[tuple[Path, ...], option("FOLDER")]] = ()
    """Folders of results, in the order in which they are shown."""
    out: Annotated[Path, option("FILE", "report.html")] = Path("report.html")
    """The page."""
    title: Annotated[str, option("TEXT", TITLE)] = TITLE
    """Of the page."""
    figures: Annotated[Path | None, option("DIR", "none")] = None
    """Every chart as PNG, SVG and PDF too, for papers."""
    overwrite: Flag = False
    """Replace a page, and figures, that are there already."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Read, write, and say what was left out."""
        from mot_sim.report.page import write_report

        report = write_report(
            self.folders, self.out, title=self.title, figures=self.figures,
            overwrite=self.overwrite,
        )  # fmt: skip
        for path in report.left_out:
            terminal.note(f"left out of the page: {path}; the page says why")
        if report.figures:
            terminal.note(f"written: {self.figures}: {len(report.figures)} figures")
        count = len(report.sources)
        terminal.write(
            f"{report.path}: {count} result{'s' * (count != 1)}, {report.size / 1e6:.1f} MB\n"
        )
        return OK
