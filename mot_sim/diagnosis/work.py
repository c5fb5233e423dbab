"""Many drives: one after the other or in processes, each kept as soon as it is finished."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from pickle import dumps, loads

import cv2
from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError
from threadpoolctl import threadpool_limits

from mot_sim.diagnosis.findings import Findings, read_findings, write_findings
from mot_sim.diagnosis.tasks import Task
from mot_sim.experiments.sweep.executor import Executor, WorkersLost
from mot_sim.experiments.sweep.work import one_thread

DRIVES_FOLDER = "drives"  # the folder of finished drives
# Called with what is under way, how much of it is done, and how much there is.
Progress = Callable[[str, int, int], None]


def diagnose(
    tasks: Sequence[Task],
    folder: Path | None = None,
    *,
    jobs: int = 1,
    progress: Progress | None = None,
) -> list[Findings]:
    """The findings of every task, in their order.

    folder: where finished drives stay, by the hash of all that decides them: what stands there is
    not done again. jobs: processes; -1: one a core. Raises BadConfig for a number of jobs that
    cannot be, WorkersLost when one is killed, and what a task raises.
    """
    crew = Executor(jobs)
    tell = progress or (lambda what, done, total: None)
    paths = [
        None if folder is None else folder / DRIVES_FOLDER / f"{task.key}.json" for task in tasks
    ]
    found: dict[int, Findings] = {}
    for number, path in enumerate(paths):
        before = None if path is None else read_findings(path)
        if before is not None:
            found[number] = before
    tell("drives", len(found), len(tasks))
    todo = [number for number in range(len(tasks)) if number not in found]
    for number, findings in _finished([(n, tasks[n]) for n in todo], crew.jobs):
        found[number] = findings
        path = paths[number]
        if path is not None:
            write_findings(path, findings)
        tell("drives", len(found), len(tasks))
    return [found[number] for number in range(len(tasks))]


def _finished(todo: list[tuple[int, Task]], jobs: int) -> Iterator[tuple[int, Findings]]:
    """Number and findings of tasks as they are finished, in any order."""
    if jobs == 1 or len(todo) < 2:
        with one_thread():
            for number, task in todo:
                yield number, task.run()
        return
    try:
        with parallel_config(backend="loky", inner_max_num_threads=1):
            work = Parallel(n_jobs=jobs, batch_size=1, return_as="generator_unordered")
            yield from work(delayed(_run_packed)(number, dumps(task)) for number, task in todo)
    except TerminatedWorkerError as error:
        words = " ".join(str(error).split())[:200]
        raise WorkersLost(f"workers are gone: {words}; run the command again") from None


def _run_packed(number: int, packed: bytes) -> tuple[int, Findings]:
    """A task in a worker process, whose libraries have one thread from now on."""
    threadpool_limits(1)
    cv2.setNumThreads(1)
    task: Task = loads(packed)
    return number, task.run()


__all__ = ["diagnose"]
