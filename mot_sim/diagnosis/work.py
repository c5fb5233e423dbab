"""Many drives: one after the other or in processes, each kept as soon as it is finished."""

from collections.abc import Callable, Sequence
from pathlib import Path

from mot_sim.diagnosis.findings import Findings, read_findings, write_findings
from mot_sim.diagnosis.tasks import Task
from mot_sim.experiments.executor import Executor

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
    executor = Executor(jobs)
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
    with executor.open() as pool:
        for place, findings in pool.run(_run, [tasks[number] for number in todo]):
            found[todo[place]] = findings
            path = paths[todo[place]]
            if path is not None:
                write_findings(path, findings)
            tell("drives", len(found), len(tasks))
    return [found[number] for number in range(len(tasks))]


def _run(task: Task) -> Findings:
    return task.run()


__all__ = ["diagnose"]
