"""The command `mot-sim compare`."""

import json
import sys
from pathlib import Path

import pytest

from mot_sim.cli.compare import parse_seeds
from tests.mot_sim.cli.conftest import CommandLine, files
from tracker.errors import BadConfig


def spelled(programs: Path, name: str, *arguments: str) -> str:
    """A guest as the command line takes it."""
    more = "".join(f" '{each}'" for each in arguments)
    return f"{name}={sys.executable} {programs / name}.py {{detections}} {{results}}{more}"


def test_ours_and_theirs_stand_in_one_table(
    mot_sim: CommandLine, tree: Path, programs: Path
) -> None:
    outcome = mot_sim(
        "compare", "--root", tree, "--trackers", "default,iou,good",
        "--guest", spelled(programs, "good"), "--csv", "-",
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    head, *rows = outcome.out.splitlines()
    assert head == (
        "tracker,score from,MOTA,HOTA,AssA,IDF1,FP,FN,IDSW,Frag,frames / CPU s"
    )  # fmt: skip
    assert [row.split(",")[:3] for row in rows] == [
        ["default", "0.3", "1.0"], ["iou", "0.3", "1.0"], ["good", "0.3", "1.0"],
    ]  # fmt: skip
    assert rows[2].endswith(",8.0")  # 8 labelled frames in two half seconds


def test_a_guest_that_fails_is_named_and_the_others_go_on(
    mot_sim: CommandLine, tree: Path, programs: Path
) -> None:
    outcome = mot_sim(
        "compare", "--root", tree, "--trackers", "crashes,rubbish,iou",
        "--guest", spelled(programs, "crashes"), spelled(programs, "rubbish", "0 0 nan 5 9 9 1"),
    )  # fmt: skip
    assert outcome.code == 1
    assert "iou" in outcome.out
    assert "error: guest crashes: exit status 1 from python" in outcome.err
    assert "\n  crashes: ValueError: no such weights\n" in outcome.err
    assert "0030.txt:9: x1 is not finite: x1 nan" in outcome.err
    assert "\n  rubbish: all well\n" in outcome.err


def test_results_are_kept_for_evaluate(
    mot_sim: CommandLine, tree: Path, programs: Path, tmp_path: Path
) -> None:
    out, scores = tmp_path / "out", tmp_path / "scores.json"
    outcome = mot_sim(
        "compare", "--root", tree, "--trackers", "iou,good", "--json", scores,
        "--guest", spelled(programs, "good"), "--out", out, "--guest-score", "good=0.95",
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    assert files(out) == [
        "good/0030.txt", "good/0031.txt",
        "good/exchange/detections/0030.txt", "good/exchange/detections/0031.txt",
        "good/exchange/detections/sequences.json", "good/exchange/results/0030.txt",
        "good/exchange/results/0031.txt", "good/exchange/results/seconds.json",
        "iou/0030.txt", "iou/0031.txt", "result.json",
    ]  # fmt: skip
    told = json.loads(scores.read_text())
    assert told["iou"]["combined"]["MOTA"] == 1.0
    assert told["good"]["min_score"] == 0.95
    again = mot_sim("compare", "--root", tree, "--trackers", "iou", "--out", out)
    assert again.code == 2
    assert "not empty" in again.err


def test_runs_of_a_scene_are_drives_too(mot_sim: CommandLine, programs: Path) -> None:
    outcome = mot_sim(
        "compare", "--scene", "crossing", "--seeds", "4", "--json", "-",
        "--knobs", "frames=8,houses=0,trees=0,furniture=0",
        "--trackers", "default,good", "--guest", spelled(programs, "good"),
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    told = json.loads(outcome.out)
    assert list(told["default"]["sequences"]) == ["crossing-4"]
    assert told["good"]["frames_per_cpu_second"] == 16.0


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--trackers", "sortt"], "unknown tracker 'sortt'"),
        (["--setup", "sortt"], "unknown guest 'sortt'; known: all"),
        (["--seeds", "1"], "--seeds belongs to --scene"),
        (["--scene", "crossing"], "--scene and --root exclude each other"),
        (["--guest", "iou=run {detections} {results}"], "there is a iou already"),
        (["--guest", "run"], "write NAME=COMMAND"),
        (["--guest-score", "high"], "write 0.3, or sort"),
        (["--guest-score", "srt=0.3"], "Did you mean 'sort'"),
        (["--timeout", "0"], "timeout 0 s"),
        (["--rules", "mine"], "unknown rules 'mine'"),
        (["--sequences", "0032", "--trackers", "iou"], "no labels for any of these sequences"),
    ],
)
def test_wrong_input_is_one_line(
    options: list[str], told: str, mot_sim: CommandLine, tree: Path
) -> None:
    outcome = mot_sim("compare", "--root", tree, *options)
    assert (outcome.code, outcome.out) == (2, "")
    assert told in outcome.err
    assert outcome.err.count("\n") == 1


def test_a_guest_that_was_not_set_up_says_how(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOT_SIM_GUESTS", str(tmp_path / "none"))
    outcome = mot_sim("compare", "--root", tree, "--trackers", "sort,iou")
    assert outcome.code == 1
    assert "`mot-sim compare --setup sort` makes it" in outcome.err


def test_seeds_are_ranges_and_numbers() -> None:
    assert parse_seeds("3") == [3]
    assert parse_seeds("0-2, 7,1") == [0, 1, 2, 7]


@pytest.mark.parametrize("text", ["", "a", "-1", "3-1", "1-", "1.5"])
def test_what_is_no_seed_is_refused(text: str) -> None:
    with pytest.raises(BadConfig, match="--seeds"):
        parse_seeds(text)
