"""The paper's tables: what is quoted is marked, what is measured is kept."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import kitti_sequence
from mot_sim.evaluation.runs import track_sequence
from mot_sim.experiments.paper import quoted
from mot_sim.experiments.paper.cue_sets import (
    PAPER_ROWS,
    UNGATED,
    in_frameworks,
    two_frame,
    with_cues,
)
from mot_sim.experiments.paper.made_rows import PairedScores, SyntheticBenchmark
from mot_sim.experiments.paper.rendering import interval_table, score_rows
from mot_sim.experiments.paper.studies import PaperConfig
from mot_sim.experiments.paper.tables import TABLES, server, verdict
from mot_sim.experiments.result_file import Result, made_here, read_result, write_result
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.tuning import measuring
from mot_sim.experiments.tuning.measuring import KittiBenchmark
from mot_sim.metrics import combine, evaluate_sequence
from mot_sim.simulation.sensors import find_profile
from tests.mot_sim.experiments.made import small_drives
from tracker import FRAMEWORKS, Tracker

TWO = (TrackerSpec("paper", "paper"), TrackerSpec("late", "paper", {"associate": "network_flow"}))


def test_a_measurement_is_the_trackers_score_and_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drives = small_drives(tmp_path / "drives", 2)
    found = KittiBenchmark(tmp_path).measure("test", drives, TWO)
    wanted = combine(
        [
            evaluate_sequence(
                drive.truth,
                track_sequence(Tracker.paper(drive.sequence.camera), drive.sequence)[0],
                drive.frame_count,
            )
            for drive in drives
        ]
    )
    assert found["paper"]["trackeval"].numbers() == wanted.numbers()
    assert found["paper"]["devkit2018"]["MOTA"] <= 1.0

    def refuse(*_: object) -> None:
        raise AssertionError("measured twice")

    monkeypatch.setattr(measuring, "_measured", refuse)
    again = KittiBenchmark(tmp_path).measure("test", drives, TWO)
    assert again["late"]["trackeval"].numbers() == found["late"]["trackeval"].numbers()


def test_quoted_rows_are_marked_and_have_every_column() -> None:
    for rows in (quoted.OVERALL, quoted.ABLATION, quoted.INTERSECTIONS):
        assert {len(row) for row in rows.values()} == {len(quoted.COLUMNS)}
    assert {len(row) for row in quoted.SERVER.values()} == {len(quoted.SERVER_COLUMNS)}
    table = score_rows("title", quoted.COLUMNS, {}, quoted.ABLATION)
    assert len(table.rows) == 10
    assert all(str(row[0]).startswith("* ") for row in table.rows)
    assert "| * RRC + all | 91.40 | 89.83 |" in table.as_markdown()
    assert "| 25,309 | 392 | 232 | 423 |" in table.as_markdown()


def test_the_server_table_is_quoted_only(tmp_path: Path) -> None:
    (table,) = server(PaperConfig(tmp_path, kitti=False))
    assert "| * the paper | 84.24 | 85.73 | 73.23 | 2.77 | 468 | 944 |" in table.as_markdown()
    assert list(TABLES) == ["I", "II", "III", "IV", "V"]


def test_appearance_alone_is_compared_over_nearly_the_whole_image(tmp_path: Path) -> None:
    drive = small_drives(tmp_path, 1)[0]
    rows = {row.name: row for row in two_frame(PAPER_ROWS)}
    assert [row.settings.get("sigmas") for row in rows.values()] == [UNGATED, *[None] * 4]
    open_gate = rows["appearance"].build(drive.sequence.camera)
    _, counts = track_sequence(open_gate, drive.sequence)
    assert counts.compared > 0.95 * counts.pairs > 0
    _, counts = track_sequence(rows["all"].build(drive.sequence.camera), drive.sequence)
    assert counts.compared < counts.pairs


def test_every_row_stands_in_every_framework() -> None:
    names = [each.name for each in in_frameworks({"a": "volume", "all": "volume+reprojection"})]
    assert names == [f"{row}, {each}" for row in ("a", "all") for each in FRAMEWORKS]


def test_a_profile_gets_only_the_cues_that_it_lacks(tmp_path: Path) -> None:
    made, rrc, cues = find_profile(with_cues("rrc", tmp_path)), find_profile("rrc"), None
    cues = find_profile("cues")
    assert made.jitter == rrc.jitter
    assert made.shape == cues.shape
    assert made.appearance == (rrc.appearance or cues.appearance)


def pooled(**values: list[float]) -> PairedScores:
    return PairedScores(
        {name: [{"MOTA": each, "IDSW": 10 * each} for each in row] for name, row in values.items()}
    )


def test_differences_are_taken_drive_by_drive() -> None:
    found = pooled(base=[0.2, 0.4, 0.9], new=[0.1, 0.3, 0.8])
    less = found.less("new", "base", "MOTA")
    assert less.mean == pytest.approx(-0.1)
    assert less.high == pytest.approx(-0.1)  # no doubt: always the same
    assert found.cut("new", "base", "IDSW") == pytest.approx(0.2)
    assert pooled(base=[0.0], new=[0.0]).cut("new", "base", "IDSW") is None
    text = interval_table("title", found, ("MOTA", "IDSW"), against="base").as_markdown()
    assert "-10.00 ±0.00" in text
    assert "MOTA - base" in text


def test_files_hold_every_digit_of_what_is_shown_rounded(tmp_path: Path) -> None:
    found = pooled(base=[0.2, 0.4, 0.9, 0.7, 0.1], new=[0.1, 0.35, 0.8, 1.0 / 3.0, 0.0])
    table = interval_table("title", found, ("MOTA", "IDSW"), against="base")
    write_result(tmp_path, Result("tables", "", made_here(), (replace(table, name="III.1"),)))
    (read,) = read_result(tmp_path).tables
    mean, less = found.mean("new", "MOTA"), found.less("new", "base", "MOTA")
    assert [read.column(f"MOTA{end}")[1] for end in ("", " low", " high")] == [*mean.cells]
    assert [read.column(f"MOTA - base{end}")[1] for end in ("", " low", " high")] == [*less.cells]
    assert read.column("MOTA - base")[0] is None
    assert read.column("IDSW") == (found.mean("base", "IDSW").mean, found.mean("new", "IDSW").mean)
    assert read.column("row") == ("base", "new")
    assert read.column("drives") == (5, 5)
    assert read.shown_columns[1].text(read.rows[1]) in table.as_markdown()
    assert table.note == ""
    few = interval_table("title", pooled(base=[0.2, 0.4]), ("MOTA",))
    assert few.as_markdown().endswith("\n2 drives: " + few.note.partition(": ")[2] + "\n")


def test_the_verdict_names_who_beats_all_cues() -> None:
    values = {f"{row}, {each}": 0.5 for row in ("2D-2D", "3D-3D") for each in FRAMEWORKS}
    best = {f"all, {each}": 0.6 for each in FRAMEWORKS}
    assert verdict(values | best) == "all beats every single cue in 4 of 4 frameworks"
    assert "3 of 4 frameworks; not in greedy (3D-3D)" in verdict(
        values | best | {"3D-3D, greedy": 0.7}
    )


@pytest.mark.kitti
def test_a_sample_is_some_frames_of_one_drive(kitti_root: Path, tmp_path: Path) -> None:
    studies = PaperConfig(tmp_path, kitti_root, sample_frames=6)
    (drive,) = studies.given_drives()
    first = kitti_sequence(kitti_root, "0000")
    frames = [frame.index for frame in drive.sequence]
    assert frames == list(range(frames[0], frames[0] + 6))
    assert set(drive.truth.frames.tolist()) <= set(frames)
    assert first.truth is not None
    cars = np.bincount(first.truth.frames[first.truth.kinds == "Car"])
    assert cars[frames[0]] == cars.max()
    whole = replace(studies, sample_frames=None)
    assert len(whole.sampled(first)) == len(first)


@pytest.mark.slow
def test_made_rows_share_their_drives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOT_SIM_CACHE", str(tmp_path / "shared"))
    stand = SyntheticBenchmark(tmp_path, ("crossing",), seeds=2, frames=6)
    found = stand.run("cues", two_frame({"a": "volume", "b": "appearance"}), "devkit2018", _silent)
    assert [row["seed"] for row in found.rows["a"]] == [0, 1]
    assert np.array_equal(
        [r["detections"] for r in found.rows["a"]], [r["detections"] for r in found.rows["b"]]
    )
    blind = stand.run(
        "cues", two_frame({"a": "volume"}), "devkit2018", _silent, {"odometry.dropouts": 1.0}
    )
    assert len(blind.rows["a"]) == 2
    assert len(list((tmp_path / "trials").rglob("*.json"))) == 4 + 2  # other trials, same drives
    assert len(list((tmp_path / "shared").rglob("truth/*.npz"))) == 2


def _silent(what: str, done: int, total: int) -> None:
    del what, done, total
