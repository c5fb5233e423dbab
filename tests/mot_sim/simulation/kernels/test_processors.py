"""Compiled kernels give the same bytes on any processor: nothing is summed in another order."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[4]
# Truth, images and rows of a tracker, that is all kernels but those of cues.
DIGEST = """
import hashlib
from dataclasses import fields, is_dataclass

import numpy as np

from mot_sim import Tracker, find_scene, record

found = hashlib.sha256()


def add(table):
    for field in fields(table):
        value = getattr(table, field.name)
        if is_dataclass(value):
            add(value)
        elif value is not None:
            found.update(np.ascontiguousarray(value).tobytes())


episode = record(find_scene("intersection", frames=6), 1, renderer="raster")
add(episode.exact)
add(episode.occlusions)
tracker = Tracker.default(episode.camera)
for frame in episode:
    found.update(frame.image.tobytes())
    add(tracker.step(frame))
print(found.hexdigest())
"""


def digest(**environment: str) -> str:
    """What a new process prints."""
    run = subprocess.run(
        [sys.executable, "-c", DIGEST],
        env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return run.stdout.strip()


@pytest.mark.slow
def test_a_processor_without_extensions_gives_the_same_bytes(tmp_path: Path) -> None:
    """It has neither AVX nor fused products."""
    plain = digest(NUMBA_CPU_NAME="generic", NUMBA_CACHE_DIR=str(tmp_path))
    assert len(plain) == 64
    assert plain == digest()
