"""The workflows of `examples/ci/`: their commands, run as a shell script in a small repository."""

import os
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.pages import ROOT, SCRIPT

FOLDER = ROOT / "examples" / "ci"
TRACKER = """
class MyTracker:
    def update(self, boxes, scores):
        return [[*box, number] for number, box in enumerate(boxes)]
"""
SUITE = """
[smoke]
about = "an open road"
scene = "crossing"
frames = 5
settings = { "scene.houses" = 0.0, "scene.trees" = 0.0, "scene.furniture" = 0.0 }
bounds = { hota = 0.01, idsw = 0 }
"""


def script_of(workflow: Path) -> list[str]:
    """The shell lines of a workflow, without those that install."""
    lines: list[str] = []
    indent = None
    for line in workflow.read_text(encoding="utf-8").splitlines():
        depth = len(line) - len(line.lstrip())
        if line.strip() in ("run: |", "script:"):
            indent = depth
        elif indent is not None and depth > indent:
            lines.append(line.strip().removeprefix("- "))
        else:
            indent = None
    return [line for line in lines if "pip install" not in line]


def run(lines: list[str], place: Path) -> int:
    """Run the lines as CI does, until one fails; the small suite stands in for `smoke`."""
    small = [line.replace("stress smoke", "stress smoke --file suites.toml") for line in lines]
    small = [f"{line} --seeds 2" if "stress smoke" in line else line for line in small]
    path = os.pathsep.join([str(SCRIPT.parent), os.environ["PATH"]])
    variables = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}
    variables["GITHUB_STEP_SUMMARY"] = str(place / "summary.md")
    done = subprocess.run(
        ["bash", "-e", "-c", "\n".join(small)], cwd=place, env=variables, check=False, timeout=300
    )
    return done.returncode


def test_both_workflows_run_the_same_commands() -> None:
    github, gitlab = (script_of(FOLDER / f"{name}.yml") for name in ("github", "gitlab"))
    assert [line for line in github if line in gitlab] == gitlab
    assert any("--junit stress.xml" in line for line in gitlab)
    for name in ("github", "gitlab"):
        assert "stress.xml" in (FOLDER / f"{name}.yml").read_text().partition("--markdown")[2]


@pytest.mark.parametrize("name", ["github"])
def test_a_workflow_writes_the_junit_file_and_the_baseline(name: str, tmp_path: Path) -> None:
    (tmp_path / "my_tracker.py").write_text(TRACKER)
    (tmp_path / "suites.toml").write_text(SUITE)
    lines = script_of(FOLDER / f"{name}.yml")
    assert run(lines, tmp_path) == 1  # every box is somebody new: switches
    (suite,) = ElementTree.parse(tmp_path / "stress.xml").getroot()
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    assert (tmp_path / "baseline.json").is_file()
    assert run([line for line in lines if "mot-sim" not in line], tmp_path) == 0
    assert "1 of 2 bounds are kept" in (tmp_path / "summary.md").read_text()
