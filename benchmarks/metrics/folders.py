"""The folders that TrackEval reads: labels, results, and its list of sequences."""

from dataclasses import dataclass
from pathlib import Path

from benchmarks.metrics.cases import all_cases
from benchmarks.metrics.kitti_rows import write_rows
from mot_sim.datasets import read_labels, read_results
from mot_sim.datasets.kitti.places import TRAINING_FRAMES
from tracker.types import Tracks

LIST_NAME = "evaluate_tracking.seqmap.training"


@dataclass(frozen=True)
class World:
    """Sequences with labels, and the results of one or more trackers on all of them."""

    name: str
    folder: Path
    frame_counts: dict[str, int]

    @property
    def trackers(self) -> list[str]:
        """The names of the trackers."""
        return sorted(path.name for path in (self.folder / "trackers").iterdir())

    def labels(self, sequence: str) -> Path:
        """The file of labels."""
        return self.folder / "gt" / "label_02" / f"{sequence}.txt"

    def results(self, tracker: str, sequence: str) -> Path:
        """The file of a tracker's output."""
        return self.folder / "trackers" / tracker / "data" / f"{sequence}.txt"

    def rows(self, tracker: str) -> dict[str, tuple[Tracks, Tracks, int]]:
        """Labels, output and number of frames by sequence, as `evaluate` takes them.

        KITTI's are read from the files. The synthetic ones are taken as they are made: their
        inverted boxes and doubtful rows test the evaluators, and no reader lets them through.
        """
        if self.name == "synthetic":
            return {case.name: (case.truth, case.output, case.frame_count) for case in all_cases()}
        return {
            name: (read_labels(self.labels(name)), read_results(self.results(tracker, name)), count)
            for name, count in self.frame_counts.items()
        }


def synthetic_world(folder: Path) -> World:
    """The random and the edge cases, as the sequences of one tracker."""
    cases = all_cases()
    world = World("synthetic", folder, {case.name: case.frame_count for case in cases})
    world.labels("").parent.mkdir(parents=True)
    world.results("cases", "").parent.mkdir(parents=True)
    for case in cases:
        write_rows(case.truth, world.labels(case.name), score=False)
        write_rows(case.output, world.results("cases", case.name), score=True)
    write_list(world)
    return world


def kitti_world(folder: Path, root: Path, golden: Path) -> World:
    """The labelled training sequences, and the trackers that have results on all of them."""
    labels = sorted((root / "training" / "label_02").glob("*.txt"))
    counts = {label.stem: TRAINING_FRAMES[int(label.stem)] for label in labels}
    world = World("KITTI", folder, counts)
    world.labels("").parent.mkdir(parents=True)
    for label in labels:
        world.labels(label.stem).write_text(label.read_text())
    for tracker in (path for path in golden.iterdir() if path.is_dir()):
        results = [tracker / label.name for label in labels]
        if not all(result.exists() for result in results):
            continue
        world.results(tracker.name, "").parent.mkdir(parents=True)
        for result in results:
            world.results(tracker.name, result.stem).write_text(result.read_text())
    write_list(world)
    return world


def write_list(world: World) -> None:
    """TrackEval's list of sequences and their frames."""
    lines = [f"{name} empty 000000 {count:06d}\n" for name, count in world.frame_counts.items()]
    (world.folder / "gt" / LIST_NAME).write_text("".join(lines))
