"""`mot-sim record` and `mot-sim verify`."""

import json
import sys
from pathlib import Path

import pytest

from mot_sim.cli import terminal as terminal_module
from mot_sim.cli.options import parse_knobs
from mot_sim.simulation import registry
from mot_sim.simulation.episodes import EpisodeFiles, read_episode
from mot_sim.simulation.episodes import recording as recording_module
from tests.mot_sim.cli.conftest import CommandLine, files
from tests.mot_sim.simulation.episodes.small import FRAMES
from tracker.errors import BadConfig


@pytest.fixture(autouse=True)
def small_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene that is quick to record, by name."""
    monkeypatch.setitem(registry.SCENES, "small", "tests.mot_sim.simulation.episodes.small:small")


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Where the episodes go."""
    return tmp_path / "deep" / "out"


def test_a_tree_is_written_tracked_and_verified(mot_sim: CommandLine, out: Path) -> None:
    outcome = mot_sim("record", "small", "--out", out, "--episodes", 2, "--depth", "--masks")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out == (
        f"{out}: 2 episodes, {2 * FRAMES} frames recorded; images, depth, instances, semantics "
        "by raster\n"
    )
    assert len(files(out)) == 1 + 2 * (7 + 4 * FRAMES)
    tracks = out.parent / "tracks"
    for ego in ("oxts", "noisy"):
        tracked = mot_sim(
            "track", "--root", out, "--detections", "simulated", "--ego", ego, "--out",
            tracks / ego,
        )  # fmt: skip
        assert tracked.code == 0
    assert mot_sim("evaluate", tracks / "oxts", "--root", out).code == 0
    verified = mot_sim("verify", out, "--images")
    assert (verified.code, verified.err) == (0, "")
    assert verified.out.count("same") == 10


def test_without_images_there_are_labels_detections_and_motion(
    mot_sim: CommandLine, out: Path
) -> None:
    outcome = mot_sim("record", "small", "--out", out, "--no-images", "--frames", 3, "--json")
    assert json.loads(outcome.out) == {
        "out": str(out), "episodes": 1, "kept": 0, "frames_recorded": 3, "pictures": [],
        "renderer": "raster",
    }  # fmt: skip
    assert len(files(out)) == 8
    assert read_episode(out).frame_count == 3


def test_knobs_of_the_scene_are_turned_and_kept(mot_sim: CommandLine, out: Path) -> None:
    assert mot_sim("record", "small", "--out", out, "--no-images", "--knobs", "speed=3").code == 0
    assert read_episode(out).metadata.knobs["speed"] == 3.0
    assert mot_sim("verify", out).code == 0
    for wrong, told in (
        (
            "sped=3",
            "unknown knob of scene small: 'sped'; known: camera_look, exposure, fog",
        ),
        ("speed", "--knobs speed: write NAME=VALUE"),
        ("speed=fast", "--knobs speed=fast: give a number"),
    ):
        outcome = mot_sim("record", "small", "--out", out.parent / "b", "--knobs", wrong)
        assert outcome.code == 2
        assert outcome.err.startswith(f"error: {told}")


def test_a_switch_of_a_scene_is_true_or_false() -> None:
    scene = "intersection_left_turn"
    assert parse_knobs(scene, "truck=True,waiting=2") == {"truck": True, "waiting": 2}
    for wrong, told in (("truck=1", "true or false"), ("waiting=2.5", "a whole number")):
        with pytest.raises(BadConfig, match=f"--knobs {wrong}: give {told}"):
            parse_knobs(scene, wrong)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["smal"], "unknown scene 'smal'"),
        (["small", "--renderer", "rastr"], "unknown renderer 'rastr'"),
        (["small", "--frames", "0"], "scene small: 0 frames; give 1 or more"),
        (["small", "--episodes", "0"], "0 episodes: give 1 to 10000"),
        (["small", "--knobs", "pitch=2.0"], "the camera looks along"),
        (["small", "--resume", "--overwrite"], "--resume goes on with a run"),
    ],
)
def test_wrong_input_is_one_line_and_leaves_nothing(
    mot_sim: CommandLine, out: Path, arguments: list[str], told: str
) -> None:
    outcome = mot_sim("record", *arguments, "--out", out)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {told}")
    assert outcome.err.count("\n") == 1
    assert not out.parent.exists()


def test_mesh_without_opengl_is_told_and_auto_falls_back(
    mot_sim: CommandLine, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYOPENGL_PLATFORM", "egl")
    monkeypatch.setitem(sys.modules, "pyrender", None)
    outcome = mot_sim("record", "small", "--out", out, "--renderer", "mesh")
    assert outcome.code == 2
    assert "install 'mot-sim[gl]'" in outcome.err
    assert not out.exists()
    outcome = mot_sim("record", "small", "--out", out, "--renderer", "auto", "--frames", 1)
    assert outcome.code == 0
    assert outcome.err.startswith("warning: drawing with 'raster'")
    assert read_episode(out).metadata.renderer == "raster"


def test_ctrl_c_says_what_stands_and_resume_does_the_rest(
    mot_sim: CommandLine, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    render, left = recording_module.annotate_frame, [FRAMES + 3]

    def interrupted(*arguments: object) -> object:
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        return render(*arguments)

    monkeypatch.setattr(recording_module, "annotate_frame", interrupted)
    command = ["record", "small", "--out", out, "--episodes", 2, "--jobs", 1]
    outcome = mot_sim(*command)
    assert outcome.code == 130
    assert outcome.err == (
        f"interrupted: 2 of 2 episodes stand in {out}, the last with 3 frames; the same command "
        "with --resume does the rest\n"
    )
    left[0] = 1000
    assert mot_sim("verify", out, "--images").code == 0
    assert mot_sim(*command).code == 2
    outcome = mot_sim(*command, "--resume")
    assert outcome.code == 0
    assert "2 episodes, 1 of them stood there before" in outcome.out
    assert read_episode(out, "0001").frame_count == FRAMES


def test_ctrl_c_before_the_first_frame_leaves_nothing(
    mot_sim: CommandLine, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(recording_module, "annotate_frame", interrupted)
    outcome = mot_sim("record", "small", "--out", out)
    assert outcome.code == 130
    assert outcome.err == "interrupted: no frame was finished and nothing is left behind\n"
    assert not out.parent.exists()


def test_verify_names_a_changed_byte_and_ends_with_1(mot_sim: CommandLine, out: Path) -> None:
    mot_sim("record", "small", "--out", out, "--no-images", "--episodes", 2)
    path = EpisodeFiles(out, "0001").text("labels")
    path.write_text(path.read_text().replace("Car", "Van", 1))
    outcome = mot_sim("verify", out)
    assert outcome.code == 1
    assert "differs" in outcome.out
    first, second = json.loads(mot_sim("verify", out, "--json").out)
    assert first["same"]
    assert not second["same"]
    assert second["parts"]["labels"] == "file changed"
    EpisodeFiles(out, "0000").extra.write_bytes(b"")
    outcome = mot_sim("verify", out)
    assert outcome.code == 1
    assert "0000: " in outcome.err
    assert "record again" in outcome.err


def test_verify_of_what_is_no_recording_is_wrong_input(
    mot_sim: CommandLine, tmp_path: Path
) -> None:
    outcome = mot_sim("verify", tmp_path)
    assert outcome.code == 2
    assert outcome.err == f"error: {tmp_path}: no episodes in it; mot-sim record makes some\n"


def test_without_a_terminal_lines_tell_now_and_then_how_far_it_is(
    mot_sim: CommandLine, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(terminal_module, "NOTE_SECONDS", 0.0)
    outcome = mot_sim("record", "street", "--frames", 3, "--out", out, "--no-images")
    lines = [line.split(",")[0] for line in outcome.err.splitlines()]
    assert lines == [f"{what}: {done} of 3" for what in ("traffic", "0000") for done in (1, 2, 3)]
