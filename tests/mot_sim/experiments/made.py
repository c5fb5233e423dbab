"""Small made drives with all cues, for the tests of weights and tables."""

from pathlib import Path

from mot_sim.experiments.tuning.labelled import LabelledSequence, made_drives
from tests.mot_sim.experiments.small import BARE

CUED = {**BARE, "scene.profile": "cues", "scene.frames": 8}


def small_drives(
    folder: Path, seeds: int = 3, **settings: float | str
) -> tuple[LabelledSequence, ...]:
    """Open crossings of eight frames."""
    return made_drives(folder, ("crossing",), range(seeds), {**CUED, **settings})
