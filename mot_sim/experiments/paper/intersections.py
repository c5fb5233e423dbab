"""Table IV: do shape and pose help a simple 2D cue where cars turn?"""

from collections.abc import Iterator, Mapping

from mot_sim.experiments.paper import quoted
from mot_sim.experiments.paper.cue_sets import two_frame
from mot_sim.experiments.paper.made_rows import PairedScores
from mot_sim.experiments.paper.rendering import interval_table, score_rows
from mot_sim.experiments.paper.studies import PaperConfig, on_clips
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.tuning.cross_validation import WeightSearch, tune
from mot_sim.experiments.tuning.labelled import made_drives
from mot_sim.experiments.tuning.weighing import WEIGHT_SUM, Method, Scale
from mot_sim.tables import Table

TUNING_SEEDS = 1000  # the first of those that weights are tuned on; no row is measured there
ALONE, BOTH = "2D-2D", "2D-2D + shape and pose"
# A simple 2D cue knows nothing of the camera's motion; a better one carries its boxes by it.
CONDITIONS: dict[str, Mapping[str, Level]] = {
    "without ego-motion": {"odometry.dropouts": 1.0},
    "boxes carried by exact ego-motion": {},
}


def intersections(studies: PaperConfig) -> Iterator[Table]:
    """2D-2D with and without shape and pose, on drawn junctions and on the real clips."""
    profile = studies.profile("subcnn")
    for said, settings in CONDITIONS.items():
        costs = tuned_costs(studies, profile, settings)
        rows = two_frame({ALONE: "image_overlap", BOTH: costs})
        stand = studies.stand(studies.scenes)
        pooled = stand.run(profile, rows, "devkit2018", studies.tell, settings)
        yield interval_table(
            f"Table IV, {said}: {', '.join(studies.scenes)}, {studies.seeds} seeds each, profile "
            f"subcnn with cues, rules devkit2018; weights {costs} (seeds from {TUNING_SEEDS}); "
            + _cut(pooled),
            pooled, ("MOTA", "MOTP", "IDSW", "Frag"), against=ALONE,
        )  # fmt: skip
        ego = "none" if settings else "oxts"
        found = on_clips(studies, f"table IV, clips, {ego}", rows, ego) if studies.kitti else {}
        if found:
            ours = {f"ours: {name}": scores["devkit2018"] for name, scores in found.items()}
            yield score_rows(
                f"Table IV, {said}: rrc, real clips with images, rules devkit2018",
                quoted.COLUMNS, ours, quoted.INTERSECTIONS,
            )  # fmt: skip


def _cut(pooled: PairedScores) -> str:
    """How many switches shape and pose spare."""
    cut = pooled.cut(BOTH, ALONE, "IDSW")
    if cut is None:
        return "2D-2D alone makes no switch"
    before, after = (int(pooled.values(row, "IDSW").sum()) for row in (ALONE, BOTH))
    return f"shape and pose cut switches from {before:,} to {after:,}, by {100 * cut:.1f} %"


def tuned_costs(studies: PaperConfig, profile: str, conditions: Mapping[str, Level]) -> str:
    """The weights of 2D-2D and of shape and pose that are best on other seeds, as costs."""
    seeds = range(TUNING_SEEDS, TUNING_SEEDS + studies.tuning)
    settings = {"scene.profile": profile, "scene.frames": studies.frames, **conditions}
    folder = studies.folder / "tuning"
    studies.tell("drives to tune on", 0, len(seeds) * len(studies.scenes))
    drives = made_drives(folder, studies.scenes, seeds, settings)
    method = Method(("image_overlap", "shape_pose"), TrackerSpec("2D-2D", "paper"))
    scale = Scale.of(method, drives, "devkit2018", folder, studies.jobs)
    search = WeightSearch("MOTA", samples=4, folds=min(4, len(drives)))
    tuned = tune(scale, search, (0.8, 0.2), studies.tell)
    return "+".join(
        f"{name}={weight / WEIGHT_SUM:g}"
        for name, weight in zip(method.names, tuned.weights, strict=True)
        if weight
    )
