"""Opens what a user names: a recorded episode, a KITTI sequence or a scene, and its tracks."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from mot_sim.datasets import (
    ImageFolder,
    KittiSequence,
    RecordedSequence,
    available_sequences,
    kitti_sequence,
    read_results,
)
from mot_sim.evaluation.run_folder import root_of_run
from mot_sim.evaluation.runs import Recipe, result_frame, track_sequence
from mot_sim.files.text import what_is_there
from mot_sim.metrics.matching import same_frame_pairs
from mot_sim.simulation.episode import SimulatedDrive, record
from mot_sim.simulation.episodes import EpisodeFiles, read_episode, stored_episodes
from mot_sim.simulation.registry import SCENE_NAMES, find_scene
from mot_sim.simulation.scene import Knob
from tracker.errors import BadConfig, BadTracks, DatasetNotFound, UnknownName
from tracker.geometry import box_iou
from tracker.types import Tracks

log = logging.getLogger(__name__)

SIMULATED = "simulated"
# On six KITTI drives .96 to .99 of the tracks' boxes overlap a detection of their own drive, and
# at most .41 overlap one of another drive.
MIN_CHECKED_BOXES = 20
MIN_DETECTION_IOU = 0.3
MIN_DETECTED_SHARE = 0.6


@dataclass(frozen=True)
class DriveRequest:
    """Which drive a user asks for."""

    episode: str
    """A folder of `mot-sim record`, a KITTI root, or the name of a scene."""
    sequence: str | None = None
    """Name of the sequence in a folder that holds several; None: it holds one. Not for scenes."""
    detections: str | None = None
    """A detector of the tree; None: RRC of a KITTI tree, the simulated ones of a recorded one. Not
    for scenes."""
    ego: str = "oxts"
    """Source of the camera's motion in a KITTI tree."""
    seed: int = 0
    """Seed of a scene's run."""
    knobs: dict[str, Knob] = field(default_factory=dict)
    """Knobs of a scene by name; empty for a folder."""
    end: int | None = None
    """Frames from this index on are not needed; None: all are."""

    def open(self) -> RecordedSequence:
        """The drive, with images where there are any.

        Raises DatasetNotFound and UnknownName for what is not there, BadConfig for options that
        do not belong to it.
        """
        folder = Path(self.episode).expanduser()
        if folder.is_dir():
            if self.knobs:
                raise BadConfig(f"--knobs belong to a scene; {folder} is recorded already")
            stored = stored_episodes(folder)
            return self._stored(folder, stored) if stored else self._kitti(folder)
        if self.episode in SCENE_NAMES:
            return self._scene()
        if len(folder.parts) > 1 or folder.exists():
            there = what_is_there(folder, "no episode")
            raise DatasetNotFound(
                f"{folder}: {there}; give one of mot-sim record, a KITTI root, or a scene"
            )
        raise UnknownName.of("folder or scene", self.episode, SCENE_NAMES.names())

    def _scene(self) -> RecordedSequence:
        """A scene, run on the way; images are drawn when they are asked for."""
        for option, value in (("sequence", self.sequence), ("detections", self.detections)):
            if value is not None:
                raise BadConfig(
                    f"--{option} {value}: {self.episode} is a scene, which has one run a --seed, "
                    "and its own detections"
                )
        scene = find_scene(self.episode, **self.knobs)
        if self.end is not None and self.end < scene.frame_count:
            scene = replace(scene, frame_count=max(self.end, 1))
        return record(scene, self.seed, renderer="raster")

    def _stored(self, root: Path, stored: list[str]) -> RecordedSequence:
        """A recorded episode with its exact truth."""
        name = self._choose(root, stored)
        has_images = ImageFolder.find(EpisodeFiles(root, name).pictures("images")) is not None
        episode = read_episode(root, name, images=has_images)
        if self.detections in (None, SIMULATED):
            return episode
        return replace(episode, log=kitti_sequence(root, name, self.detections).log)

    def _kitti(self, root: Path) -> RecordedSequence:
        """A sequence of a KITTI tree."""
        name = self._choose(root, available_sequences(root))
        images = ImageFolder.find(root / "training" / "image_02" / name) is not None
        return kitti_sequence(root, name, self.detections or "rrc", self.ego, images)

    def _choose(self, root: Path, there: list[str]) -> str:
        if not there:
            raise DatasetNotFound(
                f"{root}: neither episodes of mot-sim record nor KITTI's training/calib in it"
            )
        if self.sequence is None:
            if len(there) > 1:
                raise BadConfig(f"{root} holds {', '.join(there)}: choose with --sequence")
            return there[0]
        if self.sequence not in there:
            raise UnknownName.of("sequence", self.sequence, there)
        return self.sequence


def track_drive(
    drive: RecordedSequence,
    recipe: Recipe,
    end: int | None = None,
    progress: Callable[[], None] | None = None,
) -> Tracks:
    """The tracks of a drive's frames before `end`. progress: called after every frame."""
    images = None if recipe.front_end is None else drive.images
    wanted = [index for index in drive.frame_indices.tolist() if end is None or index < end]
    short = replace(drive, images=images).subset(wanted)
    advance = None if progress is None else lambda *_: progress()
    built = recipe.build(drive.camera)
    return track_sequence(built, short, advance, recipe.front_end)[0]


def truth_of(drive: RecordedSequence) -> Tracks | None:
    """The labels of a drive, if it has any."""
    return drive.truth if isinstance(drive, SimulatedDrive | KittiSequence) else None


def open_tracks(path: Path, drive: RecordedSequence) -> Tracks:
    """The tracks of a drive from a run's folder, or from one file of results.

    Raises DatasetNotFound where there are none, BadFile for damaged ones and for frames beyond
    the drive, BadTracks for tracks that must be of another drive.
    """
    file = path
    if path.is_dir():
        file = path / f"{drive.name}.txt"
        if not file.is_file():
            there = ", ".join(sorted(each.stem for each in path.glob("*.txt"))) or "none"
            raise DatasetNotFound(f"{file}: no tracks of '{drive.name}'; tracks there: {there}")
    elif not path.is_file():
        raise DatasetNotFound(f"{path}: no such file; give a run's folder or one SSSS.txt")
    if file.stem.isdecimal() and drive.name.isdecimal() and file.stem != drive.name:
        raise BadTracks(
            f"{file}: tracks of '{file.stem}', but '{drive.name}' is shown; give --sequence "
            f"{file.stem}, or other tracks"
        )
    _warn_of_another_root(file.parent, drive)
    tracks = read_results(file, result_frame(drive), drive.frame_count)
    require_in_view(tracks, drive, str(file))
    require_detected(tracks, drive, str(file))
    return tracks


def require_in_view(tracks: Tracks, drive: RecordedSequence, where: str) -> None:
    """Raise BadTracks for a box wholly outside the image: it is of another camera."""
    width, height = drive.camera.image_size
    low, high = tracks.boxes[:, :2], tracks.boxes[:, 2:]
    outside = (low > (width, height)).any(axis=1) | (high < 0.0).any(axis=1)
    if outside.any():
        row = int(np.flatnonzero(outside)[0])
        raise BadTracks(
            f"{where}: box {np.round(tracks.boxes[row], 1).tolist()} of id {tracks.ids[row]} in "
            f"frame {tracks.frames[row]} lies outside the image of {width} x {height} pixels: "
            f"these are tracks of another drive than '{drive.name}'"
        )


def require_detected(tracks: Tracks, drive: RecordedSequence, where: str) -> None:
    """Raise BadTracks if almost no box lies on a detection: the tracks are of another drive."""
    rows, columns = same_frame_pairs(tracks.frames, drive.log.frames)
    if len(tracks) < MIN_CHECKED_BOXES or not len(drive.log.frames):
        return
    overlap = box_iou(tracks.boxes[rows], drive.log.detections.boxes[columns])
    share = len(np.unique(rows[overlap >= MIN_DETECTION_IOU])) / len(tracks)
    if share < MIN_DETECTED_SHARE:
        raise BadTracks(
            f"{where}: {100 * share:.0f} % of its {len(tracks)} boxes lie on a detection of "
            f"'{drive.name}': these are tracks of another drive, or of other detections; give "
            "their --sequence, --seed or --detections"
        )


def _warn_of_another_root(folder: Path, drive: RecordedSequence) -> None:
    """Warn if the run was made from another tree, with other drives of the same names."""
    image = None
    if isinstance(drive.images, ImageFolder):
        image = drive.images.paths[min(drive.images.paths)]
    made_of = root_of_run(folder)
    if made_of is None or image is None:
        return
    if not image.resolve().is_relative_to(made_of):
        log.warning("%s was made from %s, which is not what is shown", folder, made_of)
