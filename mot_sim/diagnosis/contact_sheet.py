"""The sheet of worst moments: a picture a switch, the worst first, and one of all of them."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from mot_sim.datasets.images import ImageSource
from mot_sim.diagnosis.findings import Case, Findings
from mot_sim.diagnosis.panels import SHEET_WIDTH_PIXELS, Scenario, draw_case
from mot_sim.diagnosis.tasks import KittiTask, SceneTask, Task
from mot_sim.plotting import write_image
from mot_sim.plotting.colours import PANEL_COLOUR
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.scene import Rollout
from tracker.errors import BadOutput

SHEET_FILE = "sheet.png"
MAX_STRIPS = 12  # moments; more would not be read
STRIP_GAP_PIXELS = 10  # pixels between two of them
Progress = Callable[[str, int, int], None]


def worst_first(found: Sequence[Findings], most: int) -> list[Case]:
    """The switches whose car loses the most of a name: the longer its shorter run, the worse."""
    switches = [case for each in found for case in each.cases if case.switched]
    return sorted(switches, key=lambda each: -each.weight)[:most]


def draw_contact_sheet(
    folder: Path,
    found: Sequence[Findings],
    tasks: Sequence[Task],
    *,
    most: int,
    renderer: str | None = "raster",
    progress: Progress | None = None,
) -> list[Path]:
    """Draw the worst switches; gives the files, the sheet first; none for no switch.

    renderer: of the images of scenes; None: boxes on a plain ground. KITTI's own images are taken
    where the tree has them. Raises BadOutput, and NoOpenGL for a renderer that cannot be.
    """
    cases = worst_first(found, most)
    if not cases:
        return []
    require_folder(folder)
    by_name = {task.name: task for task in tasks}
    strips: dict[int, Array] = {}
    files: dict[int, Path] = {}
    done = 0
    for name in dict.fromkeys(case.drive for case in cases):
        scenario = scenario_of(by_name[name], renderer)
        for number, case in enumerate(cases, 1):
            if case.drive != name:
                continue
            whole, strip = draw_case(scenario, case, number)
            if number <= MAX_STRIPS:
                strips[number] = strip
            drive = name.replace("/", "_")
            files[number] = folder / f"{number:02d}_{drive}_car{case.car}_frame{case.frame}.png"
            write_image(files[number], whole)
            done += 1
            if progress is not None:
                progress("pictures", done, len(cases))
    write_image(folder / SHEET_FILE, _stacked([strips[number] for number in sorted(strips)]))
    return [folder / SHEET_FILE, *(files[number] for number in sorted(files))]


def require_folder(folder: Path) -> None:
    """Make the folder. Raises BadOutput where that fails."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadOutput(f"{folder}: no folder for pictures: {error.strerror}") from None


def scenario_of(task: Task, renderer: str | None) -> Scenario:
    """A drive with what the tracker makes of it, and its images."""
    watched, output = task.look()
    images: ImageSource | None = None
    if isinstance(task, KittiTask):
        images = task.pictures
    elif isinstance(task, SceneTask) and renderer is not None:
        take = Rollout.of(task.conditions.make_scene(), task.seed, task.recorded.traffic)
        images = RenderedImages(take, renderer)
    return Scenario(watched, output, images)


def _stacked(strips: list[Array]) -> Array:
    """The strips one below the other."""
    space = np.full((STRIP_GAP_PIXELS, SHEET_WIDTH_PIXELS, 3), PANEL_COLOUR, np.uint8)
    parts = [part for strip in strips for part in (strip, space)]
    return np.concatenate(parts[:-1])


__all__ = ["SHEET_FILE", "draw_contact_sheet", "scenario_of", "worst_first"]
