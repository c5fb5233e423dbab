"""`mot-sim report`: pages of what the other commands left, and what is refused."""

from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest

from mot_sim.experiments.result_file import read_result, write_result
from mot_sim.experiments.sweep.groups import JobGroup
from mot_sim.experiments.sweep.trial import JobDone
from tests.mot_sim.cli.conftest import CommandLine
from tests.mot_sim.report.page.made import stress_result, write_every
from tests.mot_sim.report.page.pages import Page

BARE = ("--set", "scene.houses=0", "--set", "scene.trees=0", "--set", "scene.furniture=0")
SWEEP = ("sweep", "--scene", "crossing", "--seeds", 2, "--frames", 4, *BARE)


def page_of(path: Path) -> str:
    """All text of a page, on one line."""
    return " ".join(Page(path.read_text()).root.text.split())


def test_a_sweep_and_a_search_leave_what_the_report_shows(
    mot_sim: CommandLine, tmp_path: Path
) -> None:
    axis = ("--axis", "detector.jitter=0,2", "--out", tmp_path / "out/jitter")
    assert mot_sim(*SWEEP, *axis).code == 0
    result = read_result(tmp_path / "out/jitter")
    assert (result.made.finished, result.made.trials) == (True, (8, 8))
    assert [table.name for table in result.tables] == ["means", "differences", "design"]
    search = (
        "breaking-point", "--axis", "detector.jitter", "--to", 2, "--trackers", "default",
        "--seeds", 2, "--frames", 4, "--scene", "crossing", *BARE, "--out", tmp_path / "out/where",
    )  # fmt: skip
    assert mot_sim(*search).code == 0
    assert [table.name for table in read_result(tmp_path / "out/where").tables] == [
        "points", "curves",
    ]  # fmt: skip
    told = mot_sim("report", tmp_path / "out", "--out", tmp_path / "r.html", "--title", "Noise")
    assert told.code == 0, told.err
    assert told.out.startswith(f"{tmp_path}/r.html: 2 results, ")
    text = page_of(tmp_path / "r.html")
    assert "All 8 trials are finished." in text
    assert "Levels of detector.jitter that cost 5 points of HOTA" in text
    assert "axis detector.jitter 0, 2" in text


def test_a_stress_test_leaves_its_verdicts(mot_sim: CommandLine, tmp_path: Path) -> None:
    suites = tmp_path / "suites.toml"
    suites.write_text(
        '[easy]\nabout = "an open road"\nscene = "crossing"\nframes = 4\n'
        'settings = { "scene.houses" = 0.0, "scene.trees" = 0.0, "scene.furniture" = 0.0 }\n'
        "bounds = { HOTA = 0.01, IDSW = 9.0 }\n"
    )
    line = ("stress", "--file", suites, "--seeds", 2, "--out", tmp_path / "out")
    assert mot_sim(*line).code == 0
    result = read_result(tmp_path / "out")
    table = result.table("verdicts")
    assert table is not None
    assert table.column("verdict") == ("pass", "pass")
    assert result.made.trials == (2, 2)
    assert mot_sim(*line, "--measure").code == 0
    measured = read_result(tmp_path / "out").table("verdicts")
    assert measured is not None
    assert set(measured.column("verdict")) == {None}


def test_a_comparison_and_the_tables_leave_their_rows(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    compare = ("compare", "--root", tree, "--trackers", "default,iou", "--out", out / "peers")
    assert mot_sim(*compare).code == 0
    scores = read_result(out / "peers").table("scores")
    assert scores is not None
    assert scores.column("tracker") == ("default", "iou")
    assert scores.column("MOTA") == (1.0, 1.0)
    told = mot_sim("tables", "--table", "I", "II", "--root", tree, "--out", out / "tables")
    assert told.code == 0, told.err
    tables = read_result(out / "tables").tables
    assert [table.name for table in tables] == ["I.1", "I.2", "II.3"]
    assert tables[0].column("MOTA")[0] == 1.0
    tune = ("tune", "--costs", "volume,reprojection", "--tracker", "paper", "--root", tree,
            "--samples", 0, "--folds", 2, "--out", out / "weights")  # fmt: skip
    assert mot_sim(*tune).code == 0
    weights = read_result(out / "weights").table("weights")
    assert weights is not None
    assert weights.column("cost") == ("volume", "reprojection")
    told = mot_sim("report", out, "--out", tmp_path / "r.html")
    assert told.code == 0, told.err
    assert "Table I, rules devkit2018" in page_of(tmp_path / "r.html")


def test_a_sweep_that_was_interrupted_is_shown_as_far_as_it_is(
    mot_sim: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    axis = ("--axis", "detector.jitter=0,1,2", "--out", tmp_path / "out")
    running = import_module("mot_sim.experiments.sweep.running")
    real, groups = running.run_group, []

    def ctrl_c_after_one(group: JobGroup) -> JobDone:
        if groups:
            raise KeyboardInterrupt
        groups.append(group)
        return real(group)

    monkeypatch.setattr(running, "run_group", ctrl_c_after_one)
    assert mot_sim(*SWEEP, *axis).code == 130
    told = mot_sim("report", tmp_path / "out", "--out", tmp_path / "r.html")
    assert told.code == 0, told.err
    assert "4 of 12 trials are finished; what is there is shown." in page_of(tmp_path / "r.html")
    assert "not finished" in page_of(tmp_path / "r.html")
    monkeypatch.undo()
    assert mot_sim(*SWEEP, *axis).code == 0
    assert mot_sim("report", tmp_path / "out", "--out", tmp_path / "r.html").code == 2
    assert mot_sim(
        "report", tmp_path / "out", "--out", tmp_path / "r.html", "--overwrite"
    ).code == 0  # fmt: skip
    assert "All 12 trials are finished." in page_of(tmp_path / "r.html")


def test_what_does_not_fit_is_named(mot_sim: CommandLine, tmp_path: Path) -> None:
    write_result(tmp_path / "out", replace(stress_result(), files=("gone.png",)))
    told = mot_sim("report", tmp_path / "out", "--out", tmp_path / "r.html")
    assert told.code == 0
    assert "left out of the page:" in told.err
    assert "gone.png" in told.err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), "nothing to report: name folders"),
        (("nowhere",), "no such folder; name a folder that a command got as --out"),
        (("empty",), "nothing of ours: no result.json, sweep.json, run.json"),
        (("damaged",), "result.json:1: damaged"),
        (("old",), "a result of format 0, this mot-sim reads 1"),
        (("stress", "--out", "r.pdf"), "ends in .html"),
        (("stress", "--out", "there.html"), "--overwrite replaces it"),
        (("stress", "--figures", "stress"), "not empty"),
        (("stress", "--out", "there.html/r.html"), "is no folder that can be written to"),
    ],
)
def test_wrong_input_is_one_line(
    mot_sim: CommandLine,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    options: tuple[str, ...],
    words: str,
) -> None:
    write_every(tmp_path)
    for name, content in (("damaged", "{"), ("old", '{"format": 0}')):
        (tmp_path / name).mkdir()
        (tmp_path / name / "result.json").write_text(content)
    (tmp_path / "empty").mkdir()
    (tmp_path / "there.html").write_text("mine")
    monkeypatch.chdir(tmp_path)
    told = mot_sim("report", *options)
    assert told.code == 2
    assert told.err.startswith("error: ")
    assert words in " ".join(told.err.split())
    assert told.err.count("\n") == 1
    assert not (tmp_path / "report.html").exists()
    assert (tmp_path / "there.html").read_text() == "mine"
