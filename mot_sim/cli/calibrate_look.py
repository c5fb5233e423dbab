"""`mot-sim calibrate-look`: a look of the camera fitted to photographs."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.options import File, Verbose, option
from mot_sim.cli.terminal import OK, Terminal

if TYPE_CHECKING:
    import mot_sim.simulation.camera_looks.fitting
    import mot_sim.simulation.camera_looks.image_statistics
    import mot_sim.tables

Folders = tyro.conf.UseAppendAction[tuple[Path, ...]]


@dataclass(frozen=True)
class CalibrateLook:
    """Fit a look of the camera to photographs: the drawn frames of scenes get their statistics.

    mot-sim calibrate-look --photos KITTI/training/image_02/0000 --photos my/images --out look.toml

    Contrast, shadows, clipping, colours, sharpness and noise are measured in the photographs and in
    frames of the scenes at noon; the look's blur, exposure, colours, tone curve and noise are
    fitted, so that every scene's lie in the range of the folders'. The file can be given wherever a
    look is named: --knobs camera_look=look.toml.
    """

    photos: Annotated[Folders, option("DIR", "none: it must be given")]
    """A folder of images 000000.png or .jpg; repeat it for more. Each folder is one clip; the
    statistics' ranges go over the clips."""
    out: Annotated[Path | None, option("FILE", "the look is not kept")] = None
    """The look as TOML."""
    look: Annotated[str, option("NAME|FILE", "kitti")] = "kitti"
    """Where the search begins; what is not fitted stays as it is there."""
    scenes: Annotated[str, option("NAMES", "street,intersection,town")] = "street,intersection,town"
    """The scenes whose frames are drawn."""
    seeds: int = 2
    """Runs of each scene."""
    per_clip: int = 12
    """Photographs of each folder that are measured, evenly spread."""
    json: File = None
    """The figures as JSON into a file; - prints them instead of the table."""
    csv: File = None
    """The table as CSV into a file; - prints it instead of the table."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Measure, fit, show and keep."""
        from mot_sim.cli.evaluate import deliver, require_targets
        from mot_sim.files.writing import require_writable, write_lines
        from mot_sim.simulation.camera_looks import find_camera_look, look_lines
        from mot_sim.simulation.camera_looks.fitting import StatisticsRange, fit_look
        from mot_sim.simulation.camera_looks.image_statistics import mean_statistics
        from mot_sim.simulation.look_frames import drawn_frames, photographs
        from tracker.errors import BadConfig

        require_targets(self.json, self.csv)
        if self.out is not None:
            require_writable(self.out)
        if self.seeds < 1:
            raise BadConfig(f"--seeds {self.seeds}: give 1 or more")
        begin = find_camera_look(self.look)
        clips = [mean_statistics(photographs(each, self.per_clip)) for each in self.photos]
        wanted = StatisticsRange.of(clips)
        names = [name.strip() for name in self.scenes.split(",")]
        with terminal.progress() as advance:
            scenes = {
                name: drawn_frames(
                    name, range(3, 3 + self.seeds), progress=lambda: advance("drawing")
                )
                for name in names
            }
            look = fit_look(begin, scenes, wanted, lambda: advance("fitting"))
        folders = ", ".join(each.name for each in self.photos)
        source = f"mot-sim calibrate-look: {', '.join(names)} at noon, photographs of {folders}"
        look = replace(look, name=self.out.stem if self.out else look.name, source=source)
        if self.out is not None:
            write_lines(self.out, look_lines(look))
        seen = {
            name: mean_statistics(each.developed(look) for each in frames)
            for name, frames in scenes.items()
        }
        table, content = comparison(wanted, seen)
        deliver(terminal, table, content, self.json, self.csv)
        if self.out is not None:
            terminal.note(f"written: {self.out}")
        return OK


def comparison(
    wanted: "mot_sim.simulation.camera_looks.fitting.StatisticsRange",
    seen: "dict[str, mot_sim.simulation.camera_looks.image_statistics.ImageStatistics]",
) -> "tuple[mot_sim.tables.Table, dict[str, dict[str, float]]]":
    """The statistics of photographs and scenes, as a table and as JSON."""
    from mot_sim.simulation.camera_looks.image_statistics import STATISTICS
    from mot_sim.tables import Column, Table

    columns = (
        Column("statistic"),
        *(Column(each, "value", digits=2) for each in ("photos from", "to", *seen)),
    )
    rows = tuple(
        (
            name,
            getattr(wanted.least, name),
            getattr(wanted.most, name),
            *(getattr(each, name) for each in seen.values()),
        )
        for name in STATISTICS
    )
    content = {
        name: dict(zip(("least", "most", *seen), values, strict=True)) for name, *values in rows
    }
    return Table(columns, rows, "photographs beside scenes"), content
