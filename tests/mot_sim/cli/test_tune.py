"""`mot-sim tune`: the fold table, the chosen weights, going on, and what is refused."""

import json
from pathlib import Path

import pytest

from tests.mot_sim.cli.conftest import CommandLine


def options(tree: Path, out: Path) -> list[object]:
    return ["--root", tree, "--folds", 2, "--samples", 2, "--out", out]


def test_it_prints_folds_and_weights_and_goes_on(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    line = ["tune", "--costs", "volume,reprojection=2", "--tracker", "paper"]
    line += options(tree, tmp_path / "out")
    told = mot_sim(*line)
    assert told.code == 0, told.err
    assert "0030" in told.out
    assert "all, mean weights" in told.out
    assert "--costs " in told.out
    assert "HOTA of all drives" in told.out
    again = mot_sim(*line, "--json", "-")
    assert "0 of them weighed now" in again.err
    content = json.loads(again.out)
    assert sum(cost["weight"] for cost in content["costs"].values()) == pytest.approx(1.0)
    assert [fold["held_out_drives"] for fold in content["folds"]] in (
        [["0030"], ["0031"]], [["0031"], ["0030"]],
    )  # fmt: skip


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--costs", "volume=-1,reprojection=2"], "none below 0 and not all of them 0"),
        (["--costs", "volume=0,reprojection=0"], "none below 0 and not all of them 0"),
        (["--costs", "volume=nan"], "write volume=0.6,reprojection=0.4"),
        (["--costs", "volum"], "Did you mean 'volume'?"),
        (["--costs", "appearance"], "the cost 'appearance' needs descriptors"),
        (["--costs", "volume", "--folds", "3"], "3 folds, but only 2 of 2 sequences hold"),
        (["--costs", "volume", "--sequences", "0032"], "sequence 0032: no labels"),
        (["--costs", "volume", "--objective", "IDF1"], "objective IDF1: give HOTA or MOTA"),
        (["--costs", "volume", "--rules", "devkit2018"], "have no HOTA: give --objective MOTA"),
        (["--costs", "volume", "--tracker", "papr"], "papr"),
        (["--costs", "volume", "--jobs", "0"], "--jobs 0: give 1 or more"),
        (["--costs", "volume", "--scene", "crosing"], "Did you mean 'crossing'?"),
    ],
)
def test_bad_input_is_one_line(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, more: list[str], told: str
) -> None:
    found = mot_sim("tune", *options(tree, tmp_path / "out"), *more)
    assert found.code == 2
    assert told in found.err
    assert len(found.err.strip().split("\n")) == 1
