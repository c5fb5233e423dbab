"""`mot-sim kitti`: track and evaluate in one, with the table."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.evaluate import (
    THRESHOLDS,
    deliver,
    deliver_3d,
    require_targets,
    say_unlabelled,
)
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
    import mot_sim.evaluation.spatial_scoring
    import mot_sim.metrics
    import mot_sim.tables


@dataclass(frozen=True)
class Kitti:
    """Track KITTI sequences and score them: the table of a paper.

    mot-sim kitti --root KITTI --detections rrc --ego oxts

    mot-sim kitti --trackers default,paper --rules devkit2018

    mot-sim kitti --3d

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
    spatial: Annotated[bool, tyro.conf.arg(name="3d", help_behavior_hint="")] = False
    """Score cuboids instead: as mot-sim evaluate --3d does, and how honest the uncertainties are
    that the tracker states."""
    thresholds: Annotated[str | None, option("LIST", THRESHOLDS)] = None
    """With --3d: what makes a match, least 3D IoU or largest distance of the centres in metres."""
    out: Annotated[Path | None, option("DIR", "results are not kept")] = None
    """Keep the results in DIR/TRACKER/SSSS.txt; with --3d and one tracker also what mot-sim report
    shows of them."""
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
        from mot_sim.evaluation.spatial_scoring import score_in_3d

        require_rules(self.rules)
        criteria = self._criteria()
        require_targets(self.json, self.csv)
        for name in self._names():
            self.method.recipe(name)  # its names are checked before anything is read
        drives = self.kitti.open("labelled", self.method.wants_images)
        kinds = drives[0].kinds
        recipes = {name: self.method.recipe(name, kinds) for name in self._names()}
        folders = {name: self._folder(name, drives) for name in recipes}
        scored, spatial = {}, {}
        for name, recipe in recipes.items():
            run = run_tracker(terminal, recipe, drives, folders[name])
            if run is None:
                return INTERRUPTED
            if run.stage_ms:
                terminal.note(f"{name}{stages_said(run)}")
            for kind in kinds:
                row = name if len(kinds) == 1 else f"{name}, {kind}"
                if criteria is not None:
                    spatial[row] = score_in_3d(drives, run.tracks, criteria, kind)
                    continue
                scored[row] = score_sequences(drives, run.tracks, self.rules, kind)
        if spatial:
            self._show_3d(terminal, spatial)
            return OK
        evaluations = {name: each.evaluation for name, each in scored.items()}
        content = {name: evaluation.as_dict() for name, evaluation in evaluations.items()}
        deliver(terminal, self._table(evaluations), content, self.json, self.csv)
        say_unlabelled(terminal, next(iter(scored.values())).unlabelled)
        return OK

    def _criteria(self) -> "tuple[mot_sim.metrics.Criterion, ...] | None":
        """What makes a match in 3D; None where boxes are scored."""
        from mot_sim.evaluation.spatial_scoring import parse_criteria
        from tracker.errors import BadConfig

        if not self.spatial:
            if self.thresholds is not None:
                raise BadConfig(f"--thresholds {self.thresholds}: only cuboids have some; add --3d")
            return None
        if self.rules != "trackeval":
            raise BadConfig(f"--rules {self.rules}: with --3d there are no other rules")
        return parse_criteria(self.thresholds or THRESHOLDS)

    def _show_3d(
        self,
        terminal: Terminal,
        scored: "dict[str, mot_sim.evaluation.spatial_scoring.SpatialEvaluation]",
    ) -> None:
        """One tracker in full, or one row per tracker."""
        from mot_sim.tables import spatial_table

        drive = f"{self.kitti.detections or DETECTIONS} boxes, ego {self.kitti.ego or EGO}"
        if len(scored) == 1:
            ((name, evaluation),) = scored.items()
            title = f"{name}: {drive}, in 3D"
            deliver_3d(terminal, evaluation, title, self.json, self.csv, self.out)
        else:
            whole = {name: each.combined for name, each in scored.items()}
            table = spatial_table(whole, "tracker", f"{drive}, in 3D, rates in %")
            content = {name: each.as_dict() for name, each in scored.items()}
            deliver(terminal, table, content, self.json, self.csv)
        say_unlabelled(terminal, next(iter(scored.values())).unlabelled)

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
