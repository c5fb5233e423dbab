"""A look is found again from what it made of frames."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from mot_sim.simulation.camera_looks import CameraLook, find_camera_look
from mot_sim.simulation.camera_looks.fitting import (
    FITTED_KNOBS,
    DrawnFrame,
    StatisticsRange,
    distances,
    fit_look,
    knob_of,
    with_knobs,
)
from mot_sim.simulation.camera_looks.image_statistics import mean_statistics
from tests.mot_sim.simulation.kernels.test_drawing import SMALL
from tracker.errors import BadConfig
from tracker.types import Camera

CAMERA = Camera.mounted(np.array(SMALL.K), (160, 96), 1.6)


def frames() -> list[DrawnFrame]:
    rng, found = np.random.default_rng(1), []
    for number in range(2):
        coarse = rng.integers(30, 230, (12, 20, 3)).astype(np.uint8)
        image = cv2.resize(coarse, CAMERA.image_size, interpolation=cv2.INTER_NEAREST)
        found.append(DrawnFrame(image, CAMERA, 1, number))
    return found


def test_a_fit_comes_nearer_and_keeps_what_is_not_fitted() -> None:
    target = find_camera_look("kitti")
    wanted = StatisticsRange.of([mean_statistics(each.developed(target) for each in frames())])
    begin = with_knobs(
        CameraLook(exposure=replace(target.exposure, gain=1.0), tone=target.tone),
        np.array([0.5, 70.0, 1.0, 1.0, 1.3, 1.0, 0.0, 1.5, 1.5, 0.01]),
    )
    tries: list[int] = []
    fitted = fit_look(begin, {"one": frames()}, wanted, lambda: tries.append(1))
    before, after = (np.abs(distances(wanted, frames(), look)).sum() for look in (begin, fitted))
    assert after < 0.4 * before
    assert tries
    assert fitted.exposure.gain == begin.exposure.gain
    assert fitted.file == begin.file
    for name, (least, most) in FITTED_KNOBS.items():
        assert least <= knob_of(fitted, name) <= most
    assert fit_look(begin, {"one": frames()}, wanted) == fitted


def test_ranges_go_over_the_clips() -> None:
    one, two = (mean_statistics([each.image]) for each in frames())
    found = StatisticsRange.of([one, two])
    assert found.holds("luma_std", 0.5 * (one.luma_std + two.luma_std))
    assert not found.holds("luma_std", max(one.luma_std, two.luma_std) + 1.0)
    assert not found.holds("luma_std", float("nan"))
    with pytest.raises(BadConfig, match="no photographs"):
        StatisticsRange.of([])
