"""`mot-sim kitti`: track and evaluate in one, with the table."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mot_sim.cli.evaluate import deliver, require_targets, say_unlabelled
from mot_sim.cli.options import (
    DETECTIONS,
    EGO,
    File,
    FolderOptions,
    KittiOptions,
    Rules,
    TrackerOptions,
    Verbose,
    option,
)
from mot_sim.cli.terminal import INTERRUPTED, OK, Terminal
from mot_sim.cli.track import run_tracker, stages_said

if TYPE_CHECKING:
    import mot_sim.datasets
    import mot_sim.evaluation.run_folder
    import mot_sim.metrics
    import mot_sim.tables


@dataclass(frozen=True)
class Kitti:
    """Track KITTI sequences and score them: the table of a paper.

    mot-sim kitti --root KITTI --detections rrc --ego oxts

    mot-sim kitti --trackers default,paper --rules devkit2018

    One tracker: one row per sequence and one for all together. Several: one row per tracker, over
    all sequences. Rates are in percent, in JSON and CSV fractions.
    """

    trackers: Annotated[str, option("NAMES", "default")] = "default"
    """Which trackers, for example default,paper."""
    method: TrackerOptions = field(default_factory=TrackerOptions)
    """What is changed in the trackers."""
    kitti: KittiOptions = field(default_factory=KittiOptions)
    """The sequences, and what is known about them."""
    rules: Rules = "trackeval"
    """trackeval (1.3.0), or devkit2018: KITTI's kit of the paper's time, CLEAR only."""
    out: Annotated[Path | None, option("DIR", "results are not kept")] = None
    """Keep the results in DIR/TRACKER/SSSS.txt."""
    folder: FolderOptions = field(default_factory=FolderOptions)
    """What happens to results that are in DIR already."""
    json: File = None
    """All scores as JSON into a file; - prints them instead of the table."""
    csv: File = None
    """The table as CSV into a file; - prints it instead of the table."""
    verbose: Verbose = 0
    """Say more: -v a line a sequence, -vv details."""

    def __call__(self, terminal: Terminal) -> int:
        """Track, score and show."""
        from mot_sim.evaluation.scoring import require_rules, score_sequences

        require_rules(self.rules)
        require_targets(self.json, self.csv)
        for name in self._names():
            self.method.recipe(name)  # its names are checked before anything is read
        drives = self.kitti.open("labelled", self.method.wants_images)
        kinds = drives[0].kinds
        recipes = {name: self.method.recipe(name, kinds) for name in self._names()}
        folders = {name: self._folder(name, drives) for name in recipes}
        scored = {}
        for name, recipe in recipes.items():
            run = run_tracker(terminal, recipe, drives, folders[name])
            if run is None:
                return INTERRUPTED
            if run.stage_ms:
                terminal.note(f"{name}{stages_said(run)}")
            for kind in kinds:
                row = name if len(kinds) == 1 else f"{name}, {kind}"
                scored[row] = score_sequences(drives, run.tracks, self.rules, kind)
        evaluations = {name: each.evaluation for name, each in scored.items()}
        content = {name: evaluation.as_dict() for name, evaluation in evaluations.items()}
        deliver(terminal, self._table(evaluations), content, self.json, self.csv)
        say_unlabelled(terminal, next(iter(scored.values())).unlabelled)
        return OK

    def _names(self) -> list[str]:
        """The trackers, each once, in the given order."""
        return list(dict.fromkeys(name.strip() for name in self.trackers.split(",")))

    def _folder(
        self, tracker: str, drives: "list[mot_sim.datasets.KittiSequence]"
    ) -> "mot_sim.evaluation.run_folder.RunFolder | None":
        """Where the results of a tracker are kept, if they are."""
        from tracker.errors import BadConfig

        if self.out is None:
            if self.folder.resume or self.folder.overwrite:
                raise BadConfig("--resume and --overwrite are about kept results: give --out too")
            return None
        settings = {**self.method.settings(tracker), **self.kitti.settings()}
        return self.folder.open(self.out / tracker, settings, [drive.name for drive in drives])

    def _table(
        self, evaluations: "dict[str, mot_sim.metrics.Evaluation]"
    ) -> "mot_sim.tables.Table":
        """One row per sequence for one tracker, one row per tracker for several."""
        from mot_sim.tables import score_table

        drive = f"{self.kitti.detections or DETECTIONS} boxes, ego {self.kitti.ego or EGO}"
        if len(evaluations) == 1:
            ((tracker, evaluation),) = evaluations.items()
            return score_table(
                {**evaluation.sequences, "combined": evaluation.combined},
                title=f"{tracker}: {drive}, rules {self.rules}, rates in %",
                sums=1,
            )
        return score_table(
            {name: evaluation.combined for name, evaluation in evaluations.items()},
            "tracker",
            f"{drive}, rules {self.rules}, rates in %",
        )
