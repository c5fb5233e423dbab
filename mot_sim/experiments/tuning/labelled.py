"""Drives with labels, of KITTI or made, as cross-validation and the paper's tables use them."""

from collections.abc import Sequence as Many
from dataclasses import dataclass, replace
from pathlib import Path

from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.evaluation.scoring import choose_sequences
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings, drive_of
from mot_sim.experiments.sweep.paths import Level
from mot_sim.files.fingerprint import digest
from mot_sim.simulation.sensors import Timed
from tracker import Sequence, Tracks
from tracker.errors import BadConfig, DatasetNotFound


@dataclass(frozen=True, eq=False)
class LabelledSequence:
    """A drive: what a tracker is given, and what it is scored against."""

    name: str
    """The drive's name."""
    sequence: Sequence
    """The frames, in the order of time, without images."""
    truth: Tracks
    """The labels."""
    frame_count: int
    """Frames of the recording, including those that never arrive."""
    content: str
    """Hash of all that trackers are given and scored against."""

    @classmethod
    def of(cls, sequence: RecordedSequence | Timed, truth: Tracks, name: str) -> "LabelledSequence":
        """A drive; its images are not part of the hash, since no tracker sees them."""
        recorded = sequence.sequence if isinstance(sequence, Timed) else sequence
        times = sequence.stamps if isinstance(sequence, Timed) else recorded.frame_rate
        about = [
            recorded.camera, recorded.log, recorded.frame_indices, recorded.Ts_world_cam,
            recorded.motion_cov, times, recorded.frame_count, truth.frames, truth.ids, truth.boxes,
        ]  # fmt: skip
        return cls(name, sequence, truth, recorded.frame_count, digest(about))


def kitti_drives(
    root: Path | str | None,
    sequences: str = "given",
    detections: str = "rrc",
    ego: str = "oxts",
) -> tuple[LabelledSequence, ...]:
    """Sequences of a KITTI tree; all must have labels.

    Raises DatasetNotFound for one without labels, and as `choose_sequences` and `kitti_sequence`.
    """
    names = choose_sequences(root, sequences)
    return tuple(labelled(kitti_sequence(root, name, detections, ego)) for name in names)


def labelled(drive: KittiSequence) -> LabelledSequence:
    """A KITTI drive of cars as one of these. Raises DatasetNotFound when it has no labels."""
    drive.require_cars()
    if drive.truth is None:
        raise DatasetNotFound(
            f"sequence {drive.name}: no labels (label_02/{drive.name}.txt); choose others: "
            "--sequences given takes those that have some"
        )
    return LabelledSequence.of(replace(drive, images=None), drive.truth, drive.name)


def made_drives(
    folder: Path, scenes: Many[str], seeds: Many[int], settings: dict[str, Level]
) -> tuple[LabelledSequence, ...]:
    """Synthetic drives, a scene and seed each; truth is kept with all others, or in the folder."""
    if not scenes or not seeds:
        raise BadConfig("no drives: give at least one scene and one seed")
    found, recordings = [], Recordings.beside(folder)
    for scene in scenes:
        conditions = Conditions.of(scene, settings)
        for seed in seeds:
            drive = drive_of(conditions, recordings.truth(conditions, seed), seed)
            arriving = drive.sequence
            assert isinstance(arriving, Timed)  # `drive_of` makes no other
            found.append(LabelledSequence.of(arriving, drive.truth, f"{scene}/{seed}"))
    return tuple(found)
