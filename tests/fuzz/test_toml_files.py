"""Every reader of TOML files: noise profiles, designs of sweeps, stress suites, cameras' looks."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mot_sim.experiments.stress.suites import read_suites
from mot_sim.experiments.sweep import Design
from mot_sim.experiments.sweep.design import read_design
from mot_sim.simulation.camera_looks import CAMERA_LOOKS, read_camera_look
from mot_sim.simulation.camera_looks.look import LOOK_FOLDER
from mot_sim.simulation.sensors import Detector
from mot_sim.simulation.sensors.profile import FOLDER, PROFILES, read_profile
from tests.fuzz.door import fuzz
from tests.fuzz.mutations import spoiled_toml

DESIGN = b"""scene = "crossing"
mode = "one_at_a_time"
seeds = 2
frames = 10

[axes]
"detector.jitter" = [0.5]

[fixed]
"detector.weather" = "rain"

[trackers."short memory"]
made_by = "paper"
"""
SUITE = b"""[crowded]
about = "twice the cars"
scene = "intersection"
frames = 80
settings = { "scene.cars" = 50, "detector.misses" = 2.0 }
bounds = { HOTA = 0.6, IDSW = 10 }
"""


def profile(path: Path) -> None:
    assert Detector(read_profile(path)).profile is not None


def design(path: Path) -> None:
    assert isinstance(read_design(str(path)), Design)


def suites(path: Path) -> None:
    for suite in read_suites(path).values():
        assert suite.bounds


def camera_look(path: Path) -> None:
    assert read_camera_look(path).name


READERS: dict[str, tuple[list[bytes], Callable[[Path], Any]]] = {
    "profile": ([(FOLDER / f"{name}.toml").read_bytes() for name in PROFILES], profile),
    "design": ([DESIGN], design),
    "camera_look": (
        [(LOOK_FOLDER / f"{name}.toml").read_bytes() for name in CAMERA_LOOKS],
        camera_look,
    ),
    "suites": ([SUITE], suites),
}


@pytest.mark.parametrize("name", READERS)
def test_a_bad_toml_file_is_read_or_refused(name: str, folder: Path) -> None:
    good, read = READERS[name]
    fuzz(folder / f"{name}.toml", good, spoiled_toml, read)
