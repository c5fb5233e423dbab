"""Kernels are compiled when they are first called, once, whatever happens meanwhile."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module, invalidate_caches
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import UNHOOKED, hooked
from tracker.errors import KernelWarning, NoNumba
from tracker.kernels import Kernel, loading, warm

ROOT = Path(__file__).parents[3]
CODE = '''"""A kernel."""

from tracker.kernels.compiling import FLOAT, kernel


@kernel(FLOAT)
def twice(number):
    """Twice a number."""
    return 2.0 * number
'''
LOAD = (
    "from tracker.kernels import Kernel, loading; "
    "assert Kernel('few.numbers', 'twice')(4.0) == 8.0; "
    "print(*sorted(loading._compiled))"
)


@pytest.fixture
def few(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of one kernel, and the empty folder where it is to be kept."""
    package, cache = tmp_path / "few", tmp_path / "kept"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "numbers.py").write_text(CODE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(cache))
    invalidate_caches()
    forget()
    yield cache
    forget()


def forget() -> None:
    """As in a new process."""
    for module in ("few", "few.halves", "few.numbers"):
        sys.modules.pop(module, None)
    loading._compiled.discard("few.numbers")


def compiles() -> bool:
    """Whether a new process would compile the kernel, which works in any case."""
    forget()
    assert Kernel("few.numbers", "twice")(4.0) == 8.0
    return "few.numbers" in loading._compiled


def test_a_kernel_is_compiled_once(few: Path) -> None:
    assert [compiles(), compiles(), compiles()] == [True, False, False]
    forget()
    assert [warmed.is_new for warmed in warm(["few.numbers"])] == [False]


def test_other_code_is_compiled_anew(few: Path) -> None:
    """Also where it stands in a neighbouring file, of which numba knows nothing."""
    assert compiles()
    (few.parent / "few" / "constants.py").write_text("FACTOR = 2.0\n")
    assert compiles()
    assert not compiles()


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", [b"", b"\x80\x04nonsense", None])
def test_damaged_files_are_made_anew(few: Path, ending: str, damage: bytes | None) -> None:
    assert compiles()
    (path,) = few.rglob(f"*.{ending}")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    assert compiles()
    assert not compiles()


def test_damaged_files_of_a_module_that_another_needs_are_made_anew(few: Path) -> None:
    package = few.parent / "few"
    halves = CODE.replace("twice", "half").replace("2.0", "0.5")
    (package / "halves.py").write_text(halves)
    numbers = CODE.replace("2.0 * number", "4.0 * half(number)")
    (package / "numbers.py").write_text(
        numbers.replace("\nfrom", "\nfrom few.halves import half\nfrom")
    )
    assert compiles()
    for ending in ("nbi", "nbc"):
        paths = [*few.rglob(f"*.{ending}")]
        assert {path.name.split(".")[0] for path in paths} == {"halves", "numbers"}
        for path in paths:
            path.write_bytes(b"garbage\n")
        assert compiles()
        assert not compiles()


def test_a_folder_that_cannot_be_written_to_is_named_once(
    few: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few.write_text("a file")
    with pytest.warns(KernelWarning, match=r"cannot be kept in .*kept.* in NUMBA_CACHE_DIR"):
        assert compiles()
    assert compiles()  # a second warning would be an error


def test_a_terminal_is_told_what_compiles_and_nothing_else_is(
    few: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(loading, "SILENT_SECONDS", -1.0)
    assert compiles()
    assert capsys.readouterr() == ("", "")
    (few.parent / "few" / "more.py").write_text("")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    assert compiles()
    assert capsys.readouterr() == ("", "compiling few.numbers, once: 0 s\n")
    assert not compiles()
    assert capsys.readouterr() == ("", "")


@contextmanager
def interrupted() -> Iterator[None]:
    """Ctrl-C arrives when the first function begins to compile."""
    event = import_module("numba.core.event")

    class Interrupt(event.Listener):  # type: ignore[misc, name-defined]
        def on_start(self, event: Any) -> None:
            signal.raise_signal(signal.SIGINT)

        def on_end(self, event: Any) -> None:
            pass

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # xdist's workers ignore it
    try:
        with event.install_listener("numba:compile", Interrupt()):
            yield
    finally:
        signal.signal(signal.SIGINT, before)


def test_ctrl_c_while_it_compiles_breaks_nothing(few: Path) -> None:
    with interrupted(), pytest.raises(KeyboardInterrupt):
        compiles()
    assert compiles()
    assert not compiles()


def test_two_processes_may_compile_at_once(few: Path) -> None:
    command = [
        sys.executable,
        "-c",
        f"import sys; sys.path[:0] = {[str(few.parent), str(ROOT)]}; {LOAD}",
    ]
    start = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    said = [process.communicate(timeout=120)[0].strip() for process in start]
    assert [process.returncode for process in start] == [0, 0]
    assert "few.numbers" in said
    assert not compiles()


def test_numba_that_is_missing_or_too_old_is_asked_for(
    few: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("numba.__version__", "0.57.1")
    with pytest.raises(NoNumba, match=r"numba 0\.57\.1 is too old: pip install 'numba>="):
        compiles()
    monkeypatch.setitem(sys.modules, "numba", None)
    with pytest.raises(NoNumba, match=r"cannot be imported .*: pip install 'numba>="):
        compiles()


def test_every_module_but_the_kernels_has_its_arrays_checked() -> None:
    instruments = hooked(lambda module: module.split(".")[0] in ("tracker", "mot_sim", "scenes"))
    finders = [each for each in sys.meta_path if type(each).__name__ == "_JaxtypingFinder"]
    for package in ("tracker", "mot_sim", "scenes"):
        for path in (ROOT / package).rglob("*.py"):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(
                ".__init__"
            )
            is_kernel = "kernels" in module.split(".")
            assert instruments(module) != is_kernel
            assert all(each.should_instrument(module) != is_kernel for each in finders)
    assert all(not instruments(package) for package in UNHOOKED)
    assert instruments("tracker.kernels_of_others")


def test_numba_is_what_pyproject_asks_for() -> None:
    assert loading.NUMBA.split("'")[1] in (ROOT / "pyproject.toml").read_text()
