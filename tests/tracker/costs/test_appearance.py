"""Eq. 5: how far apart two descriptors are."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tracker.samples import LEVEL, beliefs_at, pairing_of
from tracker import Detections, Frame, Tracker
from tracker.beliefs import Beliefs
from tracker.costs import Appearance, ImageOverlap, weighted_sum
from tracker.errors import BadConfig, BadDetections, MissingCue
from tracker.types.embedding import Embedding


def looking(*descriptors: list[float]) -> Beliefs:
    """Cars 20 m ahead, side by side, with these descriptors."""
    places = [(2.0 * number, 20.0) for number in range(len(descriptors))]
    return replace(beliefs_at(*places, std=4.0), embedding=Embedding(np.array(descriptors)))


def test_a_hand_computed_case() -> None:
    """(3, 4) against (3, 5.5): 2.25 squared units, eta 0.2: 1 - exp(-0.45)."""
    cost = Appearance(0.2)(pairing_of(looking([3.0, 4.0]), looking([3.0, 5.5]))).item()
    assert cost == pytest.approx(1.0 - np.exp(-0.45))


def test_at_distance_one_a_pair_costs_a_half() -> None:
    assert Appearance()(pairing_of(looking([0.0]), looking([1.0]))).item() == pytest.approx(0.5)
    assert Appearance()(pairing_of(looking([2.0]), looking([2.0]))).item() == 0.0
    assert Appearance()(pairing_of(looking([0.0]), looking([1e9]))).item() == 1.0


def test_a_row_without_a_descriptor_gives_no_cue_and_the_other_weights_renormalise() -> None:
    pairing = pairing_of(looking([0.0], [1.0]), looking([0.0], [np.nan]))
    columns = pairing.pairs[1]
    costs = Appearance()(pairing)
    np.testing.assert_array_equal(np.isnan(costs), columns == 1)
    mixed = weighted_sum(pairing, ((0.5, Appearance()), (0.5, ImageOverlap())))
    np.testing.assert_allclose(mixed.total[columns == 1], ImageOverlap()(pairing)[columns == 1])
    assert mixed.unmeasured == (columns == 1).sum() > 0


@pytest.mark.parametrize("whose", ["tracks", "detections"])
def test_a_whole_column_that_is_missing_is_an_error_with_its_cure(whose: str) -> None:
    with_, without = looking([0.0]), replace(looking([0.0]), embedding=None)
    pair = (without, with_) if whose == "tracks" else (with_, without)
    with pytest.raises(MissingCue, match=rf"these {whose} do not have.*--cues"):
        Appearance()(pairing_of(*pair))


def test_descriptors_of_two_kinds_are_refused() -> None:
    with pytest.raises(BadDetections, match="of 1 numbers before and of 2 now"):
        Appearance()(pairing_of(looking([0.0]), looking([0.0, 1.0])))


@pytest.mark.parametrize("eta", [0.0, -1.0, np.inf, np.nan])
def test_eta_must_be_a_number_above_0(eta: float) -> None:
    with pytest.raises(BadConfig, match="above 0"):
        Appearance(eta)


def test_two_cars_that_change_places_are_told_apart_through_a_gap() -> None:
    boxes = np.array([[600.0, 165.0, 660.0, 245.0], [650.0, 165.0, 710.0, 245.0]])
    red, blue = [1.0, 0.0], [0.0, 3.0]
    shown = [[red, blue], [[np.nan] * 2] * 2, None, [blue, red]]
    tracker = replace(Tracker.default(LEVEL), costs=((0.9, Appearance()), (0.1, ImageOverlap(0.1))))
    found = []
    for index, looks in enumerate(shown):
        seen = Detections.empty()
        if looks is not None:
            seen = Detections(boxes, np.full(2, 0.9), descriptor=np.array(looks))
        frame = Frame(index, 0.1 * index, seen, np.eye(4) if index else None)
        tracks = tracker.step(frame)
        found.append(tracks.ids[np.argsort(tracks.boxes[:, 0])].tolist())
    assert found == [[0, 1], [0, 1], [], [1, 0]]
