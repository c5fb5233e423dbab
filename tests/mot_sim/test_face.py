"""The names that `mot_sim` itself hands on."""

import ast
import pickle
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import mot_sim
from tests.mot_sim.test_imports import modules_after

SOURCE = Path(mot_sim.__file__)


def rooms() -> dict[str, str]:
    """Where a type checker is told that each name lives."""
    for node in ast.parse(SOURCE.read_text()).body:
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            return {
                alias.name: str(each.module)
                for each in node.body
                if isinstance(each, ast.ImportFrom)
                for alias in each.names
            }
    raise AssertionError("no block for type checkers")


@pytest.mark.parametrize("name", mot_sim.__all__)
def test_a_name_is_the_object_of_its_room(name: str) -> None:
    assert getattr(mot_sim, name) is getattr(import_module(rooms()[name]), name)


def test_type_checkers_know_exactly_the_names_that_are_handed_on() -> None:
    assert sorted(rooms()) == sorted(mot_sim.__all__)


def test_a_name_is_loaded_when_it_is_asked_for() -> None:
    assert "cv2" in modules_after("from mot_sim import find_scene")


def test_dir_and_star_hold_every_name() -> None:
    assert set(mot_sim.__all__) <= set(dir(mot_sim))
    names: dict[str, object] = {}
    exec("from mot_sim import *", names)
    assert set(mot_sim.__all__) <= set(names)


def test_an_unknown_name_gets_a_hint() -> None:
    with pytest.raises(AttributeError, match=r"'mot_sim' has no attribute 'recrd'.*mean 'record'"):
        mot_sim.recrd  # noqa: B018
    with pytest.raises(AttributeError, match=r"has no attribute 'xyzzy'$"):
        mot_sim.xyzzy  # noqa: B018
    with pytest.raises(ImportError, match="cannot import name 'recrd'"):
        exec("from mot_sim import recrd")


@pytest.mark.parametrize("name", ["record", "find_scene", "Tracker", "Design", "Suite"])
def test_names_survive_pickling(name: str) -> None:
    assert pickle.loads(pickle.dumps(getattr(mot_sim, name))) is getattr(mot_sim, name)


@pytest.mark.slow
def test_a_type_checker_sees_through_it(tmp_path: Path) -> None:
    file = tmp_path / "asks.py"
    file.write_text("import mot_sim\nreveal_type(mot_sim.find_scene)\nmot_sim.find_scen\n")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file=", "--follow-imports=silent", str(file)],
        capture_output=True, text=True, check=False, cwd=SOURCE.parents[1],
    )  # fmt: skip
    assert "Scene" in done.stdout
    assert 'Module has no attribute "find_scen"' in done.stdout
