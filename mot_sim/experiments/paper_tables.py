"""The paper's tables, measured: I overall, III cues x detectors, IV intersections, V frameworks."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mot_sim.experiments import quoted
from mot_sim.experiments.clips import clips_with_images, cued
from mot_sim.experiments.contenders import Contender
from mot_sim.experiments.cross_validation import Search, tune
from mot_sim.experiments.cue_sets import (
    ALL_CUES,
    ALL_GEOMETRIC,
    GEOMETRIC,
    PAPER_ROWS,
    SINGLE,
    in_frameworks,
    two_frame,
    with_cues,
)
from mot_sim.experiments.labelled import kitti_drives, made_drives
from mot_sim.experiments.made_rows import Pooled, Stand
from mot_sim.experiments.measuring import Bench, Progress
from mot_sim.experiments.rendering import interval_table, quoted_rows, score_rows
from mot_sim.experiments.weighing import WHOLE, Method, Scale
from mot_sim.report.grid import Table
from tracker import FRAMEWORKS
from tracker.front_end import FrontEnd

JUNCTIONS = ("intersection", "roundabout", "t_junction")
TUNING_SEEDS = 1000  # the first of those that weights are tuned on; no row is measured there
TRACKEVAL = ("HOTA", "DetA", "AssA", "MOTA", "IDF1", "CLR_FP", "CLR_FN", "IDSW", "Frag")


@dataclass(frozen=True)
class Studies:
    """Where the tables' results are kept, and on how much they are measured.

    root: of a KITTI tree; None: the environment's. kitti: whether there is one. seeds: synthetic
    drives of each scene. scenes: of Table IV. tuning: seeds of each that weights are tuned on.
    """

    folder: Path
    root: Path | None = None
    kitti: bool = True
    seeds: int = 50
    frames: int = 100
    scenes: tuple[str, ...] = JUNCTIONS
    tuning: int = 4
    jobs: int = 1
    tell: Progress = field(default=lambda what, done, total: None)

    @property
    def bench(self) -> Bench:
        """For real drives."""
        return Bench(self.folder, self.jobs, self.tell)

    def stand(self, scenes: tuple[str, ...]) -> Stand:
        """For synthetic drives; all tables share what was recorded."""
        return Stand(self.folder / "drives", scenes, self.seeds, self.frames, self.jobs)

    def profile(self, name: str) -> str:
        """A profile with all cues."""
        return with_cues(name, self.folder)


def overall(studies: Studies) -> Iterator[Table]:
    """Table I: the paper's rows, and ours on the given drives by both sets of rules."""
    if not studies.kitti:
        return
    drives = kitti_drives(studies.root)
    ours = (
        Contender("paper", "paper"),
        Contender("default"),
        *(
            Contender(f"default, {name}", settings={"associate": name})
            for name in ("window", "network_flow")
        ),
    )
    found = studies.bench.measure("table I", drives, ours)
    where = f"{len(drives)} given drives, RRC, OXTS"
    yield score_rows(
        f"Table I, rules devkit2018; ours on {where}",
        quoted.COLUMNS,
        {f"ours: {name}": scores["devkit2018"] for name, scores in found.items()},
        quoted.OVERALL,
    )
    yield score_rows(
        f"Table I, rules TrackEval; {where}",
        TRACKEVAL,
        {f"ours: {name}": scores["trackeval"] for name, scores in found.items()},
    )


def server(studies: Studies) -> Iterator[Table]:
    """Table II: what the test server said of others; ours are files to send there."""
    del studies
    title = "Table II, test set: quoted; ours are written as files, only the server can score them"
    yield quoted_rows(title, quoted.SERVER_COLUMNS, quoted.SERVER)


def ablation(studies: Studies) -> Iterator[Table]:
    """Table III: cues x detectors, by MOTA of the devkit of 2018."""
    if studies.kitti:
        yield from _real_ablation(studies)
    for profile in ("rrc", "subcnn"):
        pooled = studies.stand(("intersection",)).run(
            studies.profile(profile), two_frame(PAPER_ROWS), "devkit2018", studies.tell
        )
        yield interval_table(
            f"Table III, synthetic intersection, profile {profile} with cues, {studies.seeds} "
            "seeds, rules devkit2018",
            pooled, ("MOTA", "MOTP", "CLR_Re", "CLR_Pr", "IDSW", "Frag"), against="all",
        )  # fmt: skip


def _real_ablation(studies: Studies) -> Iterator[Table]:
    """Of KITTI: rows without images on all given drives, all rows where there are images."""
    for detector in ("rrc", "pointrcnn"):
        drives = kitti_drives(studies.root, detections=detector)
        found = studies.bench.measure(f"table III, {detector}", drives, two_frame(GEOMETRIC))
        yield score_rows(
            f"Table III, {detector}, given drives, rows without images, rules devkit2018",
            quoted.COLUMNS,
            {f"ours: {name}": scores["devkit2018"] for name, scores in found.items()},
            quoted.ABLATION if detector == "rrc" else {},
        )
    found = _on_clips(studies, "table III, clips", two_frame({**PAPER_ROWS, **GEOMETRIC}))
    if found:
        yield score_rows(
            "Table III, rrc, real clips with images, all rows, rules devkit2018",
            quoted.COLUMNS,
            {name: scores["devkit2018"] for name, scores in found.items()},
        )


def _on_clips(studies: Studies, what: str, contenders: Sequence[Contender]) -> dict:
    """Scores on the clips with images, cues measured there; empty without any image."""
    front_end = FrontEnd.of("all")
    clips = []
    for clip in clips_with_images(studies.root):
        studies.tell(f"cues of {clip.name}", 0, len(clip))
        clips.append(cued(clip, front_end))
    return dict(studies.bench.measure(what, clips, contenders)) if clips else {}


def intersections(studies: Studies) -> Iterator[Table]:
    """Table IV: 2D-2D with and without shape and pose, where cars turn."""
    profile = studies.profile("subcnn")
    costs = tuned_costs(studies, profile)
    rows = two_frame({"2D-2D": "image_overlap", "2D-2D + shape and pose": costs})
    pooled = studies.stand(studies.scenes).run(profile, rows, "devkit2018", studies.tell)
    yield interval_table(
        f"Table IV, {', '.join(studies.scenes)}, {studies.seeds} seeds each, profile subcnn with "
        f"cues, rules devkit2018; weights {costs} (seeds from {TUNING_SEEDS}); "
        + _cut(pooled),
        pooled, ("MOTA", "MOTP", "IDSW", "Frag"), against="2D-2D",
    )  # fmt: skip
    found = _on_clips(studies, "table IV, clips", rows) if studies.kitti else {}
    if found:
        ours = {f"ours: {name}": scores["devkit2018"] for name, scores in found.items()}
        yield score_rows(
            "Table IV, rrc, real clips with images, rules devkit2018",
            quoted.COLUMNS, ours, quoted.INTERSECTIONS,
        )  # fmt: skip


def _cut(pooled: Pooled) -> str:
    """How many switches shape and pose spare."""
    with_them, without = "2D-2D + shape and pose", "2D-2D"
    cut = pooled.cut(with_them, without, "IDSW")
    if cut is None:
        return "2D-2D alone makes no switch"
    before, after = (int(pooled.values(row, "IDSW").sum()) for row in (without, with_them))
    return f"shape and pose cut switches from {before:,} to {after:,}, by {100 * cut:.1f} %"


def tuned_costs(studies: Studies, profile: str) -> str:
    """The weights of 2D-2D and of shape and pose that are best on other seeds, as costs."""
    seeds = range(TUNING_SEEDS, TUNING_SEEDS + studies.tuning)
    settings: dict[str, float | int | str | bool] = {
        "scene.profile": profile, "scene.frames": studies.frames,
    }  # fmt: skip
    folder = studies.folder / "tuning"
    studies.tell("drives to tune on", 0, len(seeds) * len(studies.scenes))
    drives = made_drives(folder, studies.scenes, seeds, settings)
    method = Method(("image_overlap", "shape_pose"), Contender("2D-2D", "paper"))
    scale = Scale.of(method, drives, "devkit2018", folder, studies.jobs)
    search = Search("MOTA", samples=4, folds=min(4, len(drives)))
    tuned = tune(scale, search, (0.8, 0.2), studies.tell)
    return "+".join(
        f"{name}={weight / WHOLE:g}"
        for name, weight in zip(method.names, tuned.weights, strict=True)
        if weight
    )


def frameworks(studies: Studies) -> Iterator[Table]:
    """Table V: the same costs in every framework."""
    for detector in ("rrc", "pointrcnn") if studies.kitti else ():
        drives = kitti_drives(studies.root, detections=detector)
        rows = in_frameworks({**SINGLE, "all": ALL_GEOMETRIC})
        found = studies.bench.measure(f"table V, {detector}", drives, rows)
        yield score_rows(
            f"Table V, {detector}, given drives, rules TrackEval; all: {ALL_GEOMETRIC}; "
            + verdict({name: scores["trackeval"]["HOTA"] for name, scores in found.items()}),
            TRACKEVAL,
            {name: scores["trackeval"] for name, scores in found.items()},
        )
    singles = {**SINGLE, "appearance": "appearance", "shape and pose": "shape_pose"}
    pooled = studies.stand(("intersection",)).run(
        studies.profile("rrc"), in_frameworks({**singles, "all": ALL_CUES}), "trackeval",
        studies.tell,
    )  # fmt: skip
    means = {name: float(pooled.values(name, "HOTA").mean()) for name in pooled.rows}
    yield interval_table(
        f"Table V, synthetic intersection, profile rrc with cues, {studies.seeds} seeds, rules "
        f"TrackEval; all: {ALL_CUES}; {verdict(means)}",
        pooled, ("HOTA", "AssA", "MOTA", "IDSW"),
    )  # fmt: skip


def verdict(values: Mapping[str, float]) -> str:
    """In which frameworks all cues have more than every single one, by names COSTS, FRAMEWORK."""
    wins: list[str] = []
    losses: list[str] = []
    for framework in FRAMEWORKS:
        mine = {
            name.partition(",")[0]: value
            for name, value in values.items()
            if name.endswith(f", {framework}")
        }
        best = max((value, name) for name, value in mine.items() if name != "all")
        (wins if mine["all"] > best[0] else losses).append(f"{framework} ({best[1]})")
    said = f"all beats every single cue in {len(wins)} of {len(FRAMEWORKS)} frameworks"
    return f"{said}; not in {', '.join(losses)}" if losses else said


TABLES: dict[str, Callable[[Studies], Iterator[Table]]] = {
    "I": overall,
    "II": server,
    "III": ablation,
    "IV": intersections,
    "V": frameworks,
}
