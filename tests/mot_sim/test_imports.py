"""What importing must not bring along."""

import subprocess
import sys

import pytest

HEAVY = ("matplotlib", "pandas", "torch", "OpenGL", "pygame", "highway_env")
SLOW = ("scipy", "cv2", "numba", "filterpy", "gymnasium", "trimesh", "pyarrow")
COMPUTING = (*HEAVY, *SLOW, "numpy", "jaxtyping")

# All modules but the one folder that may import highway_env, kernels, which would compile, and the
# adapter for Stable-Baselines3, which whoever has that imports by itself.
EVERYTHING = """
alone = ("__main__", "pytest_plugin", "stable_baselines")
import importlib, mot_sim, tracker
from pathlib import Path
for package in (mot_sim, tracker):
    home = Path(package.__file__).parent
    for path in sorted(home.rglob("*.py")):
        parts = path.relative_to(home.parent).with_suffix("").parts
        if not {"highway", "kernels"} & {*parts} and path.stem not in alone:
            importlib.import_module(".".join(parts).removesuffix(".__init__"))
"""
HELP = """
import contextlib, io
from mot_sim.__main__ import main
with contextlib.redirect_stdout(io.StringIO()):
    assert main({words}) == 0
"""

STEPS = """
import numpy as np
from tracker import Camera, Detections, Frame, Tracker

K = np.array([[721.5, 0.0, 609.6], [0.0, 721.5, 172.9], [0.0, 0.0, 1.0]])
tracker = Tracker.paper(Camera.mounted(K, image_size=(1242, 375), height=1.65))
for index in range(2):
    seen = Detections.of([[300, 175, 380, 235]], scores=[0.9])
    tracks = tracker.step(Frame(index, 0.1 * index, detections=seen))
assert tracks.ids.tolist() == [0]
"""


def modules_after(code: str) -> set[str]:
    """The top-level modules that are loaded when the code has run in a fresh interpreter."""
    ending = "\nimport sys; print(' '.join({name.split('.')[0] for name in sys.modules}))"
    done = subprocess.run(
        [sys.executable, "-c", code + ending],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    return set(done.stdout.split())


def test_importing_every_module_brings_no_heavy_package() -> None:
    assert modules_after(EVERYTHING).isdisjoint(HEAVY)


@pytest.mark.parametrize("package", ["tracker", "mot_sim"])
def test_importing_a_package_loads_nothing_that_computes(package: str) -> None:
    assert modules_after(f"import {package}").isdisjoint({*COMPUTING, "rich", "tyro"})


def test_a_tracker_waits_for_what_its_first_frame_needs() -> None:
    loaded = modules_after("from tracker import Tracker, Camera, Detections, Frame")
    assert "numpy" in loaded
    assert loaded.isdisjoint({*HEAVY, *SLOW})


@pytest.mark.parametrize("words", [["--help"], ["--version"]])
def test_the_overview_needs_no_parser_of_options(words: list[str]) -> None:
    assert modules_after(HELP.format(words=words)).isdisjoint({"tyro", "argparse"})


@pytest.mark.parametrize("words", [["--help"], ["track", "--help"], ["--version"]])
def test_help_waits_for_nothing_that_computes(words: list[str]) -> None:
    assert modules_after(HELP.format(words=words)).isdisjoint({*COMPUTING, "rich"})


def test_the_first_frames_load_what_they_need() -> None:
    assert {"scipy", "numba"} <= modules_after(STEPS)
