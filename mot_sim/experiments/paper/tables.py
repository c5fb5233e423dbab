"""The paper's tables, measured: I overall, III cues x detectors, IV intersections, V frameworks."""

from collections.abc import Callable, Iterator, Mapping

from mot_sim.experiments.paper import quoted
from mot_sim.experiments.paper.cue_sets import (
    ALL_CUES,
    ALL_GEOMETRIC,
    GEOMETRIC,
    PAPER_ROWS,
    SINGLE,
    in_frameworks,
    two_frame,
)
from mot_sim.experiments.paper.intersections import intersections
from mot_sim.experiments.paper.rendering import interval_table, quoted_rows, score_rows
from mot_sim.experiments.paper.studies import PaperConfig, on_clips
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.tables import Table
from tracker import FRAMEWORKS

TRACKEVAL = ("HOTA", "DetA", "AssA", "MOTA", "IDF1", "CLR_FP", "CLR_FN", "IDSW", "Frag")


def overall(studies: PaperConfig) -> Iterator[Table]:
    """Table I: the paper's rows, and ours on the given drives by both sets of rules."""
    if not studies.kitti:
        return
    drives = studies.given_drives()
    ours = (
        TrackerSpec("paper", "paper"),
        TrackerSpec("default"),
        *(
            TrackerSpec(f"default, {name}", settings={"associate": name})
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


def server(studies: PaperConfig) -> Iterator[Table]:
    """Table II: what the test server said of others; ours are files to send there."""
    del studies
    title = "Table II, test set: quoted; ours are written as files, only the server can score them"
    yield quoted_rows(title, quoted.SERVER_COLUMNS, quoted.SERVER)


def ablation(studies: PaperConfig) -> Iterator[Table]:
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


def _real_ablation(studies: PaperConfig) -> Iterator[Table]:
    """Of KITTI: rows without images on all given drives, all rows where there are images."""
    for detector in ("rrc", "pointrcnn"):
        drives = studies.given_drives(detector)
        found = studies.bench.measure(f"table III, {detector}", drives, two_frame(GEOMETRIC))
        yield score_rows(
            f"Table III, {detector}, given drives, rows without images, rules devkit2018",
            quoted.COLUMNS,
            {f"ours: {name}": scores["devkit2018"] for name, scores in found.items()},
            quoted.ABLATION if detector == "rrc" else {},
        )
    found = on_clips(studies, "table III, clips", two_frame({**PAPER_ROWS, **GEOMETRIC}))
    if found:
        yield score_rows(
            "Table III, rrc, real clips with images, all rows, rules devkit2018",
            quoted.COLUMNS,
            {name: scores["devkit2018"] for name, scores in found.items()},
        )


def frameworks(studies: PaperConfig) -> Iterator[Table]:
    """Table V: the same costs in every framework."""
    for detector in ("rrc", "pointrcnn") if studies.kitti else ():
        drives = studies.given_drives(detector)
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


TABLES: dict[str, Callable[[PaperConfig], Iterator[Table]]] = {
    "I": overall,
    "II": server,
    "III": ablation,
    "IV": intersections,
    "V": frameworks,
}
