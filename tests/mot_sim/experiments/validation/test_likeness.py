"""How like recorded drives a scene is."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.experiments.validation.likeness import find_reference, gap, outside
from tracker.errors import DatasetNotFound, UnknownName


def test_how_far_a_value_lies_outside_a_range() -> None:
    assert outside(3.0, 2.0, 6.0) == outside(2.0, 2.0, 6.0) == 0.0
    assert outside(1.0, 2.0, 6.0) == 0.25
    assert outside(14.0, 2.0, 6.0) == 2.0
    assert outside(5.0, 4.0, 4.0) == 0.25  # of a point: in parts of it
    assert np.isnan(outside(np.nan, 2.0, 6.0))


def test_the_gap_of_distributions_counts_every_drive_alike() -> None:
    low, high = np.zeros(10), np.ones(1000)
    assert gap([low], [low]) == 0.0
    assert gap([low], [high]) == 1.0
    assert gap([low, high], [high]) == 0.5
    assert np.isnan(gap([], [low]))


def test_unknown_references_and_missing_trees_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(UnknownName, match=r"unknown reference 'kiti'.*Did you mean 'kitti'"):
        find_reference("kiti")
    monkeypatch.delenv("MOT_SIM_KITTI_ROOT", raising=False)
    with pytest.raises(DatasetNotFound, match="set MOT_SIM_KITTI_ROOT or pass --root"):
        find_reference("kitti")
    (tmp_path / "training/calib").mkdir(parents=True)
    (tmp_path / "training/calib/0001.txt").touch()
    with pytest.raises(
        DatasetNotFound, match=r"0 sequences with labels.*0001: no NAME.txt in .*label_02"
    ):
        find_reference("kitti", tmp_path)


@pytest.mark.kitti
def test_the_given_drives_are_as_they_are_known(kitti_root: Path) -> None:
    found = find_reference("kitti", kitti_root)
    assert np.nanmedian(found.values["parked"]) == pytest.approx(0.67, abs=0.1)
    assert np.nanmedian(found.values["cars"]) == pytest.approx(3.7, abs=0.5)
    assert 0.0 < found.usual_gap["height"] < 0.4
