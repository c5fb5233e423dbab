"""Every benchmark starts: it says its help, and refuses what it does not know."""

import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "benchmarks"
MODULES = sorted(
    ".".join(path.relative_to(FOLDER.parent).with_suffix("").parts)
    for path in FOLDER.rglob("*.py")
    if f"python -m {'.'.join(path.relative_to(FOLDER.parent).with_suffix('').parts)}"
    in path.read_text(encoding="utf-8")
)


def ended(module: str, argument: str, monkeypatch: pytest.MonkeyPatch) -> object:
    """The exit code of a benchmark with one argument."""
    file = FOLDER.parent.joinpath(*module.split(".")).with_suffix(".py")
    monkeypatch.setattr("sys.argv", [str(file), argument])
    with pytest.raises(SystemExit) as end:
        runpy.run_path(str(file), run_name="__main__")
    return end.value.code


def test_there_are_benchmarks() -> None:
    assert len(MODULES) > 40


@pytest.mark.parametrize("module", MODULES)
def test_a_benchmark_says_its_help(
    module: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ended(module, "--help", monkeypatch) == 0
    assert "--help" in capsys.readouterr().out


@pytest.mark.parametrize("module", MODULES)
def test_a_benchmark_refuses_what_it_does_not_know(
    module: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ended(module, "--not-an-option", monkeypatch) == 2
    assert "usage" in capsys.readouterr().err
