"""The testbed: it makes worlds, reads KITTI, adds noise, scores, sweeps and reports.

What users need is handed on here, and loaded when it is first asked for: `from mot_sim import
record, find_scene`. Rooms may move, these names stay. Importing the package registers the
Gymnasium ids, so that `gym.make("mot_sim/Crossing-v0")` finds them.
"""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from mot_sim.envs.registration import register_with_gymnasium
from mot_sim.files.own_packages import hidden_package

if TYPE_CHECKING:
    from mot_sim.datasets import box_sequence, kitti_sequence, read_labels, read_results
    from mot_sim.evaluation.runs import track_sequence
    from mot_sim.experiments.stress.suites import Suite
    from mot_sim.experiments.sweep import Design, sweep
    from mot_sim.experiments.sweep.bounds import Bound
    from mot_sim.metrics import Scores, evaluate, evaluate_sequence
    from mot_sim.simulation.episode import Episode, record
    from mot_sim.simulation.registry import SCENES, find_scene
    from mot_sim.simulation.scene import Scene
    from mot_sim.simulation.sensors import Detector
    from mot_sim.simulation.traffic import Roads, Route, Script, Scripted
    from mot_sim.testing import assert_tracks, mot_episode
    from tracker import Camera, Cuboids, Detections, Frame, Sequence, Tracker, Tracks

# The room that each of these names lives in.
_ROOMS = {
    "Bound": "mot_sim.experiments.sweep.bounds",
    "Camera": "tracker",
    "Cuboids": "tracker",
    "Design": "mot_sim.experiments.sweep",
    "Detections": "tracker",
    "Detector": "mot_sim.simulation.sensors",
    "Episode": "mot_sim.simulation.episode",
    "Frame": "tracker",
    "Roads": "mot_sim.simulation.traffic",
    "Route": "mot_sim.simulation.traffic",
    "SCENES": "mot_sim.simulation.registry",
    "Scene": "mot_sim.simulation.scene",
    "Scores": "mot_sim.metrics",
    "Script": "mot_sim.simulation.traffic",
    "Scripted": "mot_sim.simulation.traffic",
    "Sequence": "tracker",
    "Suite": "mot_sim.experiments.stress.suites",
    "Tracker": "tracker",
    "Tracks": "tracker",
    "assert_tracks": "mot_sim.testing",
    "box_sequence": "mot_sim.datasets",
    "evaluate": "mot_sim.metrics",
    "evaluate_sequence": "mot_sim.metrics",
    "find_scene": "mot_sim.simulation.registry",
    "kitti_sequence": "mot_sim.datasets",
    "mot_episode": "mot_sim.testing",
    "read_labels": "mot_sim.datasets",
    "read_results": "mot_sim.datasets",
    "record": "mot_sim.simulation.episode",
    "sweep": "mot_sim.experiments.sweep",
    "track_sequence": "mot_sim.evaluation.runs",
}

if (hidden := hidden_package()) is not None:
    if sys.argv[0] == "-m" or Path(sys.argv[0]).stem == "mot-sim":  # the command: one line
        sys.stderr.write(f"error: {hidden}\n")
        raise SystemExit(2)
    raise ImportError(hidden)
if not TYPE_CHECKING:  # a type checker knows the names above, and no others
    from tracker.lazy_names import lazy_names  # now that the package is known to be ours

    __getattr__, __dir__ = lazy_names(__name__, _ROOMS)
register_with_gymnasium()

__all__ = [
    "SCENES",
    "Bound",
    "Camera",
    "Cuboids",
    "Design",
    "Detections",
    "Detector",
    "Episode",
    "Frame",
    "Roads",
    "Route",
    "Scene",
    "Scores",
    "Script",
    "Scripted",
    "Sequence",
    "Suite",
    "Tracker",
    "Tracks",
    "assert_tracks",
    "box_sequence",
    "evaluate",
    "evaluate_sequence",
    "find_scene",
    "kitti_sequence",
    "mot_episode",
    "read_labels",
    "read_results",
    "record",
    "sweep",
    "track_sequence",
]
