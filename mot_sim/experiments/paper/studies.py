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
    """On how much the paper's tables are measured, and where their results are kept."""

    folder: Path
    """Folder of all recorded drives and measured scores; a second run reads what is there."""
    root: Path | None = None
    """Root of a KITTI tree; None: the one that MOT_SIM_KITTI_ROOT names."""
    kitti: bool = True
    """Whether there is a KITTI tree; False leaves out the tables measured on it."""
    seeds: int = 50
    """Synthetic drives per scene, 1 or more; more make the intervals narrower."""
    frames: int = 100
    """Frames per synthetic drive, at 10 Hz; 1 or more."""
    scenes: tuple[str, ...] = JUNCTIONS
    """Names of the scenes of Table IV."""
    tuning: int = 4
    """Drives per scene that Table IV's weights are tuned on; their seeds are not among `seeds`."""
    jobs: int = 1
    """Processes on this machine; -1: one per core."""
    tell: Progress = field(default=lambda what, done, total: None)
    """Called with what is under way, how much of it is done, and how much there is."""

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
