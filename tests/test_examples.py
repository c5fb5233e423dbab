"""Every script of `examples/` runs as it stands and prints what its last comment claims."""

import ast
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TRAINING = "train_association"  # needs minutes and an extra: tests of its own
EXAMPLES = {
    path.stem: path for path in sorted((ROOT / "examples").glob("*.py")) if path.stem != TRAINING
}
PRINTED = "# Printed:\n"  # begins the comment at the end of a script
PICTURES = {"noise_sweep": "noise_sweep.png", "own_scene": "own_scene.png"}


def run(name: str, folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a script in a folder of its own; variables: of its environment, beside ours."""
    ours = {key: value for key, value in os.environ.items() if key != "MOT_SIM_KITTI_ROOT"}
    return subprocess.run(
        [sys.executable, str(EXAMPLES[name])],
        cwd=folder, env={**ours, "PYTHONPATH": str(ROOT), "COLUMNS": "60", **variables},
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip


def claimed(name: str) -> str:
    """What the comment at the end of a script says that it printed."""
    _, found, comment = EXAMPLES[name].read_text(encoding="utf-8").rpartition(PRINTED)
    assert found, f"{name}: no comment that begins with {PRINTED!r}"
    lines = comment.splitlines(keepends=True)
    assert all(line.startswith("# ") for line in lines), f"{name}: the comment is not the end"
    return "".join(line.removeprefix("# ") for line in lines)


@pytest.mark.parametrize("name", sorted(EXAMPLES.keys() - {"kitti"}))
def test_an_example_prints_what_it_claims(name: str, tmp_path: Path) -> None:
    done = run(name, tmp_path)
    assert (done.returncode, done.stdout) == (0, claimed(name)), done.stderr
    written = {path.name for path in tmp_path.iterdir()}
    assert written == ({PICTURES[name]} if name in PICTURES else set())


@pytest.mark.kitti
def test_the_kitti_example_prints_what_it_claims(tmp_path: Path, kitti_root: Path) -> None:
    done = run("kitti", tmp_path, MOT_SIM_KITTI_ROOT=str(kitti_root))
    assert (done.returncode, done.stdout) == (0, claimed("kitti")), done.stderr


def test_the_kitti_example_says_what_is_missing(tmp_path: Path) -> None:
    without = run("kitti", tmp_path)
    assert (without.returncode, without.stdout) == (2, "")
    assert "MOT_SIM_KITTI_ROOT" in without.stderr
    wrong = run("kitti", tmp_path, MOT_SIM_KITTI_ROOT=str(tmp_path))
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert str(tmp_path) in wrong.stderr
    assert "Traceback" not in without.stderr + wrong.stderr


def test_the_examples_are_short_and_say_what_they_show() -> None:
    assert len(EXAMPLES) == 8
    for name, path in EXAMPLES.items():
        text = path.read_text(encoding="utf-8")
        assert 20 <= len(text.splitlines()) <= 60, name
        assert ast.get_docstring(ast.parse(text)), name
        assert claimed(name), name


def train(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Train who is who, as little as can be."""
    return subprocess.run(
        [sys.executable, str(ROOT / "examples" / f"{TRAINING}.py"), *options],
        cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip


@pytest.mark.skipif(find_spec("sb3_contrib") is not None, reason="the extra rl is installed")
def test_training_says_what_is_missing(tmp_path: Path) -> None:
    done = train(tmp_path)
    assert done.returncode == 1
    assert "pip install 'mot-sim[rl]'" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
@pytest.mark.skipif(find_spec("sb3_contrib") is None, reason="needs the extra rl")
def test_who_is_who_is_learned_and_what_is_learned_is_kept(tmp_path: Path) -> None:
    little = ("--frames", "30", "--episodes", "4", "--learners", "cloned", "improved")
    done = train(tmp_path, *little, "--steps", "512", "--out", "kept")
    assert done.returncode == 0, done.stderr
    assert {path.name for path in (tmp_path / "kept").iterdir()} == {"cloned.zip", "improved.zip"}
    rows = [line for line in done.stdout.splitlines() if line.startswith("| ")]
    assert [row.split(" | ")[0].strip("| ") for row in rows] == [
        "policy", "random", "random within the masks", "greedy", "Hungarian", "cloned", "improved",
    ]  # fmt: skip
    shares = {row.split(" | ")[0].strip("| "): float(row.split()[-2]) for row in rows[1:]}
    assert shares["cloned"] > 0.9
    assert shares["random"] < 0.5
