"""`mot-sim cache`: what it lists, removes and limits."""

import json
from pathlib import Path

import pytest

from mot_sim.cli import run
from mot_sim.experiments.sweep.drives import Recordings
from mot_sim.simulation.kernels import PACKAGE
from tracker.kernels import folders_in_use, modules_of


@pytest.fixture
def caches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Path]:
    """Episodes and kernels of this code and of other code, and one environment."""
    for variable, part in (
        ("MOT_SIM_CACHE", "episodes"), ("NUMBA_CACHE_DIR", "kernels"), ("MOT_SIM_GUESTS", "guests")
    ):  # fmt: skip
        monkeypatch.setenv(variable, str(tmp_path / part))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))
    monkeypatch.delenv("MOT_SIM_CACHE_LIMIT", raising=False)
    (kernels,) = folders_in_use(modules_of(PACKAGE))
    found = {
        "episode": Recordings.shared().folder / "truth" / "a.npz",
        "old episode": tmp_path / "episodes" / "0123" / "truth" / "b.npz",
        "kernel": kernels / "fill.nbc",
        "old kernel": tmp_path / "kernels" / "4567" / "fill.nbc",
        "guest": tmp_path / "guests" / "sort" / "ready.json",
    }
    for path in found.values():
        path.parent.mkdir(parents=True)
        path.write_bytes(bytes(100))
    return found


def left(caches: dict[str, Path]) -> set[str]:
    return {name for name, path in caches.items() if path.is_file()}


def test_all_parts_are_listed(caches: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["cache", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {part: (kept["files"], kept["bytes"]) for part, kept in told["kept"].items()} == {
        "episodes": (2, 200), "kernels": (2, 200), "guests": (1, 100)
    }  # fmt: skip
    assert told["limit"] == 4 * 10**9
    assert run(["cache"]) == 0
    assert "4 GB" in capsys.readouterr().out
    assert left(caches) == {*caches}


def test_what_other_code_made_goes_alone(caches: dict[str, Path]) -> None:
    assert run(["cache", "--clear", "old"]) == 0
    assert left(caches) == {"episode", "kernel", "guest"}


@pytest.mark.parametrize(
    ("names", "kept"),
    [
        ("episodes", {"kernel", "old kernel", "guest"}),
        ("kernels, guests", {"episode", "old episode"}),
        ("all", set()),
    ],
)
def test_parts_are_removed(caches: dict[str, Path], names: str, kept: set[str]) -> None:
    assert run(["cache", "--clear", names]) == 0
    assert left(caches) == kept


def test_a_limit_holds_at_once_and_stays(
    caches: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["cache", "--limit", "0.1 kB", "--json"]) == 0
    said = capsys.readouterr()
    assert "removed 100 B" in said.err
    assert json.loads(said.out)["limit"] == 100
    assert len(left(caches) & {"episode", "old episode"}) == 1
    assert run(["cache", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["limit"] == 100


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--clear", "episode"], "Did you mean 'episodes'?"),
        (["--limit", "much"], "--limit: 'much' is no size"),
    ],
)
def test_what_is_not_known_is_refused_and_nothing_removed(
    caches: dict[str, Path], capsys: pytest.CaptureFixture[str], options: list[str], told: str
) -> None:
    assert run(["cache", *options]) == 2
    assert told in capsys.readouterr().err
    assert left(caches) == {*caches}
