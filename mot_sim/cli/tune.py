"""`mot-sim tune`: weights of the costs by cross-validation."""

import json as jsonlib
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mot_sim.cli.keeping import keep
from mot_sim.cli.options import DETECTIONS, EGO, File, Jobs, Root, Rules, Verbose, help_of, option
from mot_sim.cli.terminal import INTERRUPTED, OK, STDOUT, Terminal

if TYPE_CHECKING:
    import mot_sim.experiments.tuning.labelled

_of_search = partial(help_of, "mot_sim.experiments.tuning.cross_validation", "WeightSearch")


@dataclass(frozen=True)
class Tune:
    """Choose the weights of costs by cross-validation over labelled drives.

    mot-sim tune --costs volume,reprojection --tracker paper --root KITTI --out out/tune

    mot-sim tune --costs image_overlap=0.8,shape_pose=0.2 --scene intersection --seeds 12
    --profile cues --out out/made

    The drives are divided into folds that are alike in cars, occlusion, truncation and motion. For
    each fold the weights are optimised on the others (random, then local search) and scored on it.
    DIR/weights has one file per tested weight vector: after Ctrl-C the same command continues and
    repeats nothing.
    """

    costs: Annotated[str, option("NAME[=WEIGHT],...", "none: it must be given")]
    """The costs, with their initial weights; 1 for a name alone."""
    out: Annotated[Path, option("DIR", "none: it must be given")]
    """Where the log goes, and the recordings of simulated drives."""
    tracker: Annotated[str, option("NAME[:SETTING=VALUE]...", "default")] = "default"
    """default or paper, with settings as in mot-sim sweep, associate=window for example."""
    root: Root = None
    """The KITTI tree."""
    sequences: Annotated[str, option("NAMES", "given")] = "given"
    """given (those with labels), or names: 0000,0005."""
    detections: Annotated[str, option("NAME", DETECTIONS)] = DETECTIONS
    """A detector of the tree."""
    ego: Annotated[str, option("NAME", EGO)] = EGO
    """Where the camera's motion comes from: oxts, orbslam3, none."""
    scene: Annotated[str | None, option("NAMES", "KITTI")] = None
    """Simulated drives instead of KITTI: names of mot-sim scenes, separated by commas."""
    profile: Annotated[str, option("NAME|FILE", "cues")] = "cues"
    """The detector's noise in simulated drives."""
    seeds: Annotated[int, option("N", "12")] = 12
    """Number of simulated drives of each scene."""
    first_seed: Annotated[int, option("N", "1000")] = 1000
    """First seed of simulated drives; results reported elsewhere use seeds below 1000."""
    frames: Annotated[int, option("N", "100")] = 100
    """Frames per simulated drive."""
    folds: Annotated[int, option("N", "4", help=_of_search("folds"))] = 4
    objective: Annotated[str, option("NAME", "HOTA")] = "HOTA"
    """HOTA or MOTA."""
    rules: Rules = "trackeval"
    """trackeval or devkit2018 (which has no HOTA)."""
    samples: Annotated[int, option("N", "60", help=_of_search("samples"))] = 60
    seed: Annotated[int, option("N", "0", help=_of_search("seed"))] = 0
    jobs: Jobs = 1
    json: File = None
    """The outcome as JSON into a file; - prints it instead of the table."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Tune and show."""
        from mot_sim.cli.evaluate import require_targets
        from mot_sim.evaluation.runs import parse_costs
        from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
        from mot_sim.experiments.tuning.cross_validation import WeightSearch, tune
        from mot_sim.experiments.tuning.weighing import Method, Scale, weights_of

        require_targets(self.json, None)
        start = parse_costs(self.costs)
        weights_of(list(start.values()))
        search = WeightSearch(self.objective, self.samples, self.folds, self.seed)
        self._require_rules()
        method = Method(tuple(start), TrackerSpec.parse(self.tracker))
        method.contender.check()
        try:
            drives = self._drives()
            scale = Scale.of(method, drives, self.rules, self.out, self.jobs)
            with terminal.progress(lines=True) as advance:
                tuned = tune(scale, search, list(start.values()), advance)
        except KeyboardInterrupt:
            terminal.note(
                f"interrupted: what was weighed stands in {self.out}; the same command goes on"
            )
            return INTERRUPTED
        from mot_sim.experiments.tuning.outcome_tables import (
            fold_table,
            tuned_content,
            tuned_summary,
            tuned_tables,
        )

        made = self.scene or f"KITTI, {self.detections} boxes, ego {self.ego}"
        tables = tuned_tables(tuned, self.objective)
        keep(self.out, "tune", f"Weights of {', '.join(tuned.names)}: {made}", tables)
        if self.json is not None:
            content = jsonlib.dumps(tuned_content(tuned, self.objective), indent=2)
            terminal.save(content + "\n", self.json)
        if self.json != STDOUT:
            terminal.show(fold_table(tuned, self.objective))
            terminal.write(tuned_summary(tuned, self.objective))
        terminal.note(f"{tuned.weighed} weight vectors, {tuned.fresh} of them weighed now")
        return OK

    def _drives(self) -> "tuple[mot_sim.experiments.tuning.labelled.LabelledSequence, ...]":
        from mot_sim.experiments.tuning.labelled import kitti_drives, made_drives

        if self.scene is None:
            return kitti_drives(self.root, self.sequences, self.detections, self.ego)
        scenes = [name.strip() for name in self.scene.split(",")]
        seeds = range(self.first_seed, self.first_seed + self.seeds)
        settings: dict[str, float | int | str | bool] = {
            "scene.profile": self.profile,
            "scene.frames": self.frames,
        }
        return made_drives(self.out / "drives", scenes, seeds, settings)

    def _require_rules(self) -> None:
        from mot_sim.evaluation.scoring import require_rules
        from tracker.errors import BadConfig

        require_rules(self.rules)
        if self.rules == "devkit2018" and self.objective == "HOTA":
            raise BadConfig("the rules devkit2018 have no HOTA: give --objective MOTA")
