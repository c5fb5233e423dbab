"""Loads modules of compiled functions when they are first needed, from a cache where there is one.

Everything stays in $NUMBA_CACHE_DIR, else in mot-sim/kernels of the user's cache folder, by the
code of the kernels, the versions of numba and NumPy, and the processor: what lies there fits.
"""

import hashlib
import os
import sys
import tempfile
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from threading import RLock
from time import perf_counter
from types import ModuleType
from typing import Any, NamedTuple

from tracker.errors import KernelWarning, NoNumba
from tracker.kernels.sparing import sparing
from tracker.user_cache import user_cache

PACKAGE = "tracker.kernels"
OTHER_MODULES = ("__init__", "compiling", "loading", "parts", "sparing")
# What pyproject.toml asks for.
LOWEST_NUMBA, NUMBA = (0, 61), "pip install 'numba>=0.61,<1'"
# A terminal is told of what compiles for longer than this, s.
SILENT_SECONDS = 0.5

_lock = RLock()
_compiled: set[str] = set()  # modules of which something did not come from the cache
_unwritable: set[Path] = set()  # folders of which that has been said


class Kernel(partial[Any]):
    """A compiled function, loaded when it is first called; arguments must have its types.

    NoNumba where there is no numba to load it with. It is a `partial` of no arguments since that
    hands a call on without a step in Python, which takes as long as a small kernel.
    """

    def __new__(cls, module: str, name: str) -> "Kernel":
        """The function of that name in the module."""

        def first(*arguments: Any) -> Any:
            function = getattr(load(module), name)
            kernel.__setstate__((function, (), {}, None))  # type: ignore[attr-defined]
            return function(*arguments)

        kernel = super().__new__(cls, first)
        return kernel


class Warmed(NamedTuple):
    """What `warm` did with a module of kernels."""

    module: str
    """Its name."""
    seconds: float
    """How long it took."""
    is_new: bool
    """Whether something was compiled."""


def modules_of(package: str = PACKAGE) -> list[str]:
    """The modules of a package that hold kernels."""
    names = (path.stem for path in _sources(package) if path.stem not in OTHER_MODULES)
    return [f"{package}.{name}" for name in names]


def warm(modules: Iterable[str]) -> Iterator[Warmed]:
    """Load these modules of kernels, one after the other; what is not cached is compiled."""
    for module in modules:
        start = perf_counter()
        load(module)
        yield Warmed(module, perf_counter() - start, module in _compiled)


def cache_folder() -> Path:
    """Where compiled kernels are kept, whatever their code."""
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named:
        return Path(named)
    return user_cache("kernels")


def folders_in_use(modules: Iterable[str]) -> set[Path]:
    """Where these modules are kept, compiled from today's code; others are of other code."""
    return {cache_folder() / _digest(module) for module in modules}


def load(module: str) -> ModuleType:
    """The module, compiled. What is damaged in the cache is made anew."""
    with _lock:
        if module in sys.modules:
            return sys.modules[module]
        numba = _numba()
        folder = cache_folder() / _digest(module)
        kept = _can_write(folder)
        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(folder) if kept else ""
        try:
            with _watched(module), sparing():
                try:
                    return import_module(module)
                except Exception:  # noqa: BLE001 - whatever damaged files raise
                    _forget(folder, module)
                    return import_module(module)
        finally:
            numba.config.CACHE_DIR = before


def _numba() -> ModuleType:
    """Numba itself; NoNumba where it is missing, too old, or does not fit NumPy."""
    try:
        numba = import_module("numba")
    except ImportError as error:
        raise NoNumba(f"numba cannot be imported ({error}): {NUMBA}") from error
    version = str(numba.__version__)
    if tuple(int(part) for part in version.split(".")[:2]) < LOWEST_NUMBA:
        raise NoNumba(f"numba {version} is too old: {NUMBA}")
    return numba


def _sources(package: str) -> list[Path]:
    """The files of a package."""
    spec = find_spec(package)
    places = spec.submodule_search_locations if spec is not None else None
    return sorted(path for place in places or () for path in Path(place).glob("*.py"))


def _digest(module: str) -> str:
    """A name for what the compiled code depends on: numba itself looks at one file alone."""
    processor = os.environ.get("NUMBA_CPU_NAME")
    processor = processor or import_module("llvmlite.binding").get_host_cpu_name()
    versions = (import_module(name).__version__ for name in ("numba", "numpy"))
    words = *versions, processor, os.environ.get("NUMBA_CPU_FEATURES", "")
    found = hashlib.sha256(" ".join(words).encode())
    for package in sorted({PACKAGE, module.rpartition(".")[0]}):
        for path in _sources(package):
            found.update(path.name.encode() + path.read_bytes())
    return found.hexdigest()[:16]


def _can_write(folder: Path) -> bool:
    """Whether files can be made in a folder, which is made if need be; a KernelWarning if not."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError as error:
        if folder not in _unwritable:
            _unwritable.add(folder)
            warnings.warn(
                f"kernels cannot be kept in {folder} ({error.strerror}): every process compiles "
                "them anew; name a folder that you may write to in NUMBA_CACHE_DIR",
                KernelWarning,
                stacklevel=2,
            )
        return False


def _forget(folder: Path, module: str) -> None:
    """Remove what is kept of a module, and of all that are not loaded: it may need them."""
    sys.modules.pop(module, None)
    packages = {PACKAGE, module.rpartition(".")[0]}
    for path in folder.rglob("*.nb[ci]"):
        name = path.name.partition(".")[0]
        if not any(f"{package}.{name}" in sys.modules for package in packages):
            path.unlink(missing_ok=True)


@contextmanager
def _watched(module: str) -> Iterator[None]:
    """Note whether a module compiles, and say so on a terminal, once, if it takes long."""
    event = import_module("numba.core.event")

    class Compiling(event.Listener):  # type: ignore[misc, name-defined]
        """Hears of every function that is compiled, not of those that the cache has."""

        since = 0.0
        spoke = False

        def on_start(self, event: Any) -> None:
            """A function begins to compile."""
            _compiled.add(module)
            self.since = self.since or perf_counter()
            is_long = perf_counter() - self.since > SILENT_SECONDS
            if is_long and not self.spoke and sys.stderr and sys.stderr.isatty():
                self.spoke = True
                sys.stderr.write(f"compiling {module}, once: ")
                sys.stderr.flush()

        def on_end(self, event: Any) -> None:
            """It is compiled."""

    listener = Compiling()
    with event.install_listener("numba:compile", listener):
        try:
            yield
        finally:
            if listener.spoke:
                sys.stderr.write(f"{perf_counter() - listener.since:.0f} s\n")
