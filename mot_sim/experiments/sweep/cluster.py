"""A Dask cluster through joblib: reached or not, and what happens when it goes away."""

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from importlib import import_module
from threading import Event, Thread
from typing import Any

from tracker.errors import TrackingError

PATIENCE = 10.0  # seconds that a scheduler may take to answer
LONELY = 60.0  # seconds without any worker, after which none is expected any more
LOOK = 1.0  # seconds between looks at who is there
KEPT = "finished trials are kept, and the same command goes on from there"


class WorkersLost(TrackingError):
    """Those who do the work cannot be reached, or went away."""


@contextmanager
def cluster_backend(address: str) -> Iterator[Any]:
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
            client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise WorkersLost(
                f"no Dask scheduler at {address}: {str(error)[:200]}; start one with "
                "`dask scheduler` and give tcp://HOST:PORT"
            ) from None
        backend, stop = _backend(client), Event()
        watch = Thread(target=_watch, args=(client, backend, LONELY, stop), daemon=True)
        watch.start()
        try:
            yield backend
        finally:
            stop.set()
            watch.join(2.0 * PATIENCE)
            with suppress(OSError):
                client.close(timeout=PATIENCE)


def _backend(client: Any) -> Any:
    """joblib's backend, which waits for ever where a task is lost; this one says so."""
    theirs: Any = import_module("joblib._dask").DaskDistributedBackend

    class Told(theirs):  # type: ignore[misc]
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
    backend = Told(client=client, wait_for_workers_timeout=LONELY)
    backend.waiting = waiting
    return backend


def _watch(client: Any, backend: Any, lonely: float, stop: Event) -> None:
    """Tell joblib when no worker has been there for so long."""
    alone = 0.0
    while not stop.wait(LOOK):
        try:
            alone = 0.0 if client.ncores() else alone + LOOK
        except (OSError, ValueError, RuntimeError, AttributeError):
            alone += LOOK  # the scheduler is away; a client that has given up has none at all
        if alone >= lonely and backend.waiting:
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
