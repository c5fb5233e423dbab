"""CLEAR of many drives at once is CLEAR of each, whatever frame each of them is at."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.envs.running_clears import LabelledFrames, RunningClears
from mot_sim.envs.wrappers import RunningClear
from tests.mot_sim.envs.test_wrappers import CLEAR_FRAMES, random_rows
from tracker.types import Tracks

DRIVES, FRAMES = 4, CLEAR_FRAMES


def one_box(name: int, frame: int = 0) -> Tracks:
    """One row of 60 x 60 pixels."""
    box = np.array([[0.0, 0.0, 60.0, 60.0]])
    return Tracks(np.array([frame]), np.array([name]), box, np.ones(1))


def counts_of(running: RunningClears, drive: int) -> dict[str, int]:
    """The counts of one drive, by name."""
    return {
        name: int(getattr(running, name)[drive])
        for name in ("CLR_TP", "CLR_FP", "CLR_FN", "IDSW")
    }  # fmt: skip


@given(seed=st.integers(0, 10**6))
def test_every_drive_counts_as_it_does_alone(seed) -> None:
    """Drives stand at different frames, and one begins anew half way."""
    rng = np.random.default_rng(seed)
    truths = [random_rows(rng, 30, True) for _ in range(DRIVES)]
    outputs = [random_rows(rng, 30, False) for _ in range(DRIVES)]
    frames = LabelledFrames.nothing()
    firsts = []
    for truth in truths:
        firsts.append(len(frames.starts) - 1)
        frames = LabelledFrames.of(truth, FRAMES).after(frames)
    running, alone = RunningClears(DRIVES), [RunningClear() for _ in range(DRIVES)]
    shift = rng.integers(0, 3, DRIVES)
    for step in range(FRAMES):
        if step == FRAMES // 2:
            running.reset(np.array([1]))
            alone[1] = RunningClear()
        at = np.zeros(DRIVES, np.int64)
        rows = [Tracks.empty()]
        for drive, (truth, output) in enumerate(zip(truths, outputs, strict=True)):
            frame = step - int(shift[drive])
            if frame < 0:
                continue
            at[drive] = firsts[drive] + frame
            here = output.select(output.frames == frame)
            rows.append(Tracks(np.full(len(here), drive), here.ids, here.boxes))
            alone[drive].add(truth.select(truth.frames == frame), here, frame)
        running.add(frames, at, Tracks.concatenate(rows))
    for drive in range(DRIVES):
        assert counts_of(running, drive) == vars(alone[drive].total), drive


def test_the_frame_that_stands_for_none_counts_nothing_but_false_positives() -> None:
    running = RunningClears(2)
    running.add(LabelledFrames.nothing(), np.zeros(2, np.int64), one_box(7, frame=1))
    assert counts_of(running, 0) == {"CLR_TP": 0, "CLR_FP": 0, "CLR_FN": 0, "IDSW": 0}
    assert counts_of(running, 1) == {"CLR_TP": 0, "CLR_FP": 1, "CLR_FN": 0, "IDSW": 0}


def test_a_drive_that_begins_anew_forgets_its_names() -> None:
    labels = LabelledFrames.of(one_box(1), 1).after(LabelledFrames.nothing())
    running, at = RunningClears(1), np.array([1])
    running.add(labels, at, one_box(4))
    running.add(labels, at, one_box(5))
    assert running.gain.tolist() == [1]
    running.reset(np.array([0]))
    running.add(labels, at, one_box(6))
    assert counts_of(running, 0) == {"CLR_TP": 1, "CLR_FP": 0, "CLR_FN": 0, "IDSW": 0}
