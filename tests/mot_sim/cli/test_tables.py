"""`mot-sim tables`: the paper's rows beside ours."""

from pathlib import Path

import pytest

from tests.mot_sim.cli.conftest import NAMES, CommandLine


def test_tables_one_and_two_on_a_tree(mot_sim: CommandLine, tree: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    told = mot_sim("tables", "--table", "I", "II", "--root", tree, "--out", out)
    assert told.code == 0, told.err
    text = (out / "tables/I.md").read_text()
    assert "| ours: default | 100.00 |" in text
    assert "| * the paper, all 21 | 91.40 |" in text
    assert "rules TrackEval" in text
    written = sorted(path.stem for path in (out / "server/training").glob("*.txt"))
    assert written == list(NAMES)
    assert "| * the paper | 84.24 |" in (out / "tables/II.md").read_text()
    assert mot_sim("tables", "--table", "II", "--root", tree, "--out", out).code == 0


@pytest.mark.slow
def test_table_four_without_kitti(mot_sim: CommandLine, tmp_path: Path) -> None:
    line = ["tables", "--table", "IV", "--quick", "--scenes", "crossing", "--out", tmp_path / "out"]
    told = mot_sim(*line)
    assert told.code == 0, told.err
    assert "no KITTI tree" in told.err
    text = (tmp_path / "out/tables/IV.md").read_text()
    assert "| 2D-2D + shape and pose |" in text
    assert "2 seeds each" in text


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--table", "VI"], "unknown table 'VI'"),
        (["--table", "IV", "--seeds", "0"], "--seeds 0: give 1 or more"),
        (["--table", "IV", "--scenes", "crosing"], "Did you mean 'crossing'?"),
    ],
)
def test_bad_input_is_one_line(
    mot_sim: CommandLine, tmp_path: Path, more: list[str], told: str
) -> None:
    found = mot_sim("tables", "--out", tmp_path / "out", *more)
    assert found.code == 2
    assert told in found.err
