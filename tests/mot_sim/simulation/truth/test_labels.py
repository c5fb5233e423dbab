"""What of the truth a KITTI label file says."""

import numpy as np
import pytest

from mot_sim.simulation.truth import labels
from mot_sim.simulation.truth.labels import MIN_VISIBLE_PIXELS, with_short_gaps
from tests.mot_sim.simulation.truth.states import state_of, truth_of
from tracker.types import Tracks


def test_small_and_far_cars_are_dont_care_and_the_others_keep_their_rows() -> None:
    truth = truth_of(state_of((20.0, 0.0, 0.0), (75.0, 8.0, 0.0), (95.0, -6.0, 0.0)))
    labelled = labels(truth)
    assert labelled.kinds is not None
    assert labelled.kinds.tolist() == ["Car", "DontCare", "DontCare"]
    assert labelled.ids.tolist() == [0, -1, -1]
    assert labelled.cuboids is not None
    assert np.isnan(labelled.cuboids.base[1:]).all()
    assert np.isfinite(labelled.cuboids.base[0]).all()
    assert labelled.occlusion is not None
    assert labelled.occlusion.tolist() == [0, -1, -1]


def test_a_far_car_that_nobody_sees_has_no_label() -> None:
    truth = truth_of(state_of((12.0, 0.0, np.pi / 2), (90.0, 0.0, 0.0), size=(4.4, 1.9, 1.8)))
    assert truth.pixels[1] == 0
    assert labels(truth).ids.tolist() == [0]


def test_a_car_that_shows_few_pixels_is_dont_care_and_stays_in_the_complete_tracks() -> None:
    truth = truth_of(state_of((12.0, 1.0, np.pi / 2), (30.0, 4.0, 0.0), size=(4.4, 1.9, 1.8)))
    assert 0 < truth.pixels[1] < MIN_VISIBLE_PIXELS < truth.amodal_pixels[1]
    assert labels(truth).ids.tolist() == [0, -1]
    assert truth.tracks.ids.tolist() == [0, 1]


def test_a_car_that_hides_and_comes_back_keeps_its_label() -> None:
    hider, away, size = (12.0, 0.0, np.pi / 2), (12.0, 9.0, np.pi / 2), (4.4, 1.9, 1.8)
    standing = (30.0, 0.0, 0.0)
    states = [
        state_of(at, standing, size=size, time=0.1 * frame)
        for frame, at in enumerate((away, hider, away))
    ]
    whole, last = truth_of(*states), truth_of(*states[:2])
    assert whole.pixels[whole.tracks.ids == 1][1] == 0
    labelled = labels(whole)
    assert labelled.occlusion is not None
    assert labelled.occlusion[labelled.ids == 1].tolist() == [0, 3, 0]
    assert labels(last).frames[labels(last).ids == 1].tolist() == [0]


@pytest.mark.parametrize(("hidden", "bridged"), [(24, True), (25, False)])
def test_gaps_are_bridged_in_one_track_alone_up_to_the_longest(hidden: int, bridged: bool) -> None:
    frames = np.tile(np.arange(hidden + 2), 2)
    ids = np.repeat([7, 8], hidden + 2)
    seen = (frames == 0) | ((frames == hidden + 1) & (ids == 7))
    tracks = Tracks(frames, ids, np.zeros((len(ids), 4)))
    kept = with_short_gaps(tracks, seen)
    assert kept[ids == 7].sum() == (hidden + 2 if bridged else 2)
    assert kept[ids == 8].sum() == 1


def test_no_truth_has_no_labels() -> None:
    assert len(labels(truth_of(state_of()))) == 0
