"""A labelled drive re-enacted: its cars replayed, cast with ours, drawn, and seen by a profile.

Camera, ego-motion and scoring stay the drive's own, and so do the labels' levels and DontCare
regions; a re-enacted car is scored by its own box.

What the labels know and the replay cannot is what else hides a car: trees, walls, people, cars
without a label. So the fraction that counts is the mean of the label's and of the measured one, of
which no more counts than the upper end of the label's level.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Int, Shaped
from numpy import ndarray as Array

from mot_sim.datasets import KittiSequence
from mot_sim.files.fingerprint import code_digest, digest
from mot_sim.files.writing import whole_file
from mot_sim.simulation.cars import VehicleSampler
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.sensors import Profile, Sightings
from mot_sim.simulation.sensors.fitting.calibrate import seen_in
from mot_sim.simulation.sensors.fitting.measure import LabelledDetections
from mot_sim.simulation.traffic.kitti_replay import kitti_recording
from mot_sim.simulation.truth import annotate
from tracker.errors import BadConfig
from tracker.types import Tracks

VEHICLES = ("Car", "Van", "Truck")
HALF_A_LEVEL = 0.15  # of the visible fraction: KITTI's levels end near .8, .5 and .2
BOXES = ("boxes", "amodal_boxes", "visible_boxes")
SEEN = ("frames", "ids", *BOXES, "visible")


@dataclass(frozen=True, eq=False)
class Reenacted:
    """A drive whose cars were drawn."""

    drive: KittiSequence
    """The drive as it was, with real detections."""
    sightings: Sightings
    """What a detector could see of the re-enacted cars; a row a label, as it was."""
    truth: Tracks
    """The labels, with the boxes of the re-enacted cars."""

    def seen_by(self, profile: Profile, seed: int) -> KittiSequence:
        """The drive with made detections in place of the real ones."""
        drive = self.drive
        labelled = LabelledDetections.of(drive, self.truth)
        log = seen_in(labelled, self.sightings, profile, seed, 1.0 / drive.frame_rate)
        return replace(drive, log=log)


def reenact(drive: KittiSequence, kept: Path | None = None) -> Reenacted:
    """The labelled vehicles of a drive, cast, drawn and measured.

    The few without a pixel in the image (.1 % of KITTI's, beside the camera) stay as the label
    has them. kept: folder that keeps what was drawn. Raises BadConfig for a drive without labels,
    without motion, and for a subset.
    """
    truth = drive.truth
    if truth is None:
        raise BadConfig(f"drive {drive.name} has no labels: nothing can be re-enacted")
    labels = Sightings.from_labels(truth)
    if not len(labels):
        return Reenacted(drive, labels, truth)
    drawn = draw(drive, kept)
    mine, theirs = common(labels.frames, labels.ids, drawn["frames"], drawn["ids"])
    exact, known = drawn["visible"][theirs], labels.visible[mine]
    visible = labels.visible.copy()
    visible[mine] = 0.5 * (known + np.minimum(exact, known + HALF_A_LEVEL))
    columns = {"visible": visible}
    for name in BOXES:
        columns[name] = getattr(labels, name).copy()
        columns[name][mine] = drawn[name][theirs]
    labels = labels.replaced(**columns)
    rows, cars = common(truth.frames, truth.ids, labels.frames, labels.ids)
    boxes = truth.boxes.copy()
    boxes[rows] = labels.boxes[cars]
    return Reenacted(drive, labels, replace(truth, boxes=boxes))


def draw(drive: KittiSequence, kept: Path | None) -> dict[str, Shaped[Array, "n *k"]]:
    """Columns of the sightings of the cars as they were drawn, and the pixels seen of each.

    They are read from the folder if they are there. Raises BadConfig as `kitti_recording` does.
    """
    recording = kitti_recording(drive, VEHICLES)
    path = None
    if kept is not None:
        content = {"states": list(recording.states), "K": drive.camera.K, "code": code_digest()}
        path = kept / f"{drive.name}-{digest(content)[:16]}.npz"
        if path.is_file():
            with np.load(path, allow_pickle=False) as found:
                return dict(found)
    scene_meshes = SceneMeshes(VehicleSampler().sample(recording, 0), Rig(drive.camera))
    truth = annotate(recording.states, scene_meshes).truth
    seen = Sightings.from_truth(truth)
    columns = {"pixels": truth.pixels, **{name: getattr(seen, name) for name in SEEN}}
    if path is not None:
        with whole_file(path) as part, part.open("wb") as file:
            np.savez_compressed(file, **columns)
    return columns


def common(
    frames: Int[Array, " n"],
    ids: Int[Array, " n"],
    other_frames: Int[Array, " m"],
    other_ids: Int[Array, " m"],
) -> tuple[Int[Array, " k"], Int[Array, " k"]]:
    """The rows of both tables that are the same object in the same frame; DontCare is nobody."""
    one = np.where(ids >= 0, ids * (1 << 32) + frames, -1 - np.arange(len(ids)))
    other = other_ids * (1 << 32) + other_frames
    _, rows, others = np.intersect1d(one, other, assume_unique=True, return_indices=True)
    return rows, others
