"""`mot-sim demo`: the main job without any data."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from mot_sim.cli.options import Flag, Verbose, option, parse_knobs
from mot_sim.cli.terminal import OK, Terminal


@dataclass(frozen=True)
class Demo:
    """Render, track and score an intersection; needs no data.

    mot-sim demo --out out/demo

    Writes a video, pictures, the results and a table into DIR, and shows the table.
    """

    out: Annotated[Path, option("DIR", "out/demo")] = Path("out/demo")
    """A new or empty folder, unless --overwrite is given."""
    scene: Annotated[str, option("NAME", "intersection")] = "intersection"
    """Another scene: mot-sim scenes."""
    knobs: Annotated[str | None, option("NAME=VALUE,...", "the scene's own")] = None
    """What is changed in the scene, for example weather=night,cars=12; mot-sim scenes NAME."""
    seed: int = 0
    """Seed of all random numbers; the same seed gives the same files."""
    overwrite: Flag = False
    """Replace the demo in the output folder."""
    json: Flag = False
    """Print a summary as JSON instead of the table."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Run the demo and show the result."""
        from mot_sim.demo import DEMO_FRAMES, run_demo
        from mot_sim.simulation.registry import find_scene
        from mot_sim.tables import score_table

        knobs = parse_knobs(self.scene, self.knobs)
        scene = find_scene(self.scene, **({"frames": DEMO_FRAMES} | knobs))
        with terminal.progress(unit="frames") as advance:
            result = run_demo(
                self.out,
                self.seed,
                self.overwrite,
                lambda _, total: advance("film", total=total),
                scene=scene,
            )
        files = {
            "video": [str(result.video)],
            "stills": [str(path) for path in result.stills],
            "tracks": [str(result.tracks)],
            "truth": [str(result.truth)],
            "scores": [str(result.scores_json), str(result.scores_table)],
        }
        if self.json:
            scores = {tracker: each.as_dict() for tracker, each in result.scores.items()}
            terminal.write_json({"frames": result.frame_count, "files": files, "scores": scores})
            return OK
        title = f"{self.scene}, {result.frame_count} frames, seed {self.seed}, rates in %"
        terminal.show(score_table(result.scores, "tracker", title))
        for name, paths in files.items():
            terminal.write(f"{name + ':':<8} {', '.join(paths)}\n")
        return OK
