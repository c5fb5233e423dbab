"""Which undetected cars are put out."""

import numpy as np
import pytest
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tests.tracker.samples import LEVEL, beliefs_at
from tracker.car_filter import project_boxes
from tracker.errors import BadConfig
from tracker.gap_rows import GapRows
from tracker.lifecycle import ActiveTracks
from tracker.types import Camera, CarEstimates


def gone(std: float = 0.2, hits: int = 30, x: float = 0.0) -> tuple[ActiveTracks, CarEstimates]:
    """A car 20 m ahead and x to the right, not detected for half a second; std of its place, m."""
    size = np.log([3.9, 1.5, 1.6])
    means = np.array([[x, 0.0, 20.0, -np.pi / 2, 5.0, *size, 0.0]])
    covs = np.diag(np.square([std, 0.1, std, 0.1, 1.0, 0.05, 0.05, 0.05, 0.1]))[None]
    boxes, _ = project_boxes(means, LEVEL)
    beliefs = beliefs_at((x, 20.0)).replaced(boxes=boxes)
    unseen, sure = np.array([0.5]), np.array([0.9])
    unknown = np.full((1, 4), np.nan), np.array([np.nan])
    tracks = ActiveTracks(np.zeros(1, int), beliefs, unseen, np.array([hits]), sure, *unknown)
    return tracks, CarEstimates(means, covs, np.ones(1))


def test_a_car_whose_place_is_known_is_put_out_and_one_that_may_be_anywhere_is_not() -> None:
    known, put_out = GapRows()(*gone(std=0.1), LEVEL)
    lost, kept_back = GapRows()(*gone(std=2.0), LEVEL)
    assert known[0] > 0.5 > lost[0]
    assert put_out.tolist() == [True]
    assert kept_back.tolist() == [False]


def test_a_car_that_leaves_the_image_is_less_likely_there() -> None:
    """Its left edge 7 px inside the image, and 4 px outside."""
    inside, _ = GapRows()(*gone(x=-15.0), LEVEL)
    leaving, _ = GapRows()(*gone(x=-15.3), LEVEL)
    assert leaving[0] < inside[0] - 0.05


def test_what_was_detected_once_is_not_put_out_however_likely() -> None:
    _, put_out = GapRows(intercept=20.0)(*gone(hits=1), LEVEL)
    assert put_out.tolist() == [False]


@pytest.mark.parametrize("threshold", [0.2, 0.99])
def test_the_threshold_decides(threshold: float) -> None:
    likely, put_out = GapRows(threshold=threshold)(*gone(), LEVEL)
    assert put_out.tolist() == [likely[0] >= threshold]
    assert 0.2 < likely[0] < 0.99


@pytest.mark.parametrize("threshold", [0.0, 1.0, float("nan")])
def test_a_threshold_that_is_no_probability_is_refused(threshold: float) -> None:
    with pytest.raises(BadConfig, match="threshold"):
        GapRows(threshold=threshold)


def test_some_of_the_tracks_are_judged_as_these_alone() -> None:
    parts = [gone(std) for std in (0.1, 2.0, 0.4)]
    tracks = ActiveTracks.concatenate([part for part, _ in parts])
    estimates = CarEstimates.concatenate([part for _, part in parts])
    rows = np.array([2, 0])
    alone = GapRows()(tracks.take(rows), estimates.take(rows), LEVEL)
    for some, whole in zip(GapRows().of_some(rows, tracks, estimates, LEVEL), alone, strict=True):
        np.testing.assert_array_equal(some, whole)


def test_gap_rows_of_ones_own_are_asked_with_some_tracks_alone() -> None:
    asked = []

    class Never(GapRows):
        """Puts nothing out."""

        def __call__(
            self, tracks: ActiveTracks, estimates: CarEstimates, camera: Camera
        ) -> tuple[Float[Array, " n"], Bool[Array, " n"]]:
            asked.append((len(tracks), len(estimates)))
            return np.zeros(len(tracks)), np.zeros(len(tracks), bool)

    tracks, estimates = gone()
    _, put_out = Never().of_some(np.array([0]), tracks, estimates, LEVEL)
    assert (put_out.tolist(), asked) == ([False], [(1, 1)])
