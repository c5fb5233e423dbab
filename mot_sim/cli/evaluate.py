"""`mot-sim evaluate`: results against labels."""

import json as jsonlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.options import Classes, File, Root, Rules, Verbose, option
from mot_sim.cli.terminal import OK, STDOUT, Terminal

if TYPE_CHECKING:
    import mot_sim.evaluation.spatial_scoring
    import mot_sim.evaluation.splits
    import mot_sim.metrics
    import mot_sim.tables

# What makes a match in 3D: AB3DMOT's three, and the distance of nuScenes.
THRESHOLDS = ".25,.5,.7,2m"
ERROR_PICTURES = ("errors_from_above.png", "errors_by_distance.png")


@dataclass(frozen=True)
class Evaluate:
    """Score results against KITTI's labels: CLEAR, HOTA, Identity; with --3d their cuboids.

    mot-sim evaluate out/rrc --root KITTI --csv scores.csv

    mot-sim evaluate out/rrc --root KITTI --3d

    mot-sim evaluate out/mine --truth labels.csv

    One row per sequence and one for all together (counts added up, as in TrackEval). Rates are
    in percent, in JSON and CSV fractions. Sequences without labels are named and left out.
    """

    results: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RESULTS")]
    """A folder with SSSS.txt, or data/SSSS.txt, for every sequence."""
    root: Root = None
    """The KITTI tree whose training/label_02 is the truth."""
    truth: Annotated[Path | None, option("PATH", "the labels of the KITTI tree")] = None
    """Truth of your own: a file of boxes with a column id, a folder of such files (NAME.csv for
    RESULTS/NAME.txt), or a folder of MOTChallenge (NAME/gt/gt.txt), which has its own rules."""
    sequences: Annotated[str | None, option("NAMES", "those with results and labels")] = None
    """all, labelled, or names: 0000,0005."""
    seqmap: Annotated[Path | None, option("FILE", "all frames")] = None
    """Sequences and frames, a line `NAME empty FIRST END` each (from 0; END is after the last)."""
    frames: Annotated[str | None, option("PART", "all")] = None
    """first-half or second-half of every sequence, or FIRST-LAST."""
    rules: Rules = "trackeval"
    """trackeval (1.3.0), or devkit2018: KITTI's kit of the paper's time, CLEAR only."""
    classes: Classes = "car"
    """What is scored, each class by itself: car, pedestrian, cyclist (not KITTI's; the same rules),
    or several: car,pedestrian."""
    spatial: Annotated[bool, tyro.conf.arg(name="3d", help_behavior_hint="")] = False
    """Score the cuboids: AB3DMOT's scores, HOTA in 3D, and what is wrong with place, heading, size
    and speed. The root may be that of recorded episodes."""
    thresholds: Annotated[str | None, option("LIST", THRESHOLDS)] = None
    """With --3d: what makes a match, least 3D IoU or largest distance of the centres in metres."""
    ego: Annotated[str | None, option("NAME", "oxts where it is there")] = None
    """With --3d: where the camera's motion comes from, which tells which cars move."""
    out: Annotated[Path | None, option("DIR", "nothing is kept")] = None
    """With --3d: keep the tables here, and the errors from above as a picture, for mot-sim
    report."""
    json: File = None
    """All scores as JSON into a file; - prints them instead of the table."""
    csv: File = None
    """The table as CSV into a file; - prints it instead of the table."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Score and show."""
        from mot_sim.evaluation.scoring import score_folder
        from mot_sim.evaluation.splits import Split
        from mot_sim.tables import score_table
        from tracker.types import parse_kinds

        require_targets(self.json, self.csv)
        if self.out is not None:
            from mot_sim.files.writing import require_writable

            for name in ERROR_PICTURES:
                require_writable(self.out / name)
        kinds = parse_kinds(self.classes)
        split = Split.of(self.seqmap, self.frames)
        if self.spatial:
            return self._in_3d(terminal, kinds, split)
        self._require_3d_for_its_options()
        rows: dict[str, mot_sim.metrics.Scores] = {}
        content: dict[str, dict[str, object]] = {}
        unlabelled: tuple[str, ...] = ()
        for kind in kinds:
            if self.truth is None:
                scored = score_folder(
                    self.results, self.root, self.sequences, self.rules, kind, split
                )
                evaluation, unlabelled = scored.evaluation, scored.unlabelled
            else:
                evaluation = self._against_own(self.truth, kind)
            before = "" if len(kinds) == 1 else f"{kind} "
            named = {**evaluation.sequences, "combined": evaluation.combined}
            rows |= {f"{before}{name}": scores for name, scores in named.items()}
            content[kind] = evaluation.as_dict()
        of_kinds = "" if kinds == ("Car",) else f"{', '.join(kinds)}, "
        title = f"{self.results}, {of_kinds}rules {evaluation.rules}, rates in %"
        table = score_table(rows, title=title, sums=1 if len(kinds) == 1 else 0)
        found = content[kinds[0]] if len(kinds) == 1 else {"classes": content}
        deliver(terminal, table, found, self.json, self.csv)
        say_unlabelled(terminal, unlabelled)
        return OK

    def _against_own(self, truth: Path, kind: str) -> "mot_sim.metrics.Evaluation":
        """The scores against truth of one's own."""
        from mot_sim.evaluation.own_scoring import score_against
        from tracker.errors import BadConfig

        options = ("root", "sequences", "seqmap", "frames")
        for name, value in ((option_name, getattr(self, option_name)) for option_name in options):
            if value is not None:
                raise BadConfig(f"--truth and --{name} exclude each other: your own truth or KITTI")
        return score_against(self.results, truth, self.rules, kind)

    def _require_3d_for_its_options(self) -> None:
        from tracker.errors import BadConfig

        for name, value in (("thresholds", self.thresholds), ("ego", self.ego), ("out", self.out)):
            if value is not None:
                raise BadConfig(f"--{name} {value}: only cuboids are scored by it; add --3d")

    def _in_3d(
        self,
        terminal: Terminal,
        kinds: tuple[str, ...],
        split: "mot_sim.evaluation.splits.Split",
    ) -> int:
        """Score and show the cuboids."""
        from mot_sim.evaluation.spatial_scoring import parse_criteria, score_folder_in_3d
        from tracker.errors import BadConfig

        if len(kinds) > 1 or self.rules != "trackeval":
            given = f"--classes {self.classes}" if len(kinds) > 1 else f"--rules {self.rules}"
            raise BadConfig(f"{given}: with --3d one class at a time, and no other rules")
        if self.truth is not None:
            raise BadConfig(
                f"--truth {self.truth}: boxes of your own have no cuboids; --3d needs a KITTI tree"
            )
        criteria = parse_criteria(self.thresholds or THRESHOLDS)
        scored = score_folder_in_3d(
            self.results, self.root, self.sequences, criteria, kinds[0], self.ego, split
        )
        title = f"{self.results}, {kinds[0]} in 3D"
        deliver_3d(terminal, scored, title, self.json, self.csv, self.out)
        say_unlabelled(terminal, scored.unlabelled)
        return OK


def say_unlabelled(terminal: Terminal, names: tuple[str, ...]) -> None:
    """Name the sequences that could not be scored."""
    if names:
        terminal.note(f"left out, for want of labels: {', '.join(names)}")


def require_targets(json: str | None, other: str | None) -> None:
    """BadConfig when both are to be printed, BadOutput for a file that could not be written."""
    from mot_sim.files.writing import require_writable
    from tracker.errors import BadConfig

    for target in (json, other):
        if target is not None and target != STDOUT:
            require_writable(Path(target))

    if json == STDOUT and other == STDOUT:
        raise BadConfig("two results on stdout (-) would mix: give one of them a file")


def deliver(
    terminal: Terminal,
    table: "mot_sim.tables.Table",
    content: Mapping[str, object],
    json: str | None,
    csv: str | None,
    before: Sequence["mot_sim.tables.Table"] = (),
) -> None:
    """The scores into the files that were asked for; the tables, unless stdout is taken.

    before: tables that are shown first, and are not in the CSV.
    """
    if json is not None:
        terminal.save(jsonlib.dumps(content, indent=2) + "\n", json)
    if csv is not None:
        terminal.save(table.as_csv(), csv)
    if STDOUT not in (json, csv):
        for each in (*before, table):
            terminal.show(each)


def deliver_3d(
    terminal: Terminal,
    scored: "mot_sim.evaluation.spatial_scoring.SpatialEvaluation",
    title: str,
    json: str | None,
    csv: str | None,
    out: Path | None = None,
) -> None:
    """The scores in 3D: by criterion, the errors, their stated uncertainty, by sequence.

    out: the folder that keeps the tables, and a picture of the errors, for `mot-sim report`.
    """
    from mot_sim.tables import consistency_table, criterion_table, error_table, spatial_table

    errors, rates = scored.combined.errors, f"{title}, rates in %"
    before = (
        criterion_table(scored.combined, f"{rates}, all sequences"),
        error_table(errors, f"{rates}: errors of cuboids"),
        consistency_table(errors, f"{rates}: are the stated uncertainties honest?"),
    )
    shown = [table for table in before if table is not None]
    named = {**scored.sequences, "combined": scored.combined}
    table = spatial_table(named, title=f"{rates}, by sequence", sums=1)
    deliver(terminal, table, scored.as_dict(), json, csv, shown)
    if out is not None:
        from mot_sim.cli.keeping import keep
        from mot_sim.plotting.birds_eye import birds_eye_figure, distance_figure
        from mot_sim.plotting.charts import save_figure

        places, found = errors.from_above()
        figures = (
            birds_eye_figure(places, found, title),
            distance_figure(places, found, errors.stated.radial_std, title),
        )
        for figure, name in zip(figures, ERROR_PICTURES, strict=True):
            save_figure(figure, out / name)
        keep(out, "run", title, (*shown, table), files=ERROR_PICTURES)
        names = " and ".join(ERROR_PICTURES)
        terminal.note(f"written: {names} in {out}, and result.json for mot-sim report {out}")
