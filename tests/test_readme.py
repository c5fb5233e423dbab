"""What README.md shows must run: its example, its commands, its files."""

import re
import shlex
from pathlib import Path

import pytest

from mot_sim.datasets import read_camera

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def blocks(language: str) -> list[str]:
    """The fenced blocks of a language."""
    fenced = re.findall(r"^```(\w*)\n(.*?)^```", README, flags=re.DOTALL | re.MULTILINE)
    return [text for name, text in fenced if name == language]


def test_the_example_runs_and_keeps_both_identities(capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(blocks("python")[0], "README.md", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
    assert all(line.startswith("[0 1]") for line in lines)


def test_the_scene_is_run_tracked_and_scored(capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(blocks("python")[1], "README.md", "exec"), {})
    first, second = capsys.readouterr().out.splitlines()
    assert float(first.split()[1].rstrip(",")) > 0.4
    assert second.split()[0] == "0.0"


def test_the_environment_gives_detections_and_keeps_its_truth_apart(
    capsys: pytest.CaptureFixture[str],
) -> None:
    exec(compile(blocks("python")[2], "README.md", "exec"), {})
    assert "(64, 4)" in capsys.readouterr().out


def test_the_camera_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "camera.toml"
    path.write_text(blocks("toml")[0])
    assert read_camera(path).camera.height == pytest.approx(1.65)


def test_every_command_and_option_that_is_shown_exists(
    capsys: pytest.CaptureFixture[str],
) -> None:
    from mot_sim.__main__ import main

    shown = [
        shlex.split(line, comments=True)[1:]
        for block in blocks("")
        for line in block.splitlines()
        if line.startswith("mot-sim ")
    ]
    assert shown
    for command in shown:
        assert main([command[0], "--help"]) == 0
        text = capsys.readouterr().out
        for word in command[1:]:
            assert not word.startswith("--") or word in text, f"{command[0]} has no {word}"


def test_every_file_that_is_linked_is_there() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", README) + ["CONTRIBUTING.md", "docs/paper.md"]:
        assert (ROOT / target).exists(), target
