"""The real clips that have images, with cues measured once for all rows of a table."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.datasets.recorded import DetectionLog
from mot_sim.evaluation.scoring import choose_sequences
from mot_sim.experiments.tuning.labelled import LabelledSequence
from tracker.front_end import FrontEnd, SequenceWithCues
from tracker.types import Detections


def clips_with_images(
    root: Path | str | None, detections: str = "rrc", ego: str = "oxts"
) -> Iterator[KittiSequence]:
    """The labelled frames with an image of every sequence, in runs without a gap."""
    for name in choose_sequences(root, "given"):
        folder = kitti_sequence(root, name, None, "none").label_path
        there = folder is not None and (folder.parent.parent / "image_02" / name).is_dir()
        if not there:
            continue
        drive = kitti_sequence(root, name, detections, ego, images=True)
        paths = getattr(drive.images, "paths", {})
        frames = sorted(frame for frame in paths if frame < drive.frame_count)
        if frames:
            yield drive.subset(frames)


def cued(clip: KittiSequence, front_end: FrontEnd) -> LabelledSequence:
    """The clip with what the front end measures as columns of its detections, without images."""
    frames, parts = [np.zeros(0, np.int64)], []
    for frame in SequenceWithCues(clip, front_end):
        frames.append(np.full(len(frame.found), frame.index))
        parts.append(frame.found)
    seen = DetectionLog(np.concatenate(frames), Detections.concatenate(parts))
    if clip.truth is None:
        raise ValueError(f"{clip.name} has no labels")  # `clips_with_images` gives no such clip
    return LabelledSequence.of(replace(clip, log=seen, images=None), clip.truth, clip.name)
