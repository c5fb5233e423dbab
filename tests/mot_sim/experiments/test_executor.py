"""Work that is spread: all results, whoever does the work, and what is said of lost workers."""

import os
import signal
from collections.abc import Iterator

import cv2
import pytest

from mot_sim.experiments.executor import Executor, one_thread
from tracker.errors import BadConfig, WorkersLost

TASKS = list(range(7))


def squared(number: int) -> tuple[int, int]:
    """A number's square, and how many threads OpenCV has where it was found."""
    return number**2, cv2.getNumThreads()


def killed(number: int) -> int:
    """Ends the process that does the third task, as a machine without memory would."""
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def refused(number: int) -> int:
    """Cannot be done."""
    raise BadConfig(f"no {number}")


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_all_tasks_are_done_once_with_one_thread(jobs: int) -> None:
    with Executor(jobs).open() as pool:
        found = dict(pool.run(squared, TASKS))
        assert found == {number: (number**2, 1) for number in TASKS}
        assert pool.run_in_order(squared, TASKS) == [found[number] for number in TASKS]
        assert list(pool.run(squared, [])) == []


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_what_a_task_raises_comes_through(jobs: int) -> None:
    with Executor(jobs).open() as pool, pytest.raises(BadConfig, match="no "):
        list(pool.run(refused, TASKS))


def test_what_was_finished_is_there_before_the_rest_is_done() -> None:
    done: list[int] = []

    def noted(number: int) -> int:
        done.append(number)
        return number

    with Executor().open() as pool:
        results = pool.run(noted, TASKS)
        assert [next(results), next(results)] == [(0, 0), (1, 1)]
        assert done == [0, 1]
        results.close()  # type: ignore[attr-defined]
    assert done == [0, 1]


@pytest.mark.slow
def test_a_worker_that_is_killed_is_said_and_the_next_pool_works() -> None:
    with Executor(2).open() as pool:
        with pytest.raises(WorkersLost, match=r"workers are gone: .*finished trials are kept"):
            list(pool.run(killed, TASKS))
        assert sorted(pool.run(squared, TASKS[:2])) == [(0, (0, 1)), (1, (1, 1))]


@pytest.mark.slow
def test_a_task_that_kills_its_workers_is_lost_and_the_others_are_done() -> None:
    with Executor(2).open() as pool:
        found = dict(pool.run(killed, TASKS, lambda number: -number))
    assert found == {number: -3 if number == 3 else number for number in TASKS}


@pytest.mark.parametrize("jobs", [0, -2])
def test_a_number_of_jobs_that_cannot_be_is_refused(jobs: int) -> None:
    with pytest.raises(BadConfig, match=f"--jobs {jobs}: give 1 or more"):
        Executor(jobs)


@pytest.fixture
def three_threads() -> Iterator[None]:
    """OpenCV with three threads, and in the end as before."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(3)
    yield
    cv2.setNumThreads(before)


def test_threads_come_back(three_threads: None) -> None:
    with one_thread():
        assert cv2.getNumThreads() == 1
    assert cv2.getNumThreads() == 3
