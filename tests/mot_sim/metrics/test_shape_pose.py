"""The table of shape and pose: the truth itself has no error, a mean car has the prior's."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.shape_pose import against_truth, row_of
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings, drive_of
from mot_sim.metrics.cuboid_errors import cuboid_errors
from tests.mot_sim.experiments.small import BARE


def test_true_cuboids_and_shapes_put_the_keypoints_where_they_are(tmp_path: Path) -> None:
    conditions = Conditions.of("crossing", {"scene.frames": 4, **BARE})
    recorded = Recordings(tmp_path).truth(conditions, 0)
    drive, camera = drive_of(conditions, recorded, 0), recorded.camera
    output = drive.truth.select(drive.truth.kinds == "Car")
    errors = cuboid_errors(drive.truth, output, 4, drive.Ts_world_road, drive.frame_rate)
    vehicles = recorded.vehicles
    true = vehicles.coefficients[vehicles.rows(output.ids)]
    shape, pixels, shares = against_truth(errors, output, true, recorded, camera)
    assert len(errors) == len(output) > 4
    np.testing.assert_allclose(shape, 0.0, atol=1e-9)
    assert np.median(pixels) < 0.3
    nothing = against_truth(errors, output, np.full_like(true, np.nan), recorded, camera)
    assert np.isnan(nothing[0]).all()
    assert np.median(nothing[1]) > np.median(pixels)  # the mean car's keypoints
    cells = row_of(("crossing", "drawn"), 1.0, [(errors, shape, pixels, shares)])
    assert cells[:4] == ("crossing", "drawn", "noise x 1", len(output))
    assert cells[4] == pytest.approx(0.0, abs=1e-9)
