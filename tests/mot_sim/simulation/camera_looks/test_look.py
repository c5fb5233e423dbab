"""Looks of the camera: read, written, checked knob by knob."""

from dataclasses import fields, replace
from pathlib import Path

import pytest

from mot_sim.simulation.camera_looks import (
    CAMERA_LOOKS,
    PLAIN,
    find_camera_look,
    look_lines,
    read_camera_look,
)
from mot_sim.simulation.camera_looks.look import (
    LOOK_TABLES,
    CameraLook,
    Exposure,
    File,
    Lens,
    Sensor,
    Tone,
)
from mot_sim.simulation.registry import find_scene
from tracker.errors import BadConfig, BadFile, TrackingError, UnknownName


def written(folder: Path, *lines: str) -> Path:
    path = folder / "mine.toml"
    path.write_text("\n".join(("version = 1", *lines)))
    return path


@pytest.mark.parametrize("name", CAMERA_LOOKS)
def test_a_look_is_read_back_as_it_was_written(name: str, tmp_path: Path) -> None:
    look = find_camera_look(name)
    path = tmp_path / "look.toml"
    path.write_text("\n".join(look_lines(look)))
    assert read_camera_look(path) == look
    assert look.name == name
    assert look.source


def test_plain_is_neutral_and_a_file_may_leave_knobs_out(tmp_path: Path) -> None:
    assert find_camera_look("plain").is_neutral
    assert PLAIN.is_neutral
    assert not find_camera_look("kitti").is_neutral
    look = read_camera_look(written(tmp_path, "[lens]", "blur = 1"))
    assert look == CameraLook("mine", lens=Lens(1.0))


def test_scenes_take_a_look_by_name_and_by_file(tmp_path: Path) -> None:
    path = str(written(tmp_path, "[lens]", "blur = 2.5"))
    assert find_scene("street").camera_look == find_camera_look("kitti")
    assert find_scene("street", camera_look="plain").camera_look.is_neutral
    assert find_scene("street", camera_look=path).camera_look.lens.blur == 2.5
    with pytest.raises(UnknownName, match=r"unknown camera_look 'kity'.*Did you mean 'kitti'"):
        find_scene("street", camera_look="kity")


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (("[lens]", "blurr = 1"), r"unknown parameter of \[lens\] 'blurr'.*Did you mean 'blur'"),
        (("[lense]", "blur = 1"), r"unknown part.*mine.toml: 'lense'.*Did you mean 'lens'"),
        (("[exposure]", "gain = 0"), r"exposure.gain .* is 0: give more than 0"),
        (("[lens]", "blur = -1"), r"lens.blur .* is -1: give 0 to 8"),
        (("[file]", "jpeg = 0"), r"file.jpeg .* is 0: give 1 to 100"),
        (("[file]", "jpeg = 101"), r"file.jpeg .* is 101: give 1 to 100"),
        (("[tone]", "shoulder = 0.5"), r"tone.shoulder .* is 0.5: give 1 to 20, or 0"),
        (("[sensor]", "shot_noise = nan"), r"\[sensor\] shot_noise: nan is not finite"),
        (("[sensor]", 'read_noise = "much"'), r"\[sensor\] read_noise: 'much' is no number"),
        (("lens = 3",), r"\[lens\]: 3 is no table"),
        (("name = 3",), r"name = 3: give a word"),
    ],
)
def test_what_is_wrong_with_a_file_is_told_with_its_name(
    lines: tuple[str, ...], said: str, tmp_path: Path
) -> None:
    path = written(tmp_path, *lines)
    with pytest.raises(TrackingError, match=said) as told:
        read_camera_look(path)
    assert "mine.toml" in str(told.value)


def test_files_of_other_versions_and_that_are_no_toml_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "new.toml"
    path.write_text("version = 2")
    with pytest.raises(BadFile, match="version 2; this mot-sim reads up to 1"):
        read_camera_look(path)
    path.write_text("lens: blur")
    with pytest.raises(BadFile, match="no look of a camera can be read"):
        read_camera_look(path)
    with pytest.raises(TrackingError, match=r"away\.toml"):
        find_camera_look(str(tmp_path / "away.toml"))


@pytest.mark.parametrize("kind", [Lens, Exposure, Tone, Sensor, File])
def test_no_knob_takes_what_is_no_number_or_far_away(kind: type) -> None:
    for each in fields(kind):
        for value in (float("nan"), -1000.0, 1e6):
            with pytest.raises(BadConfig, match=rf"{kind.__name__.lower()}\.{each.name} of the"):
                kind(**{each.name: value})


def test_every_part_counts_for_neutral() -> None:
    changed = {
        "lens": Lens(1.0), "exposure": Exposure(2.0), "tone": Tone(2.0),
        "sensor": Sensor(0.5), "file": File(50.0),
    }  # fmt: skip
    assert set(changed) == set(LOOK_TABLES)
    for name, part in changed.items():
        assert not replace(PLAIN, **{name: part}).is_neutral
