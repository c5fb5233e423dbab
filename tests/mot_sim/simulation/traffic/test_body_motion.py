"""How our car's body pitches and rolls: as KITTI's, not at all, or by its brakes."""

import numpy as np
import pytest
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.traffic.body_motion import BodyMotion


def tilts(
    seed: int, speeds: Float[Array, " n"], level: float = 1.0, turn: float = 0.0
) -> Float[Array, "n 2"]:
    """Degrees, of a car that drives so fast, m/s, step by step, and turns, radians a second."""
    body = BodyMotion(seed, level)
    heading = 0.1 * turn * np.arange(len(speeds))
    steps = 0.1 * speeds[:, None] * np.stack((np.cos(heading), np.sin(heading)), axis=1)
    poses = np.column_stack((np.cumsum(steps, axis=0), heading))
    return np.degrees([body.step(pose) for pose in poses])


def correlation(steps: Float[Array, " n"], lag: int) -> float:
    return float(np.corrcoef(steps[lag:], steps[:-lag])[0, 1])


def test_steps_are_as_large_and_as_alike_as_on_kitti() -> None:
    runs = [np.diff(tilts(seed, np.full(300, 8.0)), axis=0) for seed in range(8)]
    medians = np.median(np.abs(runs), axis=1)
    assert (medians > 0.01).all()
    assert (medians < 0.15).all()
    np.testing.assert_array_less(0.03, np.median(medians, axis=0))
    np.testing.assert_array_less(np.median(medians, axis=0), 0.08)
    pitch = [run[:, 0] for run in runs]
    # KITTI's drives: .39 to .71 after one frame, -.51 to -.01 after three.
    assert 0.35 < np.median([correlation(steps, 1) for steps in pitch]) < 0.75
    assert -0.6 < np.median([correlation(steps, 3) for steps in pitch]) < 0.0


def test_who_stands_comes_to_rest_and_level_0_is_level() -> None:
    stopped = np.concatenate((np.full(50, 8.0), np.zeros(80)))
    assert np.abs(np.diff(tilts(1, stopped), axis=0))[-10:].max() < 1e-3
    np.testing.assert_array_equal(tilts(1, stopped, level=0.0), 0.0)
    np.testing.assert_allclose(tilts(1, stopped, level=2.0), 2.0 * tilts(1, stopped), rtol=1e-9)


def test_the_nose_dips_when_it_brakes_and_the_body_leans_out_of_a_bend() -> None:
    steady, braking = (
        np.full(60, 8.0),
        np.concatenate((np.full(30, 8.0), 8.0 - 0.2 * np.arange(30))),
    )
    seeds = range(20)
    dip = [
        tilts(seed, braking)[40:, 0].mean() - tilts(seed, steady)[40:, 0].mean() for seed in seeds
    ]
    assert np.median(dip) == pytest.approx(-0.14, abs=0.1)  # 2 m/s2 at .07 degrees each
    lean = [(tilts(seed, steady, turn=0.4) - tilts(seed, steady))[40:, 1].mean() for seed in seeds]
    assert np.median(lean) == pytest.approx(-0.32, abs=0.05)  # to the right: it leans to the left


def test_a_leap_to_another_place_is_no_acceleration() -> None:
    body = BodyMotion(3)
    before = [body.step(np.array([0.8 * step, 0.0, 0.0])) for step in range(20)]
    after = body.step(np.array([500.0, 90.0, 1.0]))
    assert np.degrees(np.abs(after - before[-1])).max() < 1.0
