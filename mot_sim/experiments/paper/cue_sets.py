"""Which costs stand in which row of the tables, and with which weights."""

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path

from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.files.writing import write_lines
from mot_sim.simulation.sensors import find_profile
from mot_sim.simulation.sensors.profile import profile_lines
from tracker import FRAMEWORKS

# So wide are the search areas that they hold the whole image below the horizon: hardly a gate.
UNGATED = 1000.0
# The rows that need no image. Weights of the authors' script, where there are several.
GEOMETRIC = {
    "2D-2D": "image_overlap",
    "3D-2D": "reprojection",
    "3D-3D": "volume",
    "3D-3D + 3D-2D": "volume=0.6+reprojection=0.4",
}
# Those of the paper's Table III, in the order of its MOTA; appearance weighs 0.2 in the authors'
# script, and shape and pose what `mot_sim.evaluation.runs.CUE_COSTS` gives it.
PAPER_ROWS = {
    "appearance": "appearance",
    "3D-2D": "reprojection",
    "3D-3D": "volume",
    "3D-2D + appearance": "reprojection=0.4+appearance=0.2",
    "all": "volume=0.6+reprojection=0.4+appearance=0.2+shape_pose=0.1",
}
# Of Table V: single cues, and all that a drive without or with pictures has; the weights were
# chosen by `benchmarks.cue_weights`, on folds of KITTI and on made drives from seed 1000.
SINGLE = {"2D-2D": "image_overlap", "3D-2D": "reprojection", "3D-3D": "volume"}
ALL_GEOMETRIC = "image_overlap=0.85+volume=0.03+reprojection=0.12"
ALL_CUES = "image_overlap=0.5+volume=0.15+reprojection=0.03+appearance=0.31+shape_pose=0.01"
CUES = ("pose", "keypoints", "shape", "appearance")


def two_frame(rows: Mapping[str, str]) -> tuple[TrackerSpec, ...]:
    """The paper's tracker with the costs of each row; appearance alone is not gated."""
    return tuple(
        TrackerSpec(
            name,
            "paper",
            {"costs": costs} | ({"sigmas": UNGATED} if costs == "appearance" else {}),
        )
        for name, costs in rows.items()
    )


def in_frameworks(rows: Mapping[str, str], made_by: str = "default") -> tuple[TrackerSpec, ...]:
    """A tracker with the costs of each row, in every framework: COSTS, FRAMEWORK."""
    return tuple(
        TrackerSpec(f"{name}, {framework}", made_by, {"costs": costs, "associate": framework})
        for name, costs in rows.items()
        for framework in FRAMEWORKS
    )


def with_cues(name: str, folder: Path) -> str:
    """A profile file like the named profile, with the cues that this one lacks from `cues`."""
    profile, cues = find_profile(name), find_profile("cues")
    lacking = {
        each.name: getattr(cues, each.name)
        for each in fields(profile)
        if each.name in CUES and getattr(profile, each.name) is None
    }
    path = folder.absolute() / "profiles" / f"{name}_with_cues.toml"
    source = f"{profile.source}; cues as in the profile cues"
    write_lines(path, profile_lines(replace(profile, source=source, **lacking)))
    return str(path)
