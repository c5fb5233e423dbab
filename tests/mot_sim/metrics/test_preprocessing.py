"""Neutral labels and ignored boxes, one rule a test."""

import numpy as np
import pytest

from benchmarks.metrics.cases import tracks
from mot_sim.metrics.matching import Overlaps
from mot_sim.metrics.preprocessing import prepare_sequence, scored_rows
from tracker.errors import BadTracks
from tracker.types import Tracks

BOX = (0.0, 0.0, 40.0, 30.0)
FAR = (500.0, 0.0, 540.0, 40.0)


def left(labels: list[tuple], output: list[tuple]) -> tuple[int, int]:
    """How many labels and output boxes count."""
    overlaps: Overlaps = scored_rows(prepare_sequence(tracks(labels), tracks(output), 3))
    return len(overlaps.truth), len(overlaps.output)


@pytest.mark.parametrize(
    "label",
    [
        pytest.param((0, 1, BOX, "Van", 0, 0), id="van"),
        pytest.param((0, 1, BOX, "Car", 1, 0), id="truncated"),
        pytest.param((0, 1, BOX, "Car", 0, 3), id="unknown occlusion"),
    ],
)
def test_a_neutral_label_leaves_with_what_matches_it(label: tuple):
    assert left([label], [(0, 9, BOX)]) == (0, 0)
    assert left([label], []) == (0, 0)
    assert left([label], [(0, 9, FAR)]) == (0, 1)


@pytest.mark.parametrize("levels", [(0, 0), (0, 2), (-1, -1)])
def test_a_car_in_sight_counts(levels: tuple[int, int]):
    assert left([(0, 1, BOX, "Car", *levels)], [(0, 9, BOX)]) == (1, 1)


@pytest.mark.parametrize("kind", ["Pedestrian", "Truck", "Misc"])
def test_labels_of_other_kinds_take_no_part(kind: str):
    assert left([(0, 1, BOX, kind)], [(0, 9, BOX)]) == (0, 1)


def test_output_of_other_kinds_takes_no_part():
    assert left([(0, 1, BOX)], [(0, 9, BOX, "Pedestrian"), (0, 8, FAR, "Car")]) == (1, 1)


@pytest.mark.parametrize(("height", "counts"), [(24.0, 0), (25.0, 0), (25.1, 1)])
def test_an_unmatched_box_of_25_pixels_is_ignored(height: float, counts: int):
    assert left([], [(0, 9, (0.0, 10.0, 40.0, 10.0 + height))]) == (0, counts)


def test_a_matched_box_of_25_pixels_counts():
    low = (0.0, 0.0, 40.0, 25.0)
    assert left([(0, 1, low)], [(0, 9, low)]) == (1, 1)


@pytest.mark.parametrize(("region_left", "counts"), [(20.0, 1), (19.0, 0), (0.0, 0)])
def test_more_than_half_in_dont_care_is_ignored_exactly_half_is_not(
    region_left: float, counts: int
):
    region = (0, -1, (region_left, 0.0, 90.0, 90.0), "DontCare", -1, -1)
    assert left([region], [(0, 9, BOX)]) == (0, counts)
    assert left([region], [(1, 9, BOX)]) == (0, 1)


def test_two_dont_care_regions_do_not_add_up():
    halves = [(0.0, 0.0, 15.0, 30.0), (15.0, 0.0, 30.0, 30.0)]
    regions = [(0, -1, half, "DontCare", -1, -1) for half in halves]
    assert left(regions, [(0, 9, BOX)]) == (0, 1)


def test_a_car_in_dont_care_counts_when_it_is_matched():
    labels = [(0, 1, BOX), (0, -1, BOX, "DontCare", -1, -1)]
    assert left(labels, [(0, 9, BOX)]) == (1, 1)


def test_rows_with_negative_ids_name_no_object():
    assert left([(0, -1, BOX)], [(0, -1, FAR)]) == (0, 0)


def test_truth_without_kinds_and_levels_is_all_cars():
    bare = Tracks(np.array([0, 1]), np.array([4, 4]), np.array([BOX, BOX]))
    overlaps = scored_rows(prepare_sequence(bare, bare, 3))
    assert (len(overlaps.truth), len(overlaps.output)) == (2, 2)


def test_neutral_marks_follow_their_rows_when_frames_are_out_of_order():
    labels = [(2, 1, BOX), (0, 2, BOX, "Van"), (1, 3, BOX)]
    contest = prepare_sequence(tracks(labels), tracks([]), 3)
    assert contest.overlaps.truth.ids.tolist() == [2, 3, 1]
    assert contest.neutral.tolist() == [True, False, False]


def test_kinds_are_compared_without_case():
    assert left([(0, 1, BOX, "car")], [(0, 9, BOX, "CAR")]) == (1, 1)
    assert left([(0, 1, BOX, "VAN", 0, 0)], [(0, 9, BOX, "Car")]) == (0, 0)


@pytest.mark.parametrize("kind", ["0", "Vehicle", "bus", ""])
def test_what_is_no_class_of_kitti_is_refused(kind: str):
    with pytest.raises(BadTracks, match=r"output: kind '.*' of row 0 is no class of KITTI"):
        left([(0, 1, BOX)], [(0, 9, BOX, kind)])
    with pytest.raises(BadTracks, match=r"truth: kind '.*' of row 0 is no class of KITTI"):
        left([(0, 1, BOX, kind)], [(0, 9, BOX)])
