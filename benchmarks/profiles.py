"""The shipped noise profiles, fitted anew, each with what it measures.

    python -m benchmarks.profiles --root KITTI --out mot_sim/simulation/sensors/profiles
        [--detections rrc permatrack pointrcnn] [--seeds 5]

As `mot-sim calibrate` does on the ten given sequences. With rrc comes subcnn, of which no boxes
exist: rrc with its recall and its false positives a frame.
"""

import argparse
import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.special import logit

from benchmarks.calibration import pooled
from benchmarks.kitti_tables import GIVEN
from mot_sim.datasets import kitti_sequence
from mot_sim.files.writing import write_lines
from mot_sim.simulation.sensors.fitting.calibrate import fit_profile
from mot_sim.simulation.sensors.fitting.fit_report import fit_lines
from mot_sim.simulation.sensors.fitting.measure import LabelledDetections, measure
from mot_sim.simulation.sensors.profile import Profile, profile_lines

SUBCNN_RECALL, SUBCNN_FALSE = 0.847, 0.353  # of the counts in Table III of Sharma et al.
SUBCNN_SOURCE = (
    "no boxes exist: the profile rrc with recall .847 and .353 false positives a frame, as the "
    "counts of Sharma et al. (ICRA 2018, Table III) say; all else is rrc's"
)
ROUNDS = 4  # of moving rrc's rates to subcnn's


def as_subcnn(rrc: Profile, drives: Sequence[LabelledDetections], seeds: int) -> Profile:
    """The profile rrc with the recall and the false positives of SubCNN."""
    profile = replace(rrc, name="subcnn", source=SUBCNN_SOURCE)
    for _ in range(ROUNDS):
        made = pooled(profile, drives, seeds)
        misses, second, clutter = profile.misses, profile.duplicates, profile.clutter
        assert misses is not None
        assert second is not None
        assert clutter is not None
        shift = float(logit(SUBCNN_RECALL) - logit(made.recall))
        factor = SUBCNN_FALSE / made.false_per_frame
        profile = replace(
            profile,
            misses=replace(misses, base=misses.base + shift),
            duplicates=replace(
                second,
                seen=tuple(np.minimum(factor * np.array(second.seen), 1.0).tolist()),
                missed=tuple(np.minimum(factor * np.array(second.missed), 1.0).tolist()),
            ),
            clutter=replace(clutter, rate=factor * clutter.rate),
        )
    return profile


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--out", type=Path, required=True, help="folder of the profiles")
    parser.add_argument("--detections", nargs="+", default=["rrc", "permatrack", "pointrcnn"])
    parser.add_argument("--seeds", type=int, default=5, help="simulations that are compared")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    for name in arguments.detections:
        sequences = [kitti_sequence(arguments.root, each, name) for each in GIVEN]
        drives = [LabelledDetections.of(sequence) for sequence in sequences]
        profile = fit_profile(drives, name)
        source = f"mot-sim calibrate: {name} on KITTI's ten given sequences, {profile.source}"
        profiles = [replace(profile, source=source)]
        if name == "rrc":
            profiles.append(as_subcnn(profile, drives, arguments.seeds))
        for each in profiles:
            path = arguments.out / f"{each.name}.toml"
            write_lines(path, profile_lines(each))
            print(f"\n{path}\n{'':50s}{'real':>10s}{'made':>10s}")
            for line in fit_lines(measure(drives), pooled(each, drives, arguments.seeds)):
                print(f"{line.what:50s}{line.real:10.4f}{line.made:10.4f}")


if __name__ == "__main__":
    main()
