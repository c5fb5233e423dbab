"""The frameworks that decide later, through the commands' door, on a real drive."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import kitti_sequence
from mot_sim.evaluation.runs import Recipe, track_sequence
from mot_sim.evaluation.scoring import score_sequences
from tracker import FRAMEWORKS
from tracker.association import ASSOCIATIONS


@pytest.mark.kitti
@pytest.mark.parametrize("associate", sorted(FRAMEWORKS.keys() - ASSOCIATIONS))
def test_every_delayed_framework_tracks_a_drive_of_kitti(kitti_root: Path, associate: str) -> None:
    drive = kitti_sequence(kitti_root, "0003", "rrc", "oxts")
    tracker = Recipe(associate=associate).build(drive.camera)
    tracks, counts = track_sequence(tracker, drive)
    assert (counts.frames, counts.rows) == (len(drive), len(tracks))
    assert counts.pairs > counts.compared > 0
    assert (np.diff(tracks.frames) >= 0).all()
    combined = score_sequences([drive], {drive.name: tracks}).evaluation.combined
    assert combined["MOTA"] > 0.95
    assert combined["HOTA"] > 0.85
