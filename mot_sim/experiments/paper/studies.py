"""How much the paper's tables are measured on, and where their results are kept."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np

from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.evaluation.scoring import choose_sequences
from mot_sim.experiments.paper.clips import clips_with_images, cued
from mot_sim.experiments.paper.cue_sets import with_cues
from mot_sim.experiments.paper.made_rows import SyntheticBenchmark
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.tuning.labelled import LabelledSequence, kitti_drives, labelled
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
    sample_frames: int | None = None
    """Frames of one KITTI drive, and of one clip with images, that stand for all of them: they show
    the form of the tables, not a result. None: all frames of all."""
    tell: Progress = field(default=lambda what, done, total: None)
    """Called with what is under way, how much of it is done, and how much there is."""

    @property
    def bench(self) -> KittiBenchmark:
        """For real drives."""
        return KittiBenchmark(self.folder, self.jobs, self.tell)

    def given_drives(self, detections: str = "rrc") -> tuple[LabelledSequence, ...]:
        """The labelled drives of KITTI; of a sample, some frames of the first."""
        if self.sample_frames is None:
            return kitti_drives(self.root, detections=detections)
        first = choose_sequences(self.root, "given")[0]
        drive = kitti_sequence(self.root, first, detections, "oxts")
        return (labelled(self.sampled(drive)),)

    def sampled(self, drive: KittiSequence) -> KittiSequence:
        """The drive; of a sample, so many frames from the one with the most labelled cars on."""
        frames, truth = drive.frame_indices, drive.truth
        if self.sample_frames is None or truth is None:
            return drive
        cars = truth.frames[truth.kinds == "Car"]
        first = int(np.argmax(np.count_nonzero(cars == frames[:, None], axis=1)))
        return drive.subset(frames[first : first + self.sample_frames].tolist())

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
    found = clips_with_images(studies.root, ego=ego)
    if studies.sample_frames is not None:
        found = map(studies.sampled, islice(found, 1))
    for clip in found:
        studies.tell(f"cues of {clip.name}", 0, len(clip))
        clips.append(cued(clip, front_end))
    return dict(studies.bench.measure(what, clips, contenders)) if clips else {}
