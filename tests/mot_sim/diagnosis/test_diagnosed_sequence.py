"""Drives with what happens in them: of scenes exactly, of KITTI as far as its labels say."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import kitti_sequence
from mot_sim.diagnosis.context_events import EVENT_KINDS
from mot_sim.diagnosis.diagnosed_sequence import diagnosed_kitti, diagnosed_scene, vehicles
from mot_sim.diagnosis.findings import findings_of
from mot_sim.diagnosis.tasks import KittiTask
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.metrics import evaluate_sequence
from mot_sim.simulation.sensors import Profile
from tests.mot_sim.diagnosis.conftest import Crossing
from tracker.errors import DatasetNotFound
from tracker.types import Tracks


def test_a_scene_tells_of_every_kind(crossing: Crossing) -> None:
    diagnosed = diagnosed_scene(crossing.conditions, crossing.recorded, 0)
    assert diagnosed.known == EVENT_KINDS
    kinds = Counter(diagnosed.events.kinds.tolist())
    assert kinds["occlusion"]
    assert kinds["detector gap"]
    assert (np.diff(diagnosed.events.firsts) >= 0).all()
    assert (diagnosed.events.lasts >= diagnosed.events.firsts).all()


def test_a_perfect_detector_has_gaps_only_where_nothing_is_visible(crossing: Crossing) -> None:
    perfect = replace(crossing.conditions, effects=Profile())
    events = diagnosed_scene(perfect, crossing.recorded, 0).events
    truth = crossing.recorded.annotations.truth
    for row in np.flatnonzero(events.kinds == "detector gap").tolist():
        own = truth.tracks.ids == events.ids[row]
        frames = truth.tracks.frames[own]
        inside = (frames >= events.firsts[row]) & (frames <= events.lasts[row])
        assert (truth.visible[own][inside] == 0.0).all()


def test_vehicles_are_cars_and_vans() -> None:
    boxes = np.zeros((4, 4))
    kinds = np.array(["Car", "Van", "Cyclist", "DontCare"])
    ids = np.array([1, 2, 3, -1])
    assert vehicles(Tracks(ids * 0, ids, boxes, kinds=kinds)).ids.tolist() == [1, 2]
    assert len(vehicles(Tracks.empty())) == 0


@pytest.mark.kitti
def test_the_counts_on_kitti_are_the_metrics_own(kitti_root: Path) -> None:
    drive = kitti_sequence(kitti_root, "0000", "rrc", "oxts").subset(range(100, 150))
    diagnosed, output = KittiTask(drive, TrackerSpec.parse("paper")).track()
    found = findings_of(diagnosed, output)
    scores = evaluate_sequence(diagnosed.truth, output, drive.frame_count)
    assert (found.switches, found.fragments) == (scores["IDSW"], scores["Frag"])
    assert found.fragments
    kinds = {str(kind) for kind in diagnosed.events.kinds}
    assert {"occlusion", "detector gap"} <= kinds
    assert "look-alike" not in diagnosed.known


@pytest.mark.kitti
def test_without_known_motion_nobody_knows_who_turned(kitti_root: Path) -> None:
    drive = kitti_sequence(kitti_root, "0005", "rrc", "none").subset(range(20))
    assert diagnosed_kitti(drive).known == ("occlusion", "crossing", "detector gap")


@pytest.mark.kitti
def test_a_sequence_without_labels_is_refused(kitti_root: Path) -> None:
    drive = kitti_sequence(kitti_root, "0001", "rrc", "oxts")
    with pytest.raises(DatasetNotFound, match="sequence 0001: no labels"):
        diagnosed_kitti(drive)
