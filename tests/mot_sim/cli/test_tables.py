"""`mot-sim tables`: the paper's rows beside ours."""

from pathlib import Path

import pytest

from mot_sim.cli.tables import FORM_ONLY, QUICK_SEEDS
from mot_sim.experiments.result_file import read_result
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


def test_quick_tables_show_their_form_and_no_result(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    told = mot_sim("tables", "--table", "I", "II", "--quick", "--root", tree, "--out", out)
    assert told.code == 0, told.err
    assert "what was measured is no result" in " ".join(told.err.split())
    for name in ("I", "II"):
        assert (
            (out / "tables" / f"{name}.md").read_text().startswith(f"**{FORM_ONLY}: Table {name}")
        )
    result = read_result(out)
    assert result.made.form_only
    assert all(table.title.startswith(FORM_ONLY) for table in result.tables)
    assert "ours on 1 given drives" in result.tables[0].title  # of two with labels
    assert not (out / "server").exists()
    whole = mot_sim("tables", "--table", "I", "--root", tree, "--out", tmp_path / "whole")
    assert whole.code == 0
    assert FORM_ONLY not in whole.out
    assert not read_result(tmp_path / "whole").made.form_only


def test_quick_table_four_without_kitti(mot_sim: CommandLine, tmp_path: Path) -> None:
    line = ["tables", "--table", "IV", "--quick", "--scenes", "crossing", "--out", tmp_path / "out"]
    told = mot_sim(*line)
    assert told.code == 0, told.err
    assert "no KITTI tree" in told.err
    text = (tmp_path / "out/tables/IV.md").read_text()
    assert "| 2D-2D + shape and pose |" in text
    assert f"{QUICK_SEEDS} seeds each" in text


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
