"""`mot-sim evaluate`, `kitti` and `export`: from result files to tables and folders."""

import csv
import io
import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import kitti_sequence, read_results, write_results
from tests.mot_sim.cli.conftest import FRAMES, CommandLine, files, labels, write
from tracker.types import CarEstimates

BOXES = 4 * FRAMES  # two cars in each of two labelled sequences
TITLES = ["HOTA", "DetA", "AssA", "MOTA", "MOTP", "IDF1", "recall", "precision"]
TITLES += ["TP", "FP", "FN", "IDSW", "Frag", "MT", "PT", "ML"]
CLEAR_ONLY = [title for title in TITLES if title not in ("HOTA", "DetA", "AssA", "IDF1")]


@pytest.fixture
def results(tmp_path: Path) -> Path:
    """Perfect results of all three sequences; in 0031 one car changes its name half way."""
    swapped = labels().replace("\n1 1 ", "\n1 8 ").replace("\n2 1 ", "\n2 8 ")
    for name, text in {"0030": labels(), "0031": swapped, "0032": labels()}.items():
        write(tmp_path / "results" / f"{name}.txt", text)
    return tmp_path / "results"


def test_the_table_has_a_row_a_sequence_and_one_for_all(
    mot_sim: CommandLine, tree: Path, results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    outcome = mot_sim("evaluate", results, "--root", tree)
    assert outcome.code == 0
    assert outcome.err == "left out, for want of labels: 0032\n"
    lines = [line.split() for line in outcome.out.split("\n") if line.strip()]
    assert lines[1] == ["sequence", *TITLES]
    rows = {line[0]: line[1:] for line in lines[3:]}
    assert list(rows) == ["0030", "0031", "combined"]
    assert rows["0030"] == ["100.00"] * 8 + [str(2 * FRAMES), "0", "0", "0", "0", "2", "0", "0"]
    # A name changes at two of the labels: there and back.
    assert rows["combined"][3] == f"{100 * (1 - 2 / BOXES):.2f}"
    assert rows["combined"][8:13] == [str(BOXES), "0", "0", "2", "0"]


def test_at_80_columns_the_rates_stand_above_the_counts(
    mot_sim: CommandLine, tree: Path, results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "dumb")  # without colours
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    outcome = mot_sim("evaluate", results, "--root", tree)
    assert max(len(line) for line in outcome.out.split("\n")) <= 80
    assert "…" not in outcome.out
    for title in TITLES:
        assert f" {title} " in outcome.out
    assert outcome.out.count("combined") == 2


def test_a_pipe_has_no_width(mot_sim: CommandLine, tree: Path, results: Path) -> None:
    outcome = mot_sim("evaluate", results, "--root", tree)
    (head,) = [line.split() for line in outcome.out.split("\n") if "sequence" in line.split()]
    assert head == ["sequence", *TITLES]
    assert outcome.out.count("combined") == 1


def test_csv_and_json_hold_every_digit_as_fractions(
    mot_sim: CommandLine, tree: Path, results: Path, tmp_path: Path
) -> None:
    table = mot_sim("evaluate", results, "--root", tree, "--csv", "-").out
    rows = list(csv.DictReader(io.StringIO(table)))
    assert list(rows[0]) == ["sequence", *TITLES]
    assert float(rows[-1]["MOTA"]) == 1 - 2 / BOXES
    content = json.loads(mot_sim("evaluate", results, "--root", tree, "--json", "-").out)
    assert content["rules"] == "trackeval"
    assert content["combined"]["MOTA"] == 1 - 2 / BOXES
    assert content["sequences"]["0031"]["IDSW"] == 2
    kept = ["--csv", tmp_path / "new" / "s.csv", "--json", tmp_path / "s.json"]
    outcome = mot_sim("evaluate", results, "--root", tree, *kept)
    assert "combined" in outcome.out
    assert (tmp_path / "new" / "s.csv").read_text() == table
    assert json.loads((tmp_path / "s.json").read_text()) == content
    both = mot_sim("evaluate", results, "--root", tree, "--csv", "-", "--json", "-")
    assert (both.code, both.out) == (2, "")


def test_the_rules_of_2018_know_only_clear_scores(
    mot_sim: CommandLine, tree: Path, results: Path
) -> None:
    rules = ["--rules", "devkit2018", "--csv", "-"]
    rows = list(
        csv.DictReader(io.StringIO(mot_sim("evaluate", results, "--root", tree, *rules).out))
    )
    assert list(rows[0]) == ["sequence", *CLEAR_ONLY]
    assert rows[0]["MOTA"] == "1.0"


def test_what_is_left_out_of_the_sum_is_said(
    mot_sim: CommandLine, tree: Path, results: Path
) -> None:
    (results / "0031.txt").unlink()
    write(results / "notes.txt", "not results")
    outcome = mot_sim("evaluate", results, "--root", tree)
    assert outcome.code == 0
    assert "warning: no results for 0031, which have labels: not in the sum\n" in outcome.err
    assert "notes.txt is of no sequence of this tree" in outcome.err
    chosen = mot_sim("evaluate", results, "--root", tree, "--sequences", "0030")
    assert (chosen.code, chosen.err) == (0, "")


def test_results_in_a_folder_called_data_are_found(
    mot_sim: CommandLine, tree: Path, results: Path, tmp_path: Path
) -> None:
    (tmp_path / "tracker").mkdir()
    results.rename(tmp_path / "tracker" / "data")
    assert mot_sim("evaluate", tmp_path / "tracker", "--root", tree).code == 0


def test_kitti_tracks_and_scores_the_labelled_sequences(mot_sim: CommandLine, tree: Path) -> None:
    outcome = mot_sim("kitti", "--root", tree)
    assert (outcome.code, outcome.err) == (0, "")
    assert "default: rrc boxes, ego oxts, rules trackeval, rates in %" in outcome.out
    assert "0031" in outcome.out
    assert "0032" not in outcome.out
    content = json.loads(mot_sim("kitti", "--root", tree, "--json", "-").out)
    assert content["default"]["combined"]["MOTA"] == 1.0


def test_kitti_gives_several_trackers_a_row_each(mot_sim: CommandLine, tree: Path) -> None:
    several = ["--trackers", "default,paper,default", "--csv", "-"]
    outcome = mot_sim("kitti", "--root", tree, *several)
    rows = list(csv.DictReader(io.StringIO(outcome.out)))
    assert [row["tracker"] for row in rows] == ["default", "paper"]
    assert {row["TP"] for row in rows} == {str(BOXES)}


def test_kitti_keeps_results_only_when_told_where(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    mot_sim("kitti", "--root", tree)
    assert files(tmp_path / "here") == []
    keep = ["--trackers", "paper", "--out", tmp_path / "kept", "--sequences", "all"]
    outcome = mot_sim("kitti", "--root", tree, *keep, "--csv", "-")
    assert outcome.err == "left out, for want of labels: 0032\n"
    names = ["0030.txt", "0031.txt", "0032.txt", "run.json"]
    assert files(tmp_path / "kept" / "paper") == names
    again = mot_sim("kitti", "--root", tree, *keep, "--resume", "--csv", "-")
    assert again.out == outcome.out
    judged = mot_sim("evaluate", tmp_path / "kept" / "paper", "--root", tree, "--csv", "-")
    assert judged.out == outcome.out


def test_export_to_motchallenge_counts_from_one(
    mot_sim: CommandLine, tree: Path, results: Path, tmp_path: Path
) -> None:
    out = tmp_path / "mot"
    outcome = mot_sim("export", results, out, "--to", "motchallenge", "--root", tree)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out == f"{out}: 3 sequences for motchallenge\n"
    assert files(out / "0030") == ["det/det.txt", "gt/gt.txt", "res/res.txt", "seqinfo.ini"]
    assert files(out / "0032") == ["det/det.txt", "res/res.txt", "seqinfo.ini"]
    first = (out / "0030" / "res" / "res.txt").read_text().split(",")[:6]
    assert [float(value) for value in first] == [1, 1, 500, 200, 60, 40]
    assert mot_sim("export", results, out, "--to", "motchallenge", "--root", tree).code == 2


def test_export_to_trackeval_needs_labels_but_no_detections(
    mot_sim: CommandLine, tree: Path, results: Path, tmp_path: Path
) -> None:
    for name in ("0030", "0031", "0032"):
        (tree / "detections" / "rrc" / f"{name}.txt").unlink()
    out = tmp_path / "te"
    name = ["--name", "ours"]
    outcome = mot_sim("export", results, out, "--to", "trackeval", "--root", tree, *name)
    assert outcome.code == 0
    assert outcome.err == "left out, for want of labels: 0032\n"
    assert files(out) == [
        "gt/evaluate_tracking.seqmap.training",
        "gt/label_02/0030.txt",
        "gt/label_02/0031.txt",
        "trackers/ours/data/0030.txt",
        "trackers/ours/data/0031.txt",
    ]
    seqmap = (out / "gt" / "evaluate_tracking.seqmap.training").read_text()
    assert seqmap.split("\n")[0] == f"0030 empty 000000 {FRAMES:06d}"
    alone = ["--sequences", "0032", "--to", "trackeval", "--root", tree]
    assert mot_sim("export", results, tmp_path / "none", *alone).code == 2
    assert not (tmp_path / "none").exists()


# A car 4 m long, ahead of us and facing our way; and where the results put it.
IN_2D = labels().replace("1.5 1.6 4 0 1.65 20 -1.5", "-1 -1 -1 -1000 -1000 -1000 -10")
CUBOID_3D = "1.5 2 4 {x} 1.65 {z} -1.5707963"


def rows_in_3d(ahead: float = 0.0, **changed: str) -> str:
    """Two cars 8 m apart in every frame, `ahead` too far; changed: columns of one row."""
    lines = []
    for frame in range(FRAMES):
        for car in (0, 1):
            cuboid = CUBOID_3D.format(x=8 * car - 4, z=20 + ahead)
            box = f"{100 + 200 * car} 100 {200 + 200 * car} 160"
            lines.append(f"{frame} {car} Car 0 0 -1.5 {box} {cuboid}")
    if changed:
        fields = lines[3].split()
        for name, value in changed.items():
            fields[["h", "w", "l", "x", "y", "z", "ry"].index(name) + 10] = value
        lines[3] = " ".join(fields)
    return "\n".join(lines) + "\n"


@pytest.fixture
def made_tree(tree: Path) -> Path:
    """The tree, with labels that have cuboids."""
    for name in ("0030", "0031"):
        write(tree / "training/label_02" / f"{name}.txt", rows_in_3d())
    return tree


def in_3d(folder: Path, second: str) -> Path:
    write(folder / "0030.txt", rows_in_3d())
    write(folder / "0031.txt", second)
    return folder


def test_cuboids_are_scored(mot_sim: CommandLine, made_tree: Path, tmp_path: Path) -> None:
    folder = in_3d(tmp_path / "found", rows_in_3d(ahead=1.0))  # 3D IoU 3/5
    content = tmp_path / "scores.json"
    outcome = mot_sim(
        "evaluate", folder, "--root", made_tree, "--3d", "--thresholds", ".5,.7,2m",
        "--json", content, "--csv", "-",
    )  # fmt: skip
    assert outcome.code == 0
    rows = {row["sequence"]: row for row in csv.DictReader(io.StringIO(outcome.out))}
    assert float(rows["0031"]["MOTA3D@0.5"]) == 1.0
    assert float(rows["0031"]["MOTA3D@0.7"]) == -1.0
    assert float(rows["combined"]["MOTA3D@0.7"]) == 0.0
    assert float(rows["0031"]["centre_median"]) == pytest.approx(1.0)
    assert float(rows["combined"]["parked_over_1mps"]) == 0.0
    told = json.loads(content.read_text())
    assert list(told["combined"]["ab3dmot"]) == ["0.5", "0.7", "2m"]
    assert told["sequences"]["0031"]["clear"]["0.5"]["CLR_TP"] == 2 * FRAMES
    shown = mot_sim("evaluate", folder, "--root", made_tree, "--3d").out
    for word in ("3D IoU 0.7", "oncoming", "30-50 m", "combined"):
        assert word in shown


def test_stated_uncertainties_in_files_are_held_against_the_truth(
    mot_sim: CommandLine, made_tree: Path, tmp_path: Path
) -> None:
    folder = in_3d(tmp_path / "found", rows_in_3d(ahead=1.0))
    drive = kitti_sequence(made_tree, "0031", None, ego="none")
    tracks = read_results(folder / "0031.txt", drive.T_road_label)
    assert tracks.cuboids is not None
    base, size = tracks.cuboids.base, np.log(tracks.cuboids.size)
    means = np.column_stack([base, tracks.cuboids.yaw, base[:, 0] * 0.0, size, base[:, 0] * 0.0])
    covs = np.tile(0.64 * np.eye(9), (len(tracks), 1, 1))  # 1 m off is 1.25 sigma
    states = CarEstimates(means, covs, np.full(len(tracks), 0.9))
    write_results(tracks.replaced(estimates=states), folder / "0031.txt", drive.T_road_label)
    shown = mot_sim("evaluate", folder, "--root", made_tree, "--3d").out
    (line,) = [line.split() for line in shown.splitlines() if line.strip().startswith("centre  ")]
    # Rows, inside 1 sigma, ideal, inside 2 sigma, ideal, NEES, ideal.
    assert line[1:] == [str(2 * FRAMES), "0.00", "39.35", "100.00", "86.47", "1.56", "2"]


@pytest.mark.parametrize(
    ("second", "told"),
    [
        (IN_2D, r"0031.txt: none of 8 rows has a cuboid .* score it in 2D"),
        (rows_in_3d(h="0"), r"0031.txt:4: a size that is not positive: h 0, .* or -1 -1 -1"),
        (rows_in_3d(w="-1"), r"0031.txt:4: a size that is not positive: .* w -1,"),
        (rows_in_3d(z="-20"), r"0031.txt:4: a cuboid wholly behind the camera: z -20"),
        (rows_in_3d(ry="nan"), r"0031.txt:4: rotation_y is not finite: rotation_y nan"),
        (rows_in_3d(l="inf"), r"0031.txt:4: l is not finite"),
    ],
)
def test_results_that_cannot_be_scored_in_3d_are_named(
    mot_sim: CommandLine, made_tree: Path, tmp_path: Path, second: str, told: str
) -> None:
    folder = in_3d(tmp_path / "found", second)
    outcome = mot_sim("evaluate", folder, "--root", made_tree, "--3d")
    assert outcome.code == 2
    assert re.search(told, outcome.err), outcome.err


def test_headings_beyond_pi_are_wrapped_and_unknown_ones_left_out(
    mot_sim: CommandLine, made_tree: Path, tmp_path: Path
) -> None:
    turned = rows_in_3d().replace(" -1.5707963", " 4.712389")  # the same heading
    folder = in_3d(tmp_path / "found", turned.replace(" 4.712389", " -10", 1))
    outcome = mot_sim("evaluate", folder, "--root", made_tree, "--3d", "--json", "-")
    scores = json.loads(outcome.out)["sequences"]["0031"]
    assert scores["errors"]["heading_over_30"] == 0.0
    assert scores["clear"]["0.7"]["CLR_TP"] == 2 * FRAMES - 1
    assert scores["clear"]["2m"]["CLR_TP"] == 2 * FRAMES


def test_labels_without_cuboids_are_named(mot_sim: CommandLine, tree: Path, tmp_path: Path) -> None:
    write(tree / "training/label_02/0030.txt", IN_2D)
    folder = in_3d(tmp_path / "found", rows_in_3d())
    outcome = mot_sim("evaluate", folder, "--root", tree, "--3d")
    assert outcome.code == 2
    assert "label_02/0030.txt: no label has a cuboid" in outcome.err


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (["--3d", "--thresholds", "1.5"], "3D threshold 1.5: IoU thresholds are in (0, 1]"),
        (["--3d", "--thresholds", ".5,0m"], "3D threshold 0: distances are above 0 m"),
        (["--3d", "--thresholds", ".5,0.5"], "write each once"),
        (["--3d", "--classes", "car,pedestrian"], "with --3d one class at a time"),
        (["--3d", "--rules", "devkit2018"], "with --3d one class at a time"),
        (["--3d", "--truth", "gt.csv"], "--3d needs a KITTI tree"),
        (["--thresholds", ".5"], "--thresholds .5: only cuboids are scored by it; add --3d"),
        (["--ego", "oxts"], "--ego oxts: only cuboids are scored by it; add --3d"),
    ],
)
def test_options_that_do_not_go_together_in_3d(
    mot_sim: CommandLine, made_tree: Path, tmp_path: Path, given: list[str], told: str
) -> None:
    folder = in_3d(tmp_path / "found", rows_in_3d())
    outcome = mot_sim("evaluate", folder, "--root", made_tree, *given)
    assert outcome.code == 2
    assert told in outcome.err


def test_without_oxts_nobody_knows_who_moves(
    mot_sim: CommandLine, made_tree: Path, tmp_path: Path
) -> None:
    for name in ("0030", "0031"):
        (made_tree / "training/oxts" / f"{name}.txt").unlink()
    folder = in_3d(tmp_path / "found", rows_in_3d())
    outcome = mot_sim("evaluate", folder, "--root", made_tree, "--3d", "--json", "-")
    assert "no oxts/, so nobody knows which cars move" in outcome.err
    assert json.loads(outcome.out)["combined"]["errors"]["parked_over_1mps"] is None


def test_a_tracker_is_scored_in_3d_at_once(mot_sim: CommandLine, made_tree: Path) -> None:
    outcome = mot_sim("kitti", "--root", made_tree, "--3d", "--thresholds", ".5,2m", "--json", "-")
    assert outcome.code == 0
    told = json.loads(outcome.out)
    assert list(told["sequences"]) == ["0030", "0031"]
    assert told["combined"]["errors"]["matched_rows"] >= 0
    several = mot_sim(
        "kitti", "--root", made_tree, "--3d", "--trackers", "default,paper", "--csv", "-"
    )
    rows = list(csv.DictReader(io.StringIO(several.out)))
    assert [row["tracker"] for row in rows] == ["default", "paper"]
    assert "HOTA3D" in rows[0]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (["--thresholds", ".5"], "--thresholds .5: only cuboids have some; add --3d"),
        (["--3d", "--rules", "devkit2018"], "with --3d there are no other rules"),
        (["--3d", "--thresholds", "2"], "3D threshold 2: IoU thresholds are in (0, 1]"),
    ],
)
def test_options_of_3d_that_do_not_go_together(
    mot_sim: CommandLine, made_tree: Path, given: list[str], told: str
) -> None:
    outcome = mot_sim("kitti", "--root", made_tree, *given)
    assert outcome.code == 2
    assert told in outcome.err


def test_tables_and_picture_in_3d_are_kept_for_the_report(
    mot_sim: CommandLine, made_tree: Path, tmp_path: Path
) -> None:
    folder, out = in_3d(tmp_path / "found", rows_in_3d(ahead=1.0)), tmp_path / "out"
    outcome = mot_sim("evaluate", folder, "--root", made_tree, "--3d", "--out", out)
    assert outcome.code == 0
    kept = json.loads((out / "result.json").read_text())
    assert kept["files"] == ["errors_from_above.png", "errors_by_distance.png"]
    assert [table["name"] for table in kept["tables"]] == ["criteria", "spatial_errors", "spatial"]
    assert all((out / name).read_bytes()[:4] == b"\x89PNG" for name in kept["files"])
    page = tmp_path / "page.html"
    assert mot_sim("report", out, "--out", page).code == 0
    assert "Centres: 0.5 m off in the median, 100.00 % within 2 m." in page.read_text()


def test_a_folder_without_3d_is_refused(
    mot_sim: CommandLine, made_tree: Path, tmp_path: Path
) -> None:
    folder = in_3d(tmp_path / "found", rows_in_3d())
    outcome = mot_sim("evaluate", folder, "--root", made_tree, "--out", tmp_path / "out")
    assert outcome.code == 2
    assert "add --3d" in outcome.err
    assert not (tmp_path / "out").exists()
