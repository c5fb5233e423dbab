"""Work on frames by several processes: the same results, in order."""

import os
import signal
from contextlib import closing

import numpy as np
import pytest

from mot_sim.simulation.cores import core_count, frame_by_frame
from mot_sim.simulation.imaging import ImagesAhead, RenderedImages
from mot_sim.simulation.scene import Rollout
from tests.mot_sim.simulation.episodes.small import small
from tracker.errors import BadConfig, WorkersLost


def whose(frame: int) -> tuple[int, int]:
    return frame, os.getpid()


def fails(frame: int) -> int:
    if frame >= 5:
        raise BadConfig(f"frame {frame}")
    return frame


@pytest.mark.parametrize("count", [0, 1, 9])
@pytest.mark.parametrize("jobs", [1, 2, 3])
def test_results_come_in_order_from_as_many_processes(count: int, jobs: int) -> None:
    found = list(frame_by_frame(whose, count, jobs))
    assert [frame for frame, _ in found] == list(range(count))
    processes = {process for _, process in found}
    assert (os.getpid() in processes) == (count > 0 and (jobs == 1 or count < 5))
    assert len(processes) <= jobs


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_fails_is_told_after_what_came_before(jobs: int) -> None:
    found: list[int] = []
    with pytest.raises(BadConfig, match="frame 5"):
        found.extend(frame_by_frame(fails, 12, jobs))
    assert found in ([0, 1, 2, 3, 4], [0, 1, 2, 3])  # of the block that failed, or before it


def dies(frame: int) -> int:
    if frame == 5:
        os.kill(os.getpid(), signal.SIGKILL)
    return frame


def interrupted(frame: int) -> int:
    raise KeyboardInterrupt


def test_a_process_that_dies_is_told_and_nobody_waits_for_it() -> None:
    with pytest.raises(WorkersLost, match="--jobs 1"):
        list(frame_by_frame(dies, 12, 2))
    with pytest.raises(KeyboardInterrupt):
        list(frame_by_frame(interrupted, 12, 2))


def test_processes_end_with_it() -> None:
    with closing(frame_by_frame(whose, 100, 2)) as results:
        _, process = next(results)
    with pytest.raises(ProcessLookupError):
        os.kill(process, signal.SIGCONT)


@pytest.mark.parametrize("jobs", [0, -2])
def test_impossible_numbers_are_refused(jobs: int) -> None:
    with pytest.raises(BadConfig, match=f"--jobs {jobs}: give 1 or more"):
        core_count(jobs)


def test_images_drawn_ahead_are_the_same() -> None:
    images = RenderedImages(Rollout.of(small(), 3))
    count = len(images.rollout)
    with closing(ImagesAhead(images, 2)) as ahead:
        for frame in (0, 1, 0, *range(2, count)):
            assert np.array_equal(ahead.load(frame), images.load(frame))
        assert ahead.load(count) is None
