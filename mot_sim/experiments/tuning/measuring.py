"""Trackers on labelled drives: each pair tracked once, scored by both sets of rules, and kept."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from mot_sim.evaluation.runs import track_sequence
from mot_sim.experiments.executor import Executor
from mot_sim.experiments.score_cache import ScoreCache
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.tuning.labelled import LabelledSequence
from mot_sim.files.fingerprint import code_digest, digest
from mot_sim.metrics import RULES, Scores, combine, evaluate_sequence

# Called with what is under way, how much of it is done, and how much there is.
Progress = Callable[[str, int, int], None]
# Scores by the tracker's name, then by the rules.
Measured = dict[str, dict[str, Scores]]


@dataclass(frozen=True)
class KittiBenchmark:
    """Measures trackers on labelled drives, and keeps their scores."""

    folder: Path
    """Folder where scores are kept, in `measured`; what is there is not measured again."""
    jobs: int = 1
    """Processes on this machine; -1: one per core."""
    tell: Progress = lambda what, done, total: None
    """Called with what is under way, how much of it is done, and how much there is."""

    def measure(
        self, what: str, drives: Sequence[LabelledSequence], contenders: Sequence[TrackerSpec]
    ) -> Measured:
        """The scores of trackers of ours on all drives together. Raises as the trackers do."""
        kept = ScoreCache(self.folder / "measured")
        keys = {
            (drive.name, each.name): digest([code_digest(), drive.content, each.description()])
            for drive in drives
            for each in contenders
        }
        found = {pair: kept.read(key) for pair, key in keys.items()}
        lacking = [
            (drive, each)
            for drive in drives
            for each in contenders
            if found[drive.name, each.name] is None
        ]
        done = len(keys) - len(lacking)
        self.tell(what, done, len(keys))
        with Executor(self.jobs).open() as pool:
            for place, scores in pool.run(_measured, lacking):
                drive, each = lacking[place]
                found[drive.name, each.name] = scores
                about = {"drive": drive.name, "tracker": each.name}
                kept.write(keys[drive.name, each.name], scores, about)
                done += 1
                self.tell(what, done, len(keys))
        return {
            each.name: {
                rules: combine([(found[drive.name, each.name] or {})[rules] for drive in drives])
                for rules in RULES
            }
            for each in contenders
        }


def _measured(task: tuple[LabelledSequence, TrackerSpec]) -> dict[str, Scores]:
    """A worker's task: the scores of a tracker on a drive, by the rules."""
    drive, contender = task
    tracker = contender.build(drive.sequence.camera)
    rows, _ = track_sequence(tracker, drive.sequence)  # type: ignore[arg-type]
    return {
        rules: evaluate_sequence(drive.truth, rows, drive.frame_count, rules) for rules in RULES
    }
