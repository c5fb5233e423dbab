"""The formats of the detectors that a KITTI tree may hold."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets.detection_files import read_detections
from mot_sim.datasets.kitti import DETECTORS
from tests.mot_sim.datasets.conftest import write

ROWS = {
    "rrc": "1,10,20,30,40,0.5\r\n",
    "permatrack": "1,10.0,20.0,30.0,40.0,0.5\n",
    "degraded": "1,10,20,30,40,0.5\n",
    "simulated": "1,10,20,30,40,0.5\n",
    "exact": "1,10,20,30,40,0.5\n",
    "pointrcnn": (
        "1,2,10,20,30,40,0.5,1.6,1.7,4.2,-0.9,1.7,34.6,-1.5,-1.5\n"
        "1,1,11,20,30,40,0.5,1.6,1.7,4.2,-0.9,1.7,34.6,-1.5,-1.5\n"
        "1,2,10,20,10,40,0.5,1.6,1.7,4.2,-0.9,1.7,34.6,-1.5,-1.5\n"
    ),
    "rrc_pedestrian": "1,10,20,30,40,0.5\n",
    "pointrcnn_pedestrian": (
        "1,2,11,20,30,40,0.5,1.6,1.7,4.2,-0.9,1.7,34.6,-1.5,-1.5\n"
        "1,1,10,20,30,40,0.5,1.7,0.6,0.7,-0.9,1.7,34.6,-1.5,-1.5\n"
    ),
    "regionlets": (
        "1 -1 Cyclist -1 -1 -10 11 20 30 40 -1 -1 -1 -1000 -1000 -1000 -10 -2.3\n"
        "1 -1 Car -1 -1 -10 10 20 30 40 -1 -1 -1 -1000 -1000 -1000 -10 0.5\n"
    ),
    "kitti": "1 -1 Car -1 -1 -10 10 20 30 40 -1 -1 -1 -1000 -1000 -1000 -10 0.5\n",
    "motchallenge": "2,-1,10,20,20,20,0.5,-1,-1,-1\n",
}


@pytest.mark.parametrize("name", sorted(DETECTORS))
def test_every_format_gives_the_one_car(name: str, tmp_path: Path) -> None:
    path = write(tmp_path / "0000.txt", ROWS[name])
    log = read_detections(path, DETECTORS[name], (100, 50), 2)
    assert log.frames.tolist() == [1]
    assert log.at(1).boxes.tolist() == [[10, 20, 30, 40]]
    tracked = DETECTORS[name].tracked
    kinds = log.at(1).kinds
    assert tracked == ("Car",) if kinds is None else tuple(kinds) == tracked
    score_map = DETECTORS[name].score_map
    raw = np.array([0.5])
    expected = raw if score_map is None else score_map(raw)
    assert log.at(1).scores.tolist() == expected.tolist()


def test_scores_that_are_no_probabilities_are_said_aloud(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = write(tmp_path / "0000.txt", "1 -1 Car -1 -1 -10 10 20 30 40 -1 -1 -1 -1 -1 -1 -1 7\n")
    read_detections(path, DETECTORS["regionlets"], (100, 50), 2)
    assert "scores from 7 to 7 are no probabilities" in caplog.text
    assert "--score-map" in caplog.text


@pytest.mark.parametrize("name", sorted(DETECTORS))
def test_every_format_reads_an_empty_file(name: str, tmp_path: Path) -> None:
    log = read_detections(write(tmp_path / "0000.txt", ""), DETECTORS[name], (100, 50), 2)
    assert log.at(0).boxes.shape == (0, 4)
