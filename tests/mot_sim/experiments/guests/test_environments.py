"""Environments of guests, made for real from a wheel of our own, without any network."""

import sys
import zipfile
from pathlib import Path

import pytest

from mot_sim.experiments.guests import Environment, ExternalTracker, ExternalTrackerFailed
from mot_sim.foreign.processes import run_process
from tests.mot_sim.cli.conftest import CommandLine
from tracker.errors import BadOutput

NAME = "mot_sim_greeting"


@pytest.fixture
def offline(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A place for environments, with pip kept from any index."""
    monkeypatch.setenv("MOT_SIM_GUESTS", str(tmp_path / "guests"))
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    monkeypatch.delenv("PIP_FIND_LINKS", raising=False)
    return tmp_path


def wheel(folder: Path, name: str = NAME, word: str = "hello", demand: str = "") -> Path:
    """A wheel with one module that says a word."""
    path = folder / f"{name}-1.0-py3-none-any.whl"
    about = f"{name}-1.0.dist-info"
    needs = f"Requires-Dist: {demand}\n" if demand else ""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(f"{name}.py", f"word = {word!r}\n")
        archive.writestr(
            f"{about}/METADATA", f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n{needs}"
        )
        archive.writestr(
            f"{about}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        )
        archive.writestr(f"{about}/RECORD", f"{name}.py,,\n")
    return path


@pytest.mark.slow
def test_an_environment_is_made_once_and_holds_nothing_of_ours(offline: Path) -> None:
    demanding = wheel(offline, "mot_sim_name", ", you", demand="nobody-has-this>1")
    environment = Environment("greeting", (str(wheel(offline)),), bare=(str(demanding),))
    assert not environment.is_ready
    python = environment.set_up("greeting")
    made = environment.python.stat().st_mtime_ns
    assert environment.set_up("greeting") == python
    assert environment.python.stat().st_mtime_ns == made
    code = f"import sys, {NAME} as a, mot_sim_name as b; sys.stderr.write(a.word + b.word)"
    guest = ExternalTracker(
        "greeting", ("{python}", "-c", code, "{detections}", "{results}"), environment
    )
    words = guest.words(offline, offline)
    assert words[0] == str(environment.python) != sys.executable
    assert run_process("greeting", words, 60.0) == "hello, you"
    with pytest.raises(ExternalTrackerFailed) as caught:
        run_process("greeting", [words[0], "-c", "import numpy"], 60.0)
    assert "No module named 'numpy'" in caught.value.stderr


@pytest.mark.slow
def test_offline_the_set_up_says_what_is_missing_and_leaves_nothing(
    offline: Path, mot_sim: CommandLine
) -> None:
    outcome = mot_sim("compare", "--setup", "sort,motpy")
    assert outcome.code == 2
    assert "error: guest sort: trackers==2.6.1 cannot be installed; that needs" in outcome.err
    assert "  sort: ERROR: No matching distribution found for trackers==2.6.1" in outcome.err
    assert "error: guest motpy: motpy==0.0.10, filterpy==2.0.0 cannot be" in outcome.err
    assert list((offline / "guests").iterdir()) == []


def test_guests_of_one_environment_are_set_up_together_and_the_others_go_on(
    offline: Path, mot_sim: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    def set_up(environment: Environment, guest: str) -> Path:
        if "trackers" in environment.name:
            raise ExternalTrackerFailed(guest, "no index", "refused")
        return environment.python

    monkeypatch.setattr(Environment, "set_up", set_up)
    outcome = mot_sim("compare", "--setup", "sort,norfair,bot-sort")
    assert outcome.code == 2
    assert outcome.err == "error: guest sort, bot-sort: no index\n  sort: refused\n"
    assert outcome.out.startswith("norfair: ready in ")


def test_a_half_made_environment_is_not_taken_for_one(offline: Path) -> None:
    environment = Environment("half", ("nothing==1",))
    environment.python.parent.mkdir(parents=True)
    environment.python.write_text("")
    assert not environment.is_ready
    with pytest.raises(ExternalTrackerFailed, match="no environment in"):
        environment.require("half")


def test_an_environment_whose_python_is_gone_is_made_anew(offline: Path) -> None:
    environment = Environment("old", ("nothing==1",))
    environment.python.parent.mkdir(parents=True)
    (environment.path / "ready.json").write_text("{}")
    environment.python.symlink_to(sys.executable)
    assert environment.is_ready
    environment.python.unlink()
    environment.python.symlink_to(offline / "gone")
    assert not environment.is_ready


def test_no_place_for_environments_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("MOT_SIM_GUESTS", str(tmp_path / "file"))
    with pytest.raises(BadOutput, match=r"no place for an environment: .*MOT_SIM_GUESTS"):
        Environment("x", ("nothing==1",)).set_up("x")
