"""What is handed out: the wheel and the source distribution, and that the wheel works by itself."""

import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from dataclasses import dataclass
from email.message import Message
from email.parser import Parser
from pathlib import Path
from shutil import copytree, ignore_patterns

import pytest

from tests.pages import DOCS, ROOT, blocks_of

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PACKAGES = ("tracker", "mot_sim", "scenes")
BESIDE = ("tests", "docs", "benchmarks", "examples")
TOP = ("README.md", "LICENSE", "CHANGELOG.md", "CONTRIBUTING.md", "Makefile", "mkdocs.yml")
UNWANTED = ignore_patterns(".*", "__pycache__", "*.egg-info", "build", "dist", "out")
SUITE = """
[crossing]
about = "cars cross behind one another"
scene = "crossing"
frames = 12
bounds = { HOTA = 0.1 }
"""
UNIT_TEST = """
from my_tracker import MyTracker


def test_mine(mot_episode, assert_tracks):
    assert_tracks(MyTracker(), mot_episode("crossing", seed=1, frames=12), mota=0.1)
"""


@dataclass(frozen=True)
class Built:
    """The two files that are handed out."""

    wheel: Path
    source: Path


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """Both, from a copy of the checkout: setuptools writes beside what it reads."""
    place = tmp_path_factory.mktemp("packaging")
    copytree(ROOT, place / "checkout", ignore=UNWANTED)
    run(place / "checkout", sys.executable, "-m", "build", "--outdir", str(place / "dist"))
    (wheel,), (source,) = place.glob("dist/*.whl"), place.glob("dist/*.tar.gz")
    return Built(wheel, source)


@pytest.fixture(scope="module")
def environment(built: Built, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheel and pytest, and nothing of this checkout."""
    place = tmp_path_factory.mktemp("environment") / "venv"
    run(place.parent, sys.executable, "-m", "venv", str(place))
    run(place, str(place / "bin/python"), "-m", "pip", "install", "-q", str(built.wheel), "pytest")
    return place


@pytest.fixture
def workplace(tmp_path: Path) -> Path:
    """A user's folder, with the tracker of the first steps in it."""
    (block,) = (
        block
        for block in blocks_of(DOCS / "quickstart" / "first.md")
        if block.note("file") == "my_tracker.py"
    )
    (tmp_path / "my_tracker.py").write_text(block.text)
    return tmp_path


def run(folder: Path, *words: str) -> str:
    """What a command prints that is run in a folder, without this checkout in sight."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    environment |= {"MOT_SIM_CACHE": str(folder / "cache"), "COLUMNS": "100"}
    done = subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, timeout=900, check=False
    )
    assert done.returncode == 0, f"{words}: {done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    return done.stdout


def files_of(*folders: str) -> set[str]:
    """The files of this checkout's folders, without what Python leaves there."""
    return {
        path.relative_to(ROOT).as_posix()
        for folder in folders
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def metadata_of(wheel: Path) -> Message:
    """The wheel's metadata."""
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        return Parser().parsestr(archive.read(name).decode())


def test_the_version_is_the_newest_of_the_changelog() -> None:
    released = re.findall(
        r"^## (\d\S*) - \d{4}-\d\d-\d\d$", (ROOT / "CHANGELOG.md").read_text(), re.M
    )
    assert released[0] == PROJECT["version"]


def test_the_oldest_python_that_is_allowed_is_one_that_is_named() -> None:
    named = [word.rpartition(" ")[2] for word in PROJECT["classifiers"] if ":: 3." in word]
    assert PROJECT["requires-python"] == f">={named[0]}"


@pytest.mark.slow
def test_the_wheel_holds_the_packages_with_their_data_and_nothing_else(built: Built) -> None:
    with zipfile.ZipFile(built.wheel) as archive:
        held = set(archive.namelist())
    packed = {name for name in held if ".dist-info/" not in name}
    assert packed == files_of(*PACKAGES) | {"mot_sim_pytest.py"}
    assert {f"{package}/py.typed" for package in PACKAGES} < packed
    assert any(name.endswith(".dist-info/licenses/LICENSE") for name in held)


@pytest.mark.slow
def test_the_metadata_says_what_pyproject_says(built: Built) -> None:
    told = metadata_of(built.wheel)
    assert (told["Name"], told["Version"]) == ("mot-sim", PROJECT["version"])
    assert (told["License-Expression"], told["License-File"]) == ("MIT", "LICENSE")
    assert told["Description-Content-Type"] == "text/markdown"
    assert told.get_payload() == (ROOT / "README.md").read_text()


@pytest.mark.slow
def test_the_source_distribution_holds_tests_pages_benchmarks_and_examples(built: Built) -> None:
    with tarfile.open(built.source) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert files_of(*PACKAGES, *BESIDE) | {*TOP, "pyproject.toml", "mot_sim_pytest.py"} <= names


@pytest.mark.slow
def test_the_doctor_finds_nothing_broken(environment: Path, workplace: Path) -> None:
    script = str(environment / "bin/mot-sim")
    assert run(workplace, script, "--version") == f"mot-sim {PROJECT['version']}\n"
    assert "broken" not in run(workplace, script, "doctor")


@pytest.mark.slow
def test_a_users_own_tracker_goes_through_a_stress_test(environment: Path, workplace: Path) -> None:
    (workplace / "suites.toml").write_text(SUITE)
    said = run(
        workplace, str(environment / "bin/mot-sim"), "stress", "--file", "suites.toml",
        "--seeds", "1", "--trackers", "mine=my_tracker:MyTracker",
    )  # fmt: skip
    assert re.search(r"^pass .*crossing.*mine.*HOTA", said, re.MULTILINE), said


@pytest.mark.slow
def test_pytest_finds_the_plugin(environment: Path, workplace: Path) -> None:
    (workplace / "test_mine.py").write_text(UNIT_TEST)
    assert "1 passed" in run(workplace, str(environment / "bin/python"), "-m", "pytest", "-q")
