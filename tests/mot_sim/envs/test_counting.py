"""Counting frame by frame gives what counting the whole sequence gives."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.envs.counting import RunningClear, RunningCounts, counted_labels
from mot_sim.metrics import evaluate_sequence
from tracker.errors import BadTracks
from tracker.types import Tracks

FRAMES = 8


def rows(rng: np.random.Generator, most: int, is_truth: bool) -> Tracks:
    """Boxes that overlap one another a lot, with gaps, vans and regions that do not count."""
    frames, ids = np.divmod(rng.permutation(FRAMES * 6)[: rng.integers(most + 1)], 6)
    order = np.argsort(frames, kind="stable")
    frames, ids = frames[order], ids[order]
    low = np.stack((40.0 * rng.permutation(6)[ids] * rng.integers(0, 2), 10.0 * ids), axis=1)
    low += rng.uniform(-6.0, 6.0, low.shape)
    boxes = np.concatenate((low, low + (60.0, 40.0)), axis=1)
    if not is_truth:
        return Tracks(frames, rng.permutation(9)[ids], boxes, np.ones(len(ids)))
    kinds = rng.choice(["Car", "Car", "Car", "Van", "DontCare"], len(ids))
    occlusion = rng.choice([0, 1, 3], len(ids))
    return Tracks(
        frames, np.where(kinds == "DontCare", -1, ids), boxes, None, kinds, None, occlusion
    )


@given(seed=st.integers(0, 10**6))
def test_the_sums_are_those_of_the_whole_sequence(seed) -> None:
    rng = np.random.default_rng(seed)
    truth, output = rows(rng, 40, True), rows(rng, 40, False)
    running = RunningClear()
    for frame in range(FRAMES):
        parts = (part.select(part.frames == frame) for part in (truth, output))
        running.add(*parts, frame)
    whole = evaluate_sequence(truth, output, FRAMES)
    for name, number in vars(running.total).items():
        assert number == whole[name], name
    assert counted_labels(truth, FRAMES) == whole["CLR_TP"] + whole["CLR_FN"]
    if len(truth) and len(output) and not whole.clear.one_sided:
        assert pytest.approx(whole["MOTA"], abs=1e-12) == running.total.MOTA


def test_nothing_counts_nothing() -> None:
    assert RunningClear().add(Tracks.empty(), Tracks.empty(), 0) == RunningCounts()
    assert RunningCounts().MOTA == 0.0


def test_a_name_that_changes_is_a_switch() -> None:
    box = np.array([[0.0, 0.0, 60.0, 60.0]])
    running = RunningClear()
    for frame, name in enumerate((4, 4, 5, 4)):
        frames = np.array([frame])
        running.add(
            Tracks(frames, np.array([1]), box), Tracks(frames, np.array([name]), box), frame
        )
    assert running.total == RunningCounts(CLR_TP=4, IDSW=2)
    assert running.total.MOTA == 0.5


def test_one_name_twice_in_a_frame_is_refused() -> None:
    box = np.zeros((2, 4))
    twice = Tracks(np.zeros(2, int), np.ones(2, int), box)
    with pytest.raises(BadTracks, match="stands twice"):
        RunningClear().add(Tracks.empty(), twice, 0)
