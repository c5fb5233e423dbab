"""The ratios that benchmarks keep."""

import json
from pathlib import Path

import pytest

from benchmarks.baseline import FILE, Ratios


def test_ratios_stand_beside_those_kept_and_are_kept_row_by_row(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "baseline.json"
    file.write_text(json.dumps({"speed": {"default": 10.0, "paper": 5.0}, "world": {"town": 2.0}}))
    ratios = Ratios("speed")
    assert ratios.add("default", 30.0, 2.0) == 15.0
    ratios.add("new", 1.0, 4.0)
    ratios.tell(False, file)
    lines = capsys.readouterr().out.splitlines()
    assert lines[-2].split() == ["default", "10.000", "15.000", "1.50"]
    assert lines[-1].split() == ["new", "-", "0.250", "-"]
    assert json.loads(file.read_text())["speed"] == {"default": 10.0, "paper": 5.0}
    ratios.tell(True, file)
    assert json.loads(file.read_text()) == {
        "speed": {"default": 15.0, "new": 0.25, "paper": 5.0}, "world": {"town": 2.0}
    }  # fmt: skip


def test_a_first_run_keeps_its_ratios(tmp_path: Path) -> None:
    ratios = Ratios("truth")
    ratios.add("labels", 1.0, 3.0)
    ratios.tell(True, tmp_path / "baseline.json")
    assert json.loads((tmp_path / "baseline.json").read_text()) == {"truth": {"labels": 0.3333}}


def test_the_kept_ratios_are_of_benchmarks_that_keep_ratios() -> None:
    for name, rows in json.loads(FILE.read_text()).items():
        assert "Ratios.add_option(parser)" in FILE.with_name(f"{name}.py").read_text()
        assert rows
        assert all(ratio > 0.0 for ratio in rows.values())
