"""The doors of the online tracker, what it counts, and how it decides ties."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, Car, drive, frames_with
from tracker import Detections, Frame, Tracker
from tracker.costs import GatedPairs, ImageOverlap, Reprojection, Volume
from tracker.errors import BadConfig
from tracker.state import TrackerStatistics

BOX = [[600.0, 180.0, 650.0, 230.0]]


@pytest.mark.parametrize("preset", [Tracker.paper, Tracker.default])
@pytest.mark.parametrize("time", [0.0, 0.4])
def test_time_that_goes_backwards_is_refused_with_both_times(preset, time) -> None:
    tracker = preset(LEVEL)
    tracker.step(Frame(5, 0.5, Detections.of(BOX)))
    with pytest.raises(BadConfig, match=rf"frame 6 at {time:g} s comes after one at 0\.5 s"):
        tracker.step(Frame(6, time, Detections.of(BOX)))
    tracker.step(Frame(6, 0.6, Detections.of(BOX)))


def test_two_frames_of_the_same_time_are_allowed() -> None:
    tracker = Tracker.default(LEVEL)
    tracker.step(Frame(0, 0.0, Detections.of(BOX)))
    assert tracker.step(Frame(1, 0.0, Detections.of(BOX), np.eye(4))).ids.tolist() == [0]


@pytest.mark.parametrize("weights", [(), (0.0, 0.0), (1.0, -0.1), (float("nan"),), (float("inf"),)])
def test_weights_that_cannot_be_are_refused(weights) -> None:
    with pytest.raises(BadConfig, match=r"weights \["):
        Tracker(LEVEL, tuple((weight, Volume()) for weight in weights))


@pytest.mark.parametrize("sigmas", [-1.0, float("nan"), float("inf")])
def test_sigmas_that_cannot_be_are_refused_with_their_value(sigmas) -> None:
    with pytest.raises(BadConfig, match=f"sigmas {sigmas:g}"):
        Tracker(LEVEL, ((1.0, Volume()),), sigmas=sigmas)


def test_costs_are_computed_only_inside_the_search_areas_and_counted() -> None:
    """Three cars far apart: of the 9 pairs of a frame only 3 are compared."""
    compared = []

    class Spy:
        def __call__(self, pairing: GatedPairs) -> np.ndarray:
            costs = ImageOverlap()(pairing)
            compared.append(len(costs))
            return costs

    tracker = Tracker(LEVEL, ((1.0, Spy()),))
    for frame in drive([Car(-10.0, 20.0), Car(0.0, 20.0), Car(10.0, 20.0)], count=4).frames:
        tracker.step(frame)
    assert compared == [3, 3, 3]
    assert tracker.state.statistics == TrackerStatistics(frames=4, pairs=27, compared=9)
    assert tracker.state.statistics.skipped_share == pytest.approx(2 / 3)


def test_costs_that_were_not_measured_are_counted() -> None:
    def blind(pairing: GatedPairs) -> np.ndarray:
        return np.full(len(pairing.pairs[0]), np.nan)

    tracker = Tracker(LEVEL, ((1.0, blind), (1.0, ImageOverlap())))
    for frame in frames_with(BOX, BOX, BOX):
        assert tracker.step(frame).ids.tolist() == [0]
    assert tracker.state.statistics.unmeasured == 2


def test_nothing_compared_means_nothing_skipped() -> None:
    assert TrackerStatistics().skipped_share == 0.0


def test_equal_costs_are_decided_by_the_distance_in_the_image() -> None:
    """Both boxes lie inside both wide search areas, so that eq. 3 costs 0 for all four pairs."""
    tracker = replace(Tracker.paper(LEVEL), costs=((1.0, Reprojection()),), sigmas=6.0)
    tracker.explain = True
    boxes = [[590.0, 205.0, 620.0, 235.0], [622.0, 205.0, 652.0, 235.0]]
    first, second = frames_with(boxes, boxes[::-1])
    assert tracker.step(first).ids.tolist() == [0, 1]
    tracks = tracker.step(second)
    np.testing.assert_array_equal(tracker.explanation.parts["Reprojection"], np.zeros((2, 2)))
    assert dict(zip(tracks.boxes[:, 0], tracks.ids.tolist(), strict=True)) == {590.0: 0, 622.0: 1}


def test_an_unknown_motion_opens_the_search_areas() -> None:
    known, unknown = (
        drive([Car(-3.0, 30.0), Car(3.0, 30.0)], count=2, know_motion=know)
        for know in (True, False)
    )
    compared = []
    for seen in (known, unknown):
        tracker = Tracker.default(LEVEL)
        for frame in seen.frames:
            tracker.step(frame)
        compared.append(tracker.state.tracks.beliefs.cov[0, 1, 1])
    assert compared[1] > compared[0]


def test_yaw_cues_that_are_missing_in_some_rows_do_not_stop_a_track() -> None:
    tracker, yaw = Tracker.paper(LEVEL), np.array([np.nan])
    for index in range(3):
        detections = Detections.of(BOX, yaw=yaw)
        tracks = tracker.step(Frame(index, index / 10, detections, np.eye(4)))
        assert tracks.ids.tolist() == [0]
    assert tracker.state.tracks.beliefs.cuboids.yaw[0] == tracker.lift.yaw
