"""A drive with the events in it: of a scene, from exact truth, or of KITTI, from its labels."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.datasets import KittiSequence
from mot_sim.datasets.recorded import DetectionLog
from mot_sim.diagnosis.context_events import EVENT_KINDS, ContextEvents, EventRow
from mot_sim.diagnosis.event_finders import (
    box_crossings,
    camera_turns,
    car_turns,
    detector_gaps,
    exact_occlusions,
    headings_of,
    labelled_occlusions,
    look_alike_pairs,
)
from mot_sim.diagnosis.sources import DetectionStream
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import drive_of
from mot_sim.simulation.episodes.extra import Extra
from tracker.errors import DatasetNotFound
from tracker.types import Tracks

VEHICLES = ("Car", "Van")


@dataclass(frozen=True, eq=False)
class DiagnosedSequence:
    """What a tracker is given, what it is scored against, and the events meanwhile."""

    name: str
    """The drive's name: scene/seed, or KITTI's number."""
    stream: DetectionStream
    """What the tracker is given."""
    truth: Tracks
    """Labels of the delivered frames."""
    events: ContextEvents
    """The events in the drive."""
    known: tuple[str, ...]
    """The kinds of events that can be found in a drive like this one."""


def diagnosed_scene(conditions: Conditions, recorded: Extra, seed: int) -> DiagnosedSequence:
    """A recorded run of a scene as these conditions show it."""
    drive = drive_of(conditions, recorded, seed)
    stream = DetectionStream.of(drive.sequence)
    cars = vehicles(drive.truth)
    rig = conditions.rig.rig
    poses = rig.Ts_world_cam(recorded.traffic)
    annotated = recorded.annotations
    rows = [
        *exact_occlusions(annotated.truth, annotated.occlusions),
        *look_alike_pairs(cars, recorded.vehicles.ids, _looks(recorded)),
        *_events_in(cars, stream, headings_of(poses)),
    ]
    events = ContextEvents.of(rows, stream.frame_rate)
    return DiagnosedSequence(f"{conditions.scene}/{seed}", stream, drive.truth, events, EVENT_KINDS)


def diagnosed_kitti(drive: KittiSequence) -> DiagnosedSequence:
    """A labelled KITTI sequence. Raises DatasetNotFound for one without labels or cars."""
    truth = drive.truth
    if truth is None:
        raise DatasetNotFound(
            f"sequence {drive.name}: no labels (label_02/{drive.name}.txt); choose others: "
            "--sequences labelled takes those that have some"
        )
    stream = DetectionStream.of(replace(drive, images=None))
    poses = drive.Ts_world_cam
    headings = None if poses is None else headings_of(poses)
    rows = [*labelled_occlusions(truth), *_events_in(vehicles(truth), stream, headings)]
    known = [kind for kind in EVENT_KINDS if kind != "look-alike"]
    if headings is None:
        known = [kind for kind in known if not kind.endswith("turns")]
    if truth.occlusion is None:
        known.remove("occlusion")
    events = ContextEvents.of(rows, stream.frame_rate)
    return DiagnosedSequence(drive.name, stream, truth, events, tuple(known))


def vehicles(truth: Tracks) -> Tracks:
    """The labels of cars and vans, neutral ones too."""
    is_one = truth.ids >= 0
    if truth.kinds is not None:
        is_one = is_one & np.isin(truth.kinds, VEHICLES)
    return truth.select(is_one)


def _events_in(
    cars: Tracks, stream: DetectionStream, headings: Float[Array, " m"] | None
) -> list[EventRow]:
    """The events that boxes, detections and headings show, in every kind of drive."""
    log = DetectionLog(stream.log.frames, stream.log.detections)
    found = [*box_crossings(cars), *detector_gaps(cars, log, stream.frames)]
    if headings is not None:
        found += camera_turns(cars, headings, stream.frame_rate)
        found += car_turns(cars, headings, stream.frame_rate)
    return found


def _looks(recorded: Extra) -> Int[Array, " n"]:
    """A number for each shape and paint; cars with one number look the same."""
    cast = recorded.vehicles
    if not len(cast):
        return np.zeros(0, np.int64)
    paints = np.unique(cast.paints, return_inverse=True)[1]
    appearance = np.column_stack((np.round(cast.coefficients, 9), paints))
    return np.unique(appearance, axis=0, return_inverse=True)[1].ravel().astype(np.int64)
