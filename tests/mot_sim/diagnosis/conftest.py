"""A small open crossing, recorded once for all tests of this folder."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from mot_sim.diagnosis.tasks import SceneTask
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.simulation.episodes.extra import Extra

SETTINGS = {"scene.houses": 0.0, "scene.trees": 0.0, "scene.furniture": 0.0}
FORGETFUL = TrackerSpec.parse("default:lifecycle.max_gap=0.5")


@dataclass(frozen=True, eq=False)
class Crossing:
    """Its conditions, the recorded truth of seed 0, and where that lies."""

    conditions: Conditions
    recorded: Extra
    folder: Path

    def task(self, conditions: Conditions | None = None, attribute: bool = False) -> SceneTask:
        """Seed 0 under these conditions, with a tracker that forgets after half a second."""
        return SceneTask(conditions or self.conditions, 0, FORGETFUL, self.folder, attribute)


def crossing_of(folder: Path, frames: int) -> Crossing:
    """So many frames of the crossing under the noise of RRC."""
    conditions = Conditions.of("crossing", {**SETTINGS, "scene.frames": frames})
    return Crossing(conditions, SceneTask(conditions, 0, FORGETFUL, folder).recorded, folder)


@pytest.fixture(scope="package")
def crossing(tmp_path_factory: pytest.TempPathFactory) -> Crossing:
    """40 frames."""
    return crossing_of(tmp_path_factory.mktemp("recordings"), 40)


@pytest.fixture(scope="package")
def short(tmp_path_factory: pytest.TempPathFactory) -> Crossing:
    """20 frames."""
    return crossing_of(tmp_path_factory.mktemp("recordings"), 20)
