"""What importing must not bring along."""

import subprocess
import sys

import pytest

HEAVY = ("matplotlib", "pandas", "torch", "OpenGL", "pygame", "highway_env")
SLOW = ("scipy", "cv2", "shapely", "filterpy", "tracker")

# All modules but the one folder that may import highway_env.
EVERYTHING = """
import importlib, mot_sim, tracker
from pathlib import Path
for package in (mot_sim, tracker):
    home = Path(package.__file__).parent
    for path in sorted(home.rglob("*.py")):
        parts = path.relative_to(home.parent).with_suffix("").parts
        if "highway" not in parts and path.stem not in ("__main__", "pytest_plugin"):
            importlib.import_module(".".join(parts).removesuffix(".__init__"))
"""
HELP = """
import contextlib, io
from mot_sim.__main__ import main
with contextlib.redirect_stdout(io.StringIO()):
    assert main(["track", "--help"]) == 0
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


@pytest.mark.parametrize("code", ["import mot_sim", EVERYTHING], ids=["mot_sim", "everything"])
def test_importing_brings_no_heavy_package(code: str) -> None:
    assert modules_after(code).isdisjoint(HEAVY)


def test_help_waits_for_nothing_that_computes() -> None:
    assert modules_after(HELP).isdisjoint({*HEAVY, *SLOW})
