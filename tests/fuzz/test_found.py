"""What the fuzzing found, one row each: files that once caused another exception, or none."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mot_sim.datasets import ImageFolder, ScoreMap, box_sequence, read_calibration, read_camera
from mot_sim.datasets.camera_files import read_poses
from mot_sim.datasets.kitti.ego import read_oxts
from mot_sim.evaluation.run_folder import RunFolder
from mot_sim.experiments.guests.exchange import read_seconds
from mot_sim.experiments.result_file import read_result
from mot_sim.experiments.stress.suites import read_suites
from mot_sim.experiments.sweep.design import read_design
from mot_sim.files.documents import parse_json, read_json, read_toml
from mot_sim.simulation.cars import load_car
from mot_sim.simulation.episodes import EpisodeFolder, read_depth
from mot_sim.simulation.sensors.profile import read_profile
from tests.fuzz.test_pictures_and_meshes import PIXELS, encoded
from tests.fuzz.test_text_files import BOXES, CALIBRATION, CAMERA_FILE, OXTS, POSES
from tests.fuzz.test_toml_files import DESIGN, SUITE
from tracker.errors import TrackingError
from tracker.shape import load_prior


def a_run(path: Path) -> None:
    RunFolder.open(path.parent, {}, ["0000"], resume=True)


def some_episodes(path: Path) -> None:
    EpisodeFolder.open(path.parent, {}, 1, 6, overwrite=True)


def a_design(path: Path) -> None:
    read_design(str(path))


def an_image(path: Path) -> None:
    ImageFolder.require(path.parent).load(0)


def a_run_of(sequences: object, settings: object = None) -> bytes:
    return json.dumps({"settings": settings or {}, "sequences": sequences}).encode()


COUNTS = {"frames": 1, "detections": 1, "rows": 1, "ids": 1, "seconds": 0.0}
PNG = encoded(".png", PIXELS)
FOUND: dict[str, tuple[str, bytes, Callable[[Path], Any]]] = {
    "a calibration of giants, whose determinant overflows": (
        "calib.txt", CALIBRATION.replace(b"172.9 0.2", b"1e308 0.2"), read_calibration,
    ),
    "a latitude beyond the pole": ("oxts.txt", OXTS.replace(b"49.00", b"-1e300"), read_oxts),
    "a latitude of 90.5 degrees": ("oxts.txt", OXTS.replace(b"49.00", b"90.5"), read_oxts),
    "a pose of giants": ("poses.txt", POSES.replace(b"0.8 0 0.6", b"1e308 0 0.6"), read_poses),
    "a camera of tables inside tables": (
        "camera.toml", b"fx = " + b"{a = " * 2000 + b"1", read_camera,
    ),
    "a whole number of 400 digits in a camera": (
        "camera.toml", CAMERA_FILE.replace(b"10.0", b"9" * 400), read_camera,
    ),
    "a whole number of 400 digits in a profile": (
        "p.toml", b"version = 1\n[border]\nsnap = " + b"9" * 400, read_profile,
    ),
    "an infinite count in a profile": (
        "p.toml", b"version = 1\n[appearance]\nsize = inf\n", read_profile,
    ),
    "a name of a profile that is a number": ("p.toml", b"version = 1\nname = 3\n", read_profile),
    "a tracker of no module in a design": (
        "d.toml", DESIGN.replace(b'made_by = "paper"', b'made_by = ":"'), a_design,
    ),
    "a relative module in a design": (
        "d.toml", DESIGN.replace(b'made_by = "paper"', b'made_by = ".x:y"'), a_design,
    ),
    "a setting that is a list in a design": (
        "d.toml", DESIGN.replace(b'made_by = "paper"', b"max_gap = []"), a_design,
    ),
    "a fixed axis that is a table": (
        "d.toml", DESIGN.replace(b'= "rain"', b"= {a = 1}"), a_design,
    ),
    "a bound that is a word": ("s.toml", SUITE.replace(b"0.6", b"'x'"), read_suites),
    "a setting of a suite that is a list": ("s.toml", SUITE.replace(b"= 50", b"= []"), read_suites),
    "a run of objects inside objects": ("run.json", b'{"a":' * 20000, a_run),
    "a run with an infinite count": (
        "run.json", a_run_of({"0000": COUNTS | {"frames": float("inf")}}), a_run,
    ),
    "a run with a count that is a word": (
        "run.json", a_run_of({"0000": COUNTS | {"rows": "x"}}), a_run,
    ),
    "a run with a setting that is an object": ("run.json", a_run_of({}, {"a": {}}), a_run),
    "a run with a name of 400 letters": ("run.json", a_run_of({"1" * 400: COUNTS}), a_run),
    "a run with a name that holds a zero byte": ("run.json", a_run_of({"a\x00b": COUNTS}), a_run),
    "a list of episodes of lists inside lists": ("episodes.json", b"[" * 20000, some_episodes),
    "seconds of 400 digits": (
        "seconds.json", b'{"0000": ' + b"1" * 400 + b"}", read_json,
    ),
    "a result with half of its trials": (
        "result.json",
        b'{"format": 1, "kind": "run", "title": "", "made": {"command": "", "versions": {}, '
        b'"code": "", "finished": true, "trials": []}, "tables": [], "files": []}',
        lambda path: read_result(path.parent),
    ),
    "a mesh whose corners have two numbers": (
        "car.obj", b"v 0 0 \x0c\nv 1 0 0\nv 0 2 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\n", load_car,
    ),
    "a mesh of no length": (
        "car.obj",
        b"v 0 0 0\nv 1 0 0\nv 0 2 1e-320\nf 1 3 2\n",
        lambda path: load_car(path, length=4.0),
    ),
    "an image that tells of a piece of 134 MB": (
        "000000.png", PNG[:33] + b"\x08" + PNG[34:], an_image,
    ),
    "an image that tells of more pixels than it can hold": (
        "000000.png", PNG[:16] + b"\x00\x00\x40\x00" * 2 + PNG[24:], an_image,
    ),
    "a depth map in colours": ("000000.png", PNG, read_depth),
    "an image of frame 10^30": (f"{10**30}.png", PNG, an_image),
    "a shape prior that is a bare array": ("prior.npz", b"", load_prior),
}  # fmt: skip


@pytest.mark.parametrize("what", FOUND)
def test_what_was_found_is_refused(what: str, folder: Path) -> None:
    name, content, read = FOUND[what]
    path = folder / name
    if name == "prior.npz":
        with path.open("wb") as file:
            np.save(file, np.zeros(3))
    else:
        path.write_bytes(content)
    with pytest.raises(TrackingError) as told:
        read(path)
    assert str(told.value)


def test_a_frame_that_no_drive_has_is_refused_before_room_is_made_for_it(folder: Path) -> None:
    (folder / "camera.toml").write_bytes(CAMERA_FILE)
    path = folder / "boxes.csv"
    path.write_bytes(BOXES.replace(b"\n2,", b"\n9007199254740992,"))
    with pytest.raises(TrackingError, match=r"boxes.csv:3: frame beyond any drive"):
        box_sequence(path, folder / "camera.toml")


def test_scores_far_from_a_narrow_score_map_become_0_and_1_without_a_warning() -> None:
    probabilities = ScoreMap(0.2, 1e-320)(np.array([-1e308, 1e308]))
    assert probabilities.tolist() == [0.0, 1.0]


def test_seconds_that_are_no_numbers_are_refused(folder: Path) -> None:
    (folder / "seconds.json").write_text('{"0000": 1e999}')
    assert read_seconds([], folder) == {}
    assert parse_json("[1, 2.5]", "x") == [1, 2.5]
    (folder / "c.toml").write_text("a = [1, {b = 2}]")
    assert read_toml(folder / "c.toml") == {"a": [1, {"b": 2}]}
