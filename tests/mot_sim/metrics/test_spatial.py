"""All scores in 3D together: names, HOTA, and what TrackEval's neutral rows are in 3D."""

import json

import numpy as np
import pytest

from mot_sim.metrics.cuboid_overlap import Criterion
from mot_sim.metrics.spatial import SpatialScores, spatial_scores
from tests.mot_sim.metrics.cuboid_cases import AHEAD, scene, two_cars
from tracker.types import Tracks


def test_perfect_results_are_perfect_in_3d():
    numbers = spatial_scores(scene(two_cars()), scene(two_cars()), 5).numbers()
    assert numbers["HOTA3D"] == pytest.approx(1.0)
    for criterion in ("0.25", "0.5", "0.7", "2m"):
        assert numbers[f"MOTA3D@{criterion}"] == 1.0
        assert numbers[f"sAMOTA@{criterion}"] == pytest.approx(9 / 40)
    assert numbers["MOTP@2m"] == pytest.approx(0.0)  # metres
    assert numbers["MOTP@0.7"] == pytest.approx(1.0)


def test_hota_in_3d_is_that_of_the_3d_iou():
    # 3D IoU 3/5 in every row: matches at 12 of the 19 alphas.
    shifted = [(f, car, x, z + 1.0, yaw) for f, car, x, z, yaw in two_cars()]
    truth = scene(two_cars())
    found = spatial_scores(truth, scene(shifted).replaced(boxes=truth.boxes), 5)
    assert found.numbers()["HOTA3D"] == pytest.approx(12 / 19)
    assert found.errors.numbers()["iou_3d"] == pytest.approx(0.6)


def test_what_meets_a_neutral_label_in_the_image_is_no_false_positive_of_ours():
    rows = two_cars()
    truth = scene(rows, kinds=["Van" if row[1] else "Car" for row in rows])
    away = scene([(f, car, x, z + 10.0 * car, yaw) for f, car, x, z, yaw in rows])
    found = spatial_scores(truth, away.replaced(boxes=truth.boxes), 5)
    assert found.ab3dmot["0.5"].all_tracks.counts.CLR_FP == 5
    assert found.clear["0.5"].CLR_FP == 0
    assert found.numbers()["MOTA3D@0.5"] == 1.0
    assert found.numbers()["HOTA3D"] == pytest.approx(1.0)


def test_sequences_are_combined_as_one_data_set():
    good = spatial_scores(scene(two_cars()), scene(two_cars()), 5)
    bad = spatial_scores(scene(two_cars()), Tracks.empty(), 5)
    both = SpatialScores.combine([good, bad]).numbers()
    assert both["MOTA3D@0.5"] == pytest.approx(0.5)
    assert both["CLR_FN@0.5"] == 10
    assert both["HOTA3D"] == pytest.approx(np.sqrt(0.5))


def test_everything_is_ready_for_json():
    criteria = [Criterion("distance", 1.5)]
    scores = spatial_scores(scene(two_cars()), Tracks.empty(), 5, criteria=criteria)
    content = json.loads(json.dumps(scores.as_dict(), allow_nan=False))
    assert content["errors"]["centre_median"] is None
    assert list(content["ab3dmot"]) == ["1.5m"]
    assert len(content["errors_by_distance"]) == 5


def test_pedestrians_are_scored_by_their_class():
    rows = [(0, 0, 0.0, 10.0, AHEAD, 0.8, 1.8, 0.6), (0, 1, 5.0, 10.0)]
    truth = scene(rows, kinds=["Pedestrian", "Car"])
    found = spatial_scores(truth, truth, 1, kind="Pedestrian")
    assert found.clear["0.5"].GT_Dets == 1
    assert found.clear["0.5"].CLR_FP == 0
