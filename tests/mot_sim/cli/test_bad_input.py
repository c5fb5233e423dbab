"""Everything that can be wrong with the input: one line, exit 2, nothing half-written."""

from pathlib import Path

import pytest

from tests.mot_sim.cli.conftest import (
    CALIBRATION,
    CAMERA,
    FRAMES,
    OXTS_ROW,
    CommandLine,
    Outcome,
    boxes_csv,
    detections,
    labels,
    write,
)

RRC = "detections/rrc/0031.txt"
CALIB = "training/calib/0031.txt"
OXTS = "training/oxts/0031.txt"
GOOD = "0,500,200,560,240,0.9\n"


def require_one_line(outcome: Outcome, *words: str) -> None:
    """Exit code 2, nothing on stdout, one line on stderr that holds the words."""
    assert outcome.code == 2
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1
    assert outcome.err.startswith("error: ")
    for word in words:
        assert word in outcome.err


# What is wrong: the file, its new text (None: it is not there), and what the line must say.
BROKEN_FILES = {
    "no calibration": (CALIB, None, ["0031", "0030"]),
    "no oxts": (OXTS, None, ["oxts/0031.txt", "orbslam3"]),
    "no detections": (RRC, None, [RRC]),
    "a truncated row": (RRC, GOOD + "1,500,200\n", [f"{RRC}:2", "3 values"]),
    "a row that is no number": (RRC, GOOD + "1,500,abc,560,240,0.9\n", [f"{RRC}:2", "'abc'"]),
    "a NaN box": (RRC, GOOD + "1,nan,200,560,240,0.9\n", [f"{RRC}:2", "not finite"]),
    "an inverted box": (RRC, GOOD + "1,560,200,500,240,0.9\n", [f"{RRC}:2", "inverted"]),
    "a box without area": (RRC, GOOD + "1,500,200,500,240,0.9\n", [f"{RRC}:2", "without area"]),
    "a box outside the image": (RRC, GOOD + "1,5000,200,5100,240,0.9\n", [f"{RRC}:2", "outside"]),
    "a frame beyond the sequence": (RRC, f"{GOOD}{FRAMES}{GOOD[1:]}", [f"{RRC}:2", "beyond"]),
    "a truncated oxts row": (
        OXTS,
        OXTS_ROW * (FRAMES - 1) + OXTS_ROW[:15] + "\n",
        [f"{OXTS}:{FRAMES}", "6 values"],
    ),
    "a singular K": (CALIB, CALIBRATION.replace("700", "0"), [CALIB, "singular"]),
    "a calibration without P2": (CALIB, "R_rect 1 0 0 0 1 0 0 0 1\n", [CALIB, "P2"]),
    "a calibration cut off": (CALIB, CALIBRATION[:30], [f"{CALIB}:1", "12"]),
}


@pytest.mark.parametrize(
    ("command", "what"), [*(("track", what) for what in BROKEN_FILES), ("kitti", "a NaN box")]
)
def test_a_broken_file_of_the_tree_is_one_line_and_leaves_nothing(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, command: str, what: str
) -> None:
    name, text, words = BROKEN_FILES[what]
    if text is None:
        (tree / name).unlink()
    else:
        write(tree / name, text)
    out = tmp_path / "made" / "out"
    chosen = ["--sequences", "0030,0031"] if what == "no calibration" else []
    require_one_line(mot_sim(command, "--root", tree, "--out", out, *chosen), *words)
    assert not (tmp_path / "made").exists()


BAD_NAMES = {
    "tracker": (["--tracker", "defualt"], ["'defualt'", "Did you mean 'default'?"]),
    "cost": (["--costs", "volum=1"], ["unknown cost 'volum'", "Did you mean 'volume'?"]),
    "association": (["--association", "hungarien"], ["Did you mean 'hungarian'?"]),
    "detector": (["--detections", "rcc"], ["unknown detector 'rcc'", "Did you mean 'rrc'?"]),
    "format": (["--detections", "x", "--detection-format", "rcc"], ["Did you mean 'rrc'?"]),
    "ego-motion": (["--ego", "oxt"], ["unknown ego-motion 'oxt'", "Did you mean 'oxts'?"]),
    "sequence": (["--sequences", "030"], ["unknown sequence '030'", "Did you mean '0030'?"]),
    "split": (["--split", "trainig"], ["unknown split", "Did you mean 'training'?"]),
}


@pytest.mark.parametrize("what", BAD_NAMES)
def test_an_unknown_name_gets_the_nearest_known_one(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, what: str
) -> None:
    arguments, words = BAD_NAMES[what]
    out = tmp_path / "out"
    require_one_line(mot_sim("track", "--root", tree, "--out", out, *arguments), *words)
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["kitti", "--trackers", "default,papr"], ["Did you mean 'paper'?"]),
        (["kitti", "--rules", "trackevl"], ["unknown rules", "Did you mean 'trackeval'?"]),
        (["kitti", "--resume"], ["--out"]),
        (["evaluate", "results", "--rules", "devkit"], ["Did you mean 'devkit2018'?"]),
        (["export", "results", "out", "--to", "motchalenge"], ["Did you mean 'motchallenge'?"]),
    ],
)
def test_the_other_commands_know_their_names_too(
    mot_sim: CommandLine, tree: Path, arguments: list[str], words: list[str]
) -> None:
    require_one_line(mot_sim(*arguments, "--root", tree), *words)


@pytest.mark.parametrize("costs", ["volume=x", "volume=-1", "volume=1,volume=2", "", "volume=nan"])
def test_weights_that_cannot_be_are_refused(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, costs: str
) -> None:
    out = tmp_path / "out"
    require_one_line(mot_sim("track", "--root", tree, "--out", out, "--costs", costs))


@pytest.mark.parametrize("command", [["track", "--out", "x"], ["kitti"], ["evaluate", "."]])
def test_without_a_root_the_cure_is_named(mot_sim: CommandLine, command: list[str]) -> None:
    words = ["results"] if command[0] == "evaluate" else ["MOT_SIM_KITTI_ROOT", "--root"]
    require_one_line(mot_sim(*command), *words)


def test_a_root_that_is_not_there_is_named(mot_sim: CommandLine, tmp_path: Path) -> None:
    outcome = mot_sim("track", "--root", tmp_path / "nowhere", "--out", tmp_path / "out")
    require_one_line(outcome, "nowhere", "no such folder")


def test_an_existing_output_folder_stays_as_it_is(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    kept = write(tmp_path / "out" / "precious.txt", "mine")
    for more in ([], ["--resume"], ["--overwrite"]):
        outcome = mot_sim("track", "--root", tree, "--out", tmp_path / "out", *more)
        require_one_line(outcome, "not empty", "another folder")
    assert kept.read_text() == "mine"


def test_an_output_folder_that_cannot_be_made_is_one_line(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    blocked = write(tmp_path / "file", "a file where a folder would go")
    for out in (blocked, blocked / "out"):
        require_one_line(mot_sim("track", "--root", tree, "--out", out), str(out))
    assert blocked.read_text() == "a file where a folder would go"


def test_a_read_only_output_folder_is_one_line(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path, *_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "write_text", refuse)
    outcome = mot_sim("track", "--root", tree, "--out", tmp_path / "out")
    require_one_line(outcome, "out", "Permission denied")
    assert not (tmp_path / "out").exists()


def test_a_table_that_cannot_be_written_is_one_line(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    blocked = write(tmp_path / "file", "")
    require_one_line(
        mot_sim("kitti", "--root", tree, "--csv", blocked / "scores.csv"), "scores.csv"
    )


BAD_RESULTS = {
    "an id twice in a frame": (labels() + labels().split("\n")[-2] + "\n", "twice"),
    "a frame beyond the sequence": (labels().replace(f"\n{FRAMES - 1} ", f"\n{FRAMES} "), "beyond"),
    "a truncated row": (labels()[:-20] + "\n", "values"),
    "an inverted box": (labels().replace("560.0", "460.0", 1), "inverted"),
}


@pytest.mark.parametrize("what", BAD_RESULTS)
def test_bad_results_are_named_with_their_line(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, what: str
) -> None:
    text, word = BAD_RESULTS[what]
    write(tmp_path / "results" / "0030.txt", text)
    outcome = mot_sim("evaluate", tmp_path / "results", "--root", tree)
    require_one_line(outcome, "0030.txt:", word)


def test_labels_with_an_id_twice_in_a_frame_are_refused(
    mot_sim: CommandLine, tree: Path, tmp_path: Path
) -> None:
    write(tmp_path / "results" / "0030.txt", labels())
    write(tree / "training/label_02/0030.txt", labels() + labels().split("\n")[-2] + "\n")
    outcome = mot_sim("evaluate", tmp_path / "results", "--root", tree)
    require_one_line(outcome, f"label_02/0030.txt:{2 * FRAMES + 1}", "twice")


def test_no_results_at_all_is_an_error(mot_sim: CommandLine, tree: Path, tmp_path: Path) -> None:
    require_one_line(mot_sim("evaluate", tmp_path / "nothing", "--root", tree), "no such folder")
    (tmp_path / "empty").mkdir()
    require_one_line(mot_sim("evaluate", tmp_path / "empty", "--root", tree), "no results")
    write(tmp_path / "other" / "0099.txt", labels())
    require_one_line(mot_sim("evaluate", tmp_path / "other", "--root", tree), "0099")
    write(tmp_path / "some" / "0030.txt", labels())
    asked = ["--sequences", "0030,0031"]
    require_one_line(mot_sim("evaluate", tmp_path / "some", "--root", tree, *asked), "0031")
    write(tmp_path / "unlabelled" / "0032.txt", labels())
    require_one_line(mot_sim("evaluate", tmp_path / "unlabelled", "--root", tree), "no labels")


BAD_BOXES = {
    "no header": (detections(), CAMERA, ["boxes.csv:1", "header"]),
    "a word in a box": (boxes_csv().replace("0.9", "high", 1), CAMERA, ["boxes.csv:2", "'high'"]),
    "an inverted box": (boxes_csv().replace("560.0", "460.0", 1), CAMERA, ["boxes.csv:2"]),
    "no camera height": (boxes_csv(), CAMERA.replace("camera_h", "h"), ["camera.toml", "'height'"]),
    "a singular K": (
        boxes_csv(),
        CAMERA.replace("fx = 700", "fx = 0"),
        ["camera.toml", "singular"],
    ),
}


@pytest.mark.parametrize("what", BAD_BOXES)
def test_bad_boxes_of_ones_own_are_one_line(
    mot_sim: CommandLine, tmp_path: Path, what: str
) -> None:
    csv, toml, words = BAD_BOXES[what]
    boxes, camera = write(tmp_path / "boxes.csv", csv), write(tmp_path / "camera.toml", toml)
    out = tmp_path / "out"
    outcome = mot_sim("track", "--boxes", boxes, "--camera", camera, "--out", out)
    require_one_line(outcome, *words)
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--boxes", "boxes.csv"], "--camera"),
        (["--camera", "camera.toml"], "--boxes"),
        (["--images", "images"], "--boxes"),
        (["--boxes", "b.csv", "--camera", "c.toml", "--detection-format", "rrc"], "--detection-f"),
        (["--resume", "--overwrite"], "keep one"),
        (["--boxes", "nowhere.csv", "--camera", "c.toml"], "nowhere.csv"),
    ],
)
def test_options_that_contradict_each_other_are_refused(
    mot_sim: CommandLine, tree: Path, tmp_path: Path, arguments: list[str], word: str
) -> None:
    root = [] if "--boxes" in arguments else ["--root", tree]
    require_one_line(mot_sim("track", *root, "--out", tmp_path / "out", *arguments), word)


@pytest.mark.parametrize("arguments", [[], ["trak"], ["track"], ["track", "--pitch", "steep"]])
def test_what_is_no_command_line_ends_with_exit_code_2(
    mot_sim: CommandLine, arguments: list[str]
) -> None:
    outcome = mot_sim(*arguments)
    assert outcome.code == 2
    assert "Traceback" not in outcome.err
