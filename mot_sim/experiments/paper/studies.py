"""How much the paper's tables are measured on, and where their results are kept."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mot_sim.experiments.paper.clips import clips_with_images, cued
from mot_sim.experiments.paper.cue_sets import with_cues
from mot_sim.experiments.paper.made_rows import SyntheticBenchmark
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.tuning.measuring import KittiBenchmark, Progress
from tracker.front_end import FrontEnd

JUNCTIONS = ("intersection", "roundabout")


@dataclass(frozen=True)
class PaperConfig:
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
    def bench(self) -> KittiBenchmark:
        """For real drives."""
        return KittiBenchmark(self.folder, self.jobs, self.tell)

    def stand(self, scenes: tuple[str, ...]) -> SyntheticBenchmark:
        """For synthetic drives; all tables share what was recorded."""
        return SyntheticBenchmark(
            self.folder / "drives", scenes, self.seeds, self.frames, self.jobs
        )

    def profile(self, name: str) -> str:
        """A profile with all cues."""
        return with_cues(name, self.folder)


def on_clips(
    studies: PaperConfig, what: str, contenders: Sequence[TrackerSpec], ego: str = "oxts"
) -> dict:
    """Scores on the clips with images, cues measured there; empty without any image."""
    front_end = FrontEnd.of("all")
    clips = []
    for clip in clips_with_images(studies.root, ego=ego):
        studies.tell(f"cues of {clip.name}", 0, len(clip))
        clips.append(cued(clip, front_end))
    return dict(studies.bench.measure(what, clips, contenders)) if clips else {}
