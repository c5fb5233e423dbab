"""Two short drives, and the guests that are shown them."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import DetectionLog, RecordedSequence
from tests.mot_sim.cli.conftest import mot_sim, tree
from tests.mot_sim.experiments.guests.programs import write_programs
from tracker.types import Camera, Detections, Tracks

__all__ = ["drives", "mot_sim", "programs", "tree", "truth_of"]

K = np.array([[700.0, 0.0, 600.0], [0.0, 700.0, 180.0], [0.0, 0.0, 1.0]])
CAMERA = Camera.mounted(K, (1242, 375), 1.65)


@pytest.fixture
def drives() -> list[RecordedSequence]:
    """`a` of 4 frames and `b` of 3 with two cars each, and in frame 1 a weak third box."""
    return [drive("a", 4), drive("b", 3)]


def drive(name: str, count: int) -> RecordedSequence:
    """Two cars that creep sideways; frame 1 has a third box with a score of 0.2."""
    rows = [
        (frame, (500.0 + 2 * frame + 200.0 * car, 190.0, 560.0 + 2 * frame + 200.0 * car, 230.0))
        for frame in range(count)
        for car in range(2)
    ]
    rows.insert(4, (1, (100.0, 180.0, 140.0, 200.0)))
    boxes = np.array([box for _, box in rows])
    scores = np.where(boxes[:, 0] < 400.0, 0.2, 0.9)
    frames = np.array([frame for frame, _ in rows])
    log = DetectionLog.of(frames, Detections.of(boxes, scores))
    return RecordedSequence(name, CAMERA, count, log, np.arange(count))


def truth_of(drive: RecordedSequence) -> Tracks:
    """The two cars as labels, ids 7 and 8."""
    strong = drive.log.detections.scores > 0.5
    boxes = drive.log.detections.boxes[strong]
    ids = np.where(boxes[:, 0] < 650.0, 7, 8)
    return Tracks(drive.log.frames[strong], ids, boxes, kinds=np.full(len(ids), "Car"))


@pytest.fixture
def programs(tmp_path: Path) -> Path:
    """A folder with the test's guests."""
    folder = tmp_path / "programs"
    folder.mkdir()
    return write_programs(folder)
