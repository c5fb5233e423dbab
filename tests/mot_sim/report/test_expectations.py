"""Where tracks are believed to be, and expected next."""

import numpy as np

from mot_sim.datasets import DetectionLog, RecordedSequence
from mot_sim.report.expectations import expectations
from mot_sim.simulation.rig import Rig
from tests.mot_sim.report.small import drive, exact_tracks, one_track
from tracker.types import Detections, Tracks

CAMERA = Rig.kitti().camera
BOX = (600.0, 180.0, 660.0, 230.0)


def parked(frames: int = 14) -> RecordedSequence:
    """Nobody moves, and nobody knows what was detected."""
    nothing = DetectionLog(np.zeros(0, np.int64), Detections.empty())
    poses = np.tile(np.eye(4), (frames, 1, 1))
    return RecordedSequence("parked", CAMERA, frames, nothing, np.arange(frames), poses)


def test_every_box_stands_where_it_was_lifted_to_and_lies_in_its_search_area() -> None:
    tracks = one_track([BOX] * 14)
    standing = dict(expectations(parked(), tracks))
    assert not len(standing[0].expected)
    for frame in range(1, 14):
        now = standing[frame]
        assert now.now.ids.tolist() == now.expected.ids.tolist() == [3]
        x, _, z = now.now.cuboids.base[0]
        depth = CAMERA.K[1, 1] * CAMERA.height / (BOX[3] - CAMERA.K[1, 2])
        assert depth < z < depth + 4.0  # the centre lies behind the contact with the road
        assert abs(x) < 3.0
        left, top, right, bottom = now.areas[0]
        assert left < BOX[0] + 2.0 < BOX[2] < right
        assert top < BOX[1] + 2.0 < BOX[3] < bottom + 2.0
        assert (np.linalg.eigvalsh(now.now.cov[0]) > 0.0).all()


def test_a_track_without_a_box_is_expected_for_a_second_with_growing_doubt() -> None:
    tracks = one_track([BOX] * 3)
    standing = dict(expectations(parked(20), tracks))
    expected = [len(standing[frame].expected) for frame in range(20)]
    assert expected == [0] + [1] * 13 + [0] * 6  # the last time a second after its box
    widths = [float(np.ptp(standing[frame].areas[0, ::2])) for frame in range(3, 12)]
    assert np.all(np.diff(widths) > 0.0)
    assert not len(standing[5].now)


def test_a_track_that_jumps_is_expected_once() -> None:
    far = (1100.0, 180.0, 1160.0, 230.0)
    standing = dict(expectations(parked(6), one_track([BOX, BOX, far, far, far, far])))
    assert [len(standing[frame].expected) for frame in range(6)] == [0, 1, 1, 1, 1, 1]
    assert standing[4].areas[0, 0] > 900.0
    assert standing[4].now.ids.tolist() == [3]


def test_ids_are_those_of_the_tracks_whoever_they_are() -> None:
    tracks = exact_tracks(shift=1000)
    for frame, standing in expectations(drive(), tracks):
        rows = tracks.select(tracks.frames == frame)
        assert sorted(standing.now.ids.tolist()) == sorted(rows.ids.tolist())


def test_no_tracks_stand_nowhere() -> None:
    for _, standing in expectations(parked(3), Tracks.empty()):
        assert len(standing.now) == len(standing.expected) == len(standing.areas) == 0


def test_the_region_is_the_car_stretched_by_its_doubt() -> None:
    (_, first), (_, second) = expectations(parked(2), one_track([BOX, BOX]))
    grown = second.regions.size[0] - first.now.cuboids.size[0]
    np.testing.assert_allclose(grown[1], 0.0)
    along = 2.0 * np.sqrt(second.expected.cov[0, 1, 1])  # the car looks along road z
    across = 2.0 * np.sqrt(second.expected.cov[0, 0, 0])
    np.testing.assert_allclose(grown[[0, 2]], [along, across], rtol=1e-6)
