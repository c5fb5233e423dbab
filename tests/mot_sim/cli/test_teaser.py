"""`mot-sim teaser`."""

from pathlib import Path

import matplotlib.image
import pytest

from mot_sim.simulation import registry
from tests.mot_sim.cli.conftest import CommandLine


@pytest.fixture(autouse=True)
def near_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene that is quick to draw, by name."""
    monkeypatch.setitem(registry.SCENES, "near", "tests.mot_sim.report.small:near")


def test_a_scene_gives_a_figure(mot_sim: CommandLine, tmp_path: Path) -> None:
    path = tmp_path / "teaser.png"
    command = ["teaser", "--scene", "near", "--frame", "2", "--out", path, "--cues", "none"]
    outcome = mot_sim(*command)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith(f"{path}: frames 2 and 3 of near; ")
    assert outcome.out.endswith(" of 4 pairs lie in a search area\n")
    assert matplotlib.image.imread(path).shape[1] == 2000
    again = mot_sim(*command)
    assert again.code == 2
    assert "--overwrite" in again.err


@pytest.mark.kitti
def test_two_real_frames_give_a_figure(
    mot_sim: CommandLine, tmp_path: Path, kitti_root: Path
) -> None:
    outcome = mot_sim(
        "teaser", "--root", kitti_root, "--sequence", "0005", "--frame", "8", "--out",
        tmp_path / "teaser.svg",
    )  # fmt: skip
    assert outcome.code == 0
    assert (tmp_path / "teaser.svg").read_text().count("<image") >= 2


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--scene", "near"], "give --frame N, the first of the two frames"),
        (["--scene", "near", "--frame", "5"], "frame 5 and the next one: 'near' has the frames 0"),
        (["--scene", "neer", "--frame", "1"], "unknown scene 'neer'"),
        (["--scene", "near", "--root", "TREE", "--frame", "1"], "--scene is run now, --root and"),
        (["--root", "TREE", "--frame", "1", "--knobs", "a=1"], "--knobs belong to a scene"),
        (["--root", "TREE", "--sequence", "0030", "--frame", "1"], "'0030' has no image of frame"),
        (["--scene", "near", "--frame", "1", "--cues", "pse"], "unknown cue 'pse'"),
        (["--frame", "1"], "no KITTI root is given"),
    ],
)
def test_wrong_input_is_one_line_and_leaves_nothing(
    mot_sim: CommandLine, tmp_path: Path, tree: Path, arguments: list[str], told: str
) -> None:
    path = tmp_path / "out" / "teaser.png"
    named = [each.replace("TREE", str(tree)) for each in arguments]
    outcome = mot_sim("teaser", *named, "--out", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {told}")
    assert outcome.err.count("\n") == 1
    assert not path.parent.exists()


def test_another_ending_is_refused(mot_sim: CommandLine, tmp_path: Path) -> None:
    outcome = mot_sim("teaser", "--scene", "near", "--frame", 1, "--out", tmp_path / "a.bmp")
    assert outcome.code == 2
    assert "give a file that ends in .png, .svg, .pdf, .jpg" in outcome.err
