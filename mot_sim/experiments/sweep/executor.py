"""Who does the work: this process, processes of this machine (joblib), or a Dask cluster."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from pickle import dumps, loads
from typing import Any

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from mot_sim.experiments.sweep.cluster import KEPT, WorkersLost, cluster_backend
from mot_sim.experiments.sweep.work import Job, one_thread, run_alone, run_job
from mot_sim.files.named_objects import importable
from tracker.errors import BadConfig


@dataclass(frozen=True)
class Executor:
    """jobs: processes of this machine; 1: this one alone, -1: one a core.

    scheduler: the address of a Dask scheduler, tcp://HOST:PORT, whose workers are used instead.
    """

    jobs: int = 1
    scheduler: str | None = None

    def __post_init__(self) -> None:
        if self.jobs == 0 or self.jobs < -1:
            raise BadConfig(f"--jobs {self.jobs}: give 1 or more, or -1 for all cores")
        if self.scheduler is not None and self.jobs != 1:
            raise BadConfig("--jobs is for this machine, --scheduler for a cluster: keep one")

    @contextmanager
    def open(self) -> "Iterator[WorkerPool]":
        """The crew, reached. Raises WorkersLost for a cluster that does not answer."""
        if self.scheduler is not None:
            with cluster_backend(self.scheduler) as backend:
                yield WorkerPool(-1, {"backend": backend})
        else:
            yield WorkerPool(self.jobs, {"backend": "loky", "inner_max_num_threads": 1})


@dataclass(frozen=True)
class WorkerPool:
    """A crew at work. jobs: 1: this process. backend: of joblib."""

    jobs: int
    backend: dict[str, Any]

    def run(self, jobs: Sequence[Job]) -> Iterator[int]:
        """The number of trials of each job, as they are finished, in any order.

        Raises WorkersLost when workers are killed, or a cluster goes away.
        """
        if self.jobs == 1:
            with one_thread():
                for job in jobs:
                    yield run_job(job)
        elif jobs:
            try:
                yield from self._spread(jobs)
            except (TerminatedWorkerError, OSError) as error:
                if not _is_loss(error):
                    raise
                words = " ".join(str(error).split())[:200]
                raise WorkersLost(f"workers are gone: {words}; {KEPT}") from None

    def _spread(self, jobs: Sequence[Job]) -> Iterator[int]:
        """Through joblib, a job a task.

        Jobs travel as bytes: Dask would scatter objects to one worker, and lose them with it.
        """
        with parallel_config(**self.backend):
            work = Parallel(n_jobs=self.jobs, batch_size=1, return_as="generator_unordered")
            here = str(Path.cwd())
            yield from work(delayed(run_packed)(dumps(job), here) for job in jobs)


def _is_loss(error: Exception) -> bool:
    """Whether workers or their scheduler are gone; other errors are of files."""
    is_dask = type(error).__module__.startswith("distributed.")
    return isinstance(error, TerminatedWorkerError | TimeoutError) or is_dask


def run_packed(packed: bytes, folder: str) -> int:
    """A job that was packed by whoever asks for it in a working folder, which may hold modules."""
    with importable(folder):
        job: Job = loads(packed)
        return run_alone(job)


__all__ = ["Executor", "WorkerPool", "WorkersLost"]
