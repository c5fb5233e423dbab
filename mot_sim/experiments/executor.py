"""Who does the work: this process, processes of this machine (joblib), or a Dask cluster.

Beside the experiments, since sweep, tuning and diagnosis all spread their work through it, and
nothing below them does. How work is spread decides no number, so no fingerprint covers this file.
"""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from pickle import dumps, loads
from threading import Event, Thread
from typing import Any, TypeVar

import cv2
from threadpoolctl import threadpool_limits

from mot_sim.files.named_objects import importable
from tracker.errors import BadConfig, TrackingError, WorkersLost

CONNECT_TIMEOUT = 10.0  # seconds that a scheduler may take to answer
IDLE_TIMEOUT = 60.0  # seconds without any worker, after which none is expected any more
FAR_PROCESSES = 32
POLL_SECONDS = 1.0  # between looks at which workers are there
MAX_ERROR_LETTERS = 200  # that are kept of what joblib or Dask say
KEPT = "finished trials are kept where there is a folder for them: run the same command again"

Task = TypeVar("Task")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Executor:
    """Where the work is done: in this process, in several of this machine, or on a Dask cluster.

    Raises BadConfig for an impossible number of jobs, and for `jobs` and `scheduler` together.
    """

    jobs: int = 1
    """Processes on this machine: 1 or more, or -1 for one per core; 1 works in this process
    alone."""
    scheduler: str | None = None
    """Address of a Dask scheduler, tcp://HOST:PORT, whose workers do the work; None: this machine.
    It needs `jobs` = 1."""

    def __post_init__(self) -> None:
        if self.jobs == 0 or self.jobs < -1:
            raise BadConfig(f"--jobs {self.jobs}: give 1 or more, or -1 for all cores")
        if self.scheduler is not None and self.jobs != 1:
            raise BadConfig("--jobs is for this machine, --scheduler for a cluster: keep one")

    @contextmanager
    def open(self) -> "Iterator[WorkerPool]":
        """The workers, ready. Raises WorkersLost for a cluster that does not answer."""
        if self.scheduler is None:
            yield WorkerPool(self.jobs, {"backend": "loky", "inner_max_num_threads": 1})
        else:
            with _cluster_backend(self.scheduler) as backend:
                yield WorkerPool(-1, {"backend": backend}, is_far=True)


@dataclass(frozen=True)
class WorkerPool:
    """Workers that are ready to run tasks."""

    jobs: int
    """Processes that joblib may use; -1: all that its backend has."""
    backend: dict[str, Any]
    """Keyword arguments of joblib's `parallel_config`, which choose the backend."""
    is_far: bool = False
    """Whether the workers are on other machines; then even a single task is sent to them."""

    @property
    def processes(self) -> int:
        """How many processes share the work; of a cluster, whose workers come and go, a guess."""
        if self.is_far:
            return FAR_PROCESSES
        from joblib import effective_n_jobs

        return int(effective_n_jobs(self.jobs))

    def run(
        self,
        function: Callable[[Task], Result],
        tasks: Sequence[Task],
        lost: Callable[[Task], Result] | None = None,
    ) -> Iterator[tuple[int, Result]]:
        """The place of each task and what the function gives for it, as they are finished.

        One process of this machine, and a single task, need no others: they are done here, in
        order. Everywhere the numeric libraries have one thread. function: of a module; it and
        the tasks can be pickled. lost: gives the result of a task that a process of this machine
        died of twice, the second time alone. Raises what the function raises, and WorkersLost
        when workers are killed and there is no `lost`, or a cluster goes away.
        """
        if not self.is_far and (self.jobs == 1 or len(tasks) < 2):
            with one_thread():
                for place, task in enumerate(tasks):
                    yield place, function(task)
            return
        from joblib import effective_n_jobs
        from joblib.externals.loky.process_executor import TerminatedWorkerError

        left = dict(enumerate(tasks))
        while left:
            try:
                for place, result in self._spread(function, dict(left)):
                    del left[place]
                    yield place, result
            except (TerminatedWorkerError, OSError) as error:
                if not _is_loss(error):
                    raise
                if lost is None or self.is_far:
                    words = " ".join(str(error).split())[:MAX_ERROR_LETTERS]
                    raise WorkersLost(f"workers are gone: {words}; {KEPT}") from None
                # Tasks begin in order: one of the first that are left was under way.
                for place in list(left)[: effective_n_jobs(self.jobs)]:
                    yield place, self._alone(function, left.pop(place), lost)

    def _alone(
        self, function: Callable[[Task], Result], task: Task, lost: Callable[[Task], Result]
    ) -> Result:
        """The result of a task that nothing else is done beside."""
        from joblib.externals.loky.process_executor import TerminatedWorkerError

        try:
            ((_, result),) = self._spread(function, {0: task}, jobs=2)
        except TerminatedWorkerError:
            return lost(task)
        return result

    def run_in_order(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> list[Result]:
        """What the function gives for each task, in the order of the tasks; see `run`."""
        found = dict(self.run(function, tasks))
        return [found[place] for place in range(len(tasks))]

    def _spread(
        self,
        function: Callable[[Task], Result],
        tasks: Mapping[int, Task],
        jobs: int | None = None,
    ) -> Iterator[tuple[int, Result]]:
        """Through joblib, one call per task; tasks: by their places. jobs: None: those of the pool.

        Tasks travel as bytes: Dask would scatter objects to one worker, and lose them with it.
        """
        from joblib import Parallel, delayed, parallel_config

        with parallel_config(**self.backend):
            work = Parallel(n_jobs=jobs or self.jobs, batch_size=1, return_as="generator_unordered")
            here = str(Path.cwd())
            yield from work(
                delayed(_run_packed)(function, place, dumps(task), here)
                for place, task in tasks.items()
            )


def _run_packed(
    function: Callable[[Any], Result], place: int, packed: bytes, folder: str
) -> tuple[int, Result]:
    """A task in a worker process, whose libraries have one thread from now on.

    folder: the working folder of whoever asks for it, which may hold modules of the user's own.
    """
    threadpool_limits(1)
    cv2.setNumThreads(1)
    with importable(folder):
        return place, function(loads(packed))


@contextmanager
def one_thread() -> Iterator[None]:
    """While it lasts, BLAS, numpy and OpenCV of this process have one thread."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        with threadpool_limits(1):
            yield
    finally:
        cv2.setNumThreads(before)


def _is_loss(error: Exception) -> bool:
    """Whether workers or their scheduler are gone; other errors are of files."""
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    is_dask = type(error).__module__.startswith("distributed.")
    return isinstance(error, TerminatedWorkerError | TimeoutError) or is_dask


@contextmanager
def _cluster_backend(address: str) -> Iterator[Any]:
    """joblib's Dask backend on the scheduler of that address, while it lasts.

    Raises WorkersLost where nobody answers, and for Dask not being installed.
    """
    try:
        distributed = import_module("distributed")
    except ImportError:
        raise WorkersLost(
            "--scheduler needs Dask: pip install 'mot-sim[scale]', here and on every worker"
        ) from None
    with _quiet():
        try:
            client = distributed.Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise WorkersLost(
                f"no Dask scheduler at {address}: {str(error)[:MAX_ERROR_LETTERS]}; start one with "
                "`dask scheduler` and give tcp://HOST:PORT"
            ) from None
        backend, stop = _backend(client), Event()
        watch = Thread(target=_watch, args=(client, backend, stop), daemon=True)
        watch.start()
        try:
            yield backend
        finally:
            stop.set()
            watch.join(2.0 * CONNECT_TIMEOUT)
            with suppress(OSError):
                client.close(timeout=CONNECT_TIMEOUT)


def _backend(client: Any) -> Any:
    """joblib's backend, which waits for ever where a task is lost; this one says so."""
    theirs: Any = import_module("joblib._dask").DaskDistributedBackend

    class LossReporting(theirs):  # type: ignore[misc]
        """Gives the loss of a task to joblib as the task's result, which then raises it."""

        def submit(self, func: Any, callback: Callable[[Any], None]) -> Any:
            """As joblib's own, whose callback never hears of errors."""
            future = super().submit(func, callback)
            waiting[future] = callback
            future.add_done_callback(tell)
            return future

        def retrieve_result_callback(self, out: Any) -> Any:
            """The results of a task. Raises what became of it where there are none."""
            if isinstance(out, TrackingError):
                raise out
            if isinstance(out, BaseException) or out is None:
                raise WorkersLost(f"the cluster lost a task: {out!r}; {KEPT}")
            return super().retrieve_result_callback(out)

    def tell(done: "Future[Any]") -> None:
        callback = waiting.pop(done, None)
        error = None if done.cancelled() else done.exception()
        if error is not None and callback is not None:
            callback(error)

    waiting: dict[Future[Any], Callable[[Any], None]] = {}
    backend = LossReporting(client=client, wait_for_workers_timeout=IDLE_TIMEOUT)
    backend.waiting = waiting
    return backend


def _watch(client: Any, backend: Any, stop: Event) -> None:
    """Tell joblib when no worker has been there for so long."""
    alone = 0.0
    while not stop.wait(POLL_SECONDS):
        try:
            alone = 0.0 if client.ncores() else alone + POLL_SECONDS
        except (OSError, ValueError, RuntimeError, AttributeError):
            alone += (
                POLL_SECONDS  # the scheduler is away; a client that has given up has none at all
            )
        if alone >= IDLE_TIMEOUT and backend.waiting:
            _, callback = backend.waiting.popitem()
            callback(WorkersLost(f"no worker has been there for {alone:.0f} s; {KEPT}"))
            return


@contextmanager
def _quiet() -> Iterator[None]:
    """While it lasts, what Dask has to say is left to our one line."""
    names = [each for each in logging.root.manager.loggerDict if each.startswith("distributed")]
    loggers = [logging.getLogger(name) for name in names]
    before = [each.level for each in loggers]
    for each in loggers:
        each.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for each, level in zip(loggers, before, strict=True):
            each.setLevel(level)


__all__ = ["Executor", "WorkerPool", "WorkersLost", "one_thread"]
