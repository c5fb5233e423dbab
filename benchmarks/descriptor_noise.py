"""Table III's order against the noise of descriptors: does the paper's order hang on theirs?

    python -m benchmarks.descriptor_noise [--seeds 16] [--profiles rrc subcnn] [--out DIR]

Drives of the intersection seen through each profile with cues, seeds from 1000, the paper's
tracker, MOTA by the rules of the devkit of 2018. A row a level of the noise: first the profile's
own, which remembers, then white noise; two more change the tracker at the profile's own noise, in
all rows but appearance alone, which has no search areas to stretch. Axes are named as in
`mot-sim sweep --list-axes`. rank-1: how often the nearest descriptor so many frames later is of
the same car. Then the mean MOTA of each row of the table, in the paper's order, and each row less
the one before it, ± half of the 95 % interval, drive by drive: above 0 all along is that order.
"""

import argparse
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.appearance_samples import Seen, matches
from benchmarks.cue_weights import by_drive, show
from mot_sim.cli.terminal import Terminal
from mot_sim.experiments.paper.cue_sets import PAPER_ROWS, two_frame, with_cues
from mot_sim.experiments.paper.intersections import TUNING_SEEDS
from mot_sim.experiments.paper.made_rows import PairedScores
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.tuning.labelled import LabelledSequence, made_drives
from mot_sim.experiments.tuning.measuring import KittiBenchmark
from mot_sim.simulation.sensors import Sightings
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from mot_sim.tables import Row, mean_column
from tracker.errors import TrackingError

SCENE = "intersection"
NOISE, SECONDS = "appearance.noise", "appearance.autocorrelation.seconds.0"
WHITE = (0.35, 0.45, 0.55, 0.7)  # of NOISE, over 0 s
CHANGES: tuple[Mapping[str, Level], ...] = ({"sigmas": 0.25}, {"tie_break": 0.5})
GAPS = (1, 10)  # frames


def seen_in(folder: Path, settings: Mapping[str, Level], seed: int) -> list[Seen]:
    """The cars that are detected in each frame, once each, with their descriptors."""
    conditions = Conditions.of(SCENE, settings)
    recorded = Recordings(folder).truth(conditions, seed)
    frames = np.arange(recorded.metadata.frames)
    true = Sightings.from_truth(recorded.annotations.truth, recorded.vehicles)
    sensed = conditions.make_detector().sense(true, seed, recorded.camera, STEP_SECONDS, frames)
    vectors, ids = sensed.log.detections.descriptor, sensed.provenance.ids
    assert vectors is not None  # `with_cues` gives every profile some
    found = []
    for frame in frames.tolist():
        rows = np.flatnonzero((sensed.log.frames == frame) & (ids >= 0))
        cars, first = np.unique(ids[rows], return_index=True)
        found.append(Seen(str(seed), frame, cars, {"made": vectors[rows[first]]}, []))
    return found


def row_of(
    bench: KittiBenchmark,
    what: str,
    drives: Sequence[LabelledSequence],
    changes: Mapping[str, Level],
) -> tuple[str, ...]:
    """MOTA of the rows of Table III, and what each has more than the one before."""
    rivals = [
        each if each.name == "appearance" else each.with_settings(changes)
        for each in two_frame(PAPER_ROWS)
    ]
    found = by_drive(bench, what, drives, rivals, "devkit2018")
    pooled = PairedScores({name: [each[name].numbers() for each in found] for name in PAPER_ROWS})
    means = [f"{100.0 * pooled.values(name, 'MOTA').mean():.2f}" for name in PAPER_ROWS]
    steps = [pooled.less(after, before, "MOTA") for before, after in pairwise(PAPER_ROWS)]
    signed = mean_column("MOTA", is_signed=True)
    return (*means, *(signed.show(*step.cells) for step in steps))


def profile_table(bench: KittiBenchmark, name: str, seeds: range, frames: int) -> None:
    """A row a level of noise, and a row a change of the tracker."""
    folder = bench.folder / "drives"
    base: dict[str, Level] = {
        "scene.profile": with_cues(name, bench.folder), "scene.frames": frames,
    }  # fmt: skip
    own = Conditions.of(SCENE, base).axes()
    levels = ((float(own[NOISE]), float(own[SECONDS])), *((noise, 0.0) for noise in WHITE))
    rows: list[Row] = []
    for number, (noise, seconds) in enumerate(levels):
        settings = base | {NOISE: noise, SECONDS: seconds}
        bench.tell(f"{name}, drives with noise {noise:g} over {seconds:g} s", 0, len(seeds))
        seen = [one for seed in seeds for one in seen_in(folder, settings, seed)]
        rank1 = [f"{100.0 * matches(seen, 'made', gap).rank1:.1f}" for gap in GAPS]
        drives = made_drives(folder, (SCENE,), seeds, settings)
        for changes in ({}, *CHANGES) if number == 0 else ({},):
            tracker = ", ".join(f"{key}={value:g}" for key, value in changes.items())
            what = " ".join((name, f"{noise:g}/{seconds:g}", tracker))
            measured = row_of(bench, what, drives, changes)
            rows.append((f"{noise:g}", f"{seconds:g}", tracker, *rank1, *measured))
    heads = (
        NOISE, SECONDS, "tracker", *(f"rank-1 % after {gap}" for gap in GAPS), *PAPER_ROWS,
        *(f"({after}) - ({before})" for before, after in pairwise(PAPER_ROWS)),
    )  # fmt: skip
    title = (
        f"MOTA, profile {name} with cues, {SCENE}, {len(seeds)} seeds from {seeds.start}, "
        f"{frames} frames, rules devkit2018"
    )
    show(title, heads, rows)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--profiles", nargs="+", default=["rrc", "subcnn"])
    parser.add_argument("--frames", type=int, default=100, help="of each drive")
    parser.add_argument("--out", type=Path, help="where results are kept")
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    place = nullcontext(str(given.out)) if given.out else TemporaryDirectory()
    with place as folder, Terminal().progress(lines=True) as tell:
        bench = KittiBenchmark(Path(folder), given.jobs, tell)
        seeds = range(TUNING_SEEDS, TUNING_SEEDS + given.seeds)
        try:
            for name in given.profiles:
                profile_table(bench, name, seeds, given.frames)
        except TrackingError as error:
            parser.error(str(error))


if __name__ == "__main__":
    main()
