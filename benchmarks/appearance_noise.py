"""The noise that makes simulated descriptors as bad as measured ones, on the same real clips.

Called by `benchmarks.appearance`.
"""

from itertools import product
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from benchmarks.appearance_samples import CLIPS, GAPS, Seen, matches
from mot_sim.datasets import kitti_sequence
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation
from mot_sim.simulation.sensors.cues import AppearanceNoise
from mot_sim.simulation.sensors.sightings import Sightings
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from mot_sim.training.appearance import DescriptorDataset, pair_distances, unit_of

SIZES = (4, 8, 16)  # numbers of a descriptor: the fewer, the more cars look alike by chance
NOISES = (0.4, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0)
SECONDS = (1.0, 4.0)  # that the noise remembers
VIEW = 0.3
SEEDS = 1


def fit_noise(root: Path, seen: list[Seen], name: str) -> None:
    """Print the effect whose rank-1, and pairs taken wrongly, come nearest to the measured."""
    wanted, _ = figures(seen, name)
    labels = {clip: _labelled(root, clip) for clip in CLIPS}
    found = {
        (size, noise, seconds): simulated(
            seen, labels, AppearanceNoise(size, noise, VIEW, 1, Autocorrelation((1.0,), (seconds,)))
        )
        for size, noise, seconds in product(SIZES, NOISES, SECONDS)
    }
    best = min(found, key=lambda each: float(((found[each][0] - wanted) ** 2).sum()))
    size, noise, seconds = best
    print(f"\nrank-1 on the real clips {GAPS} frames apart, and pairs taken wrongly, in %")
    print(f"measured, {name:12s}                    {_percent(wanted)}")
    print(
        f"made, size {size}, noise {noise:g} over {seconds:g} s        {_percent(found[best][0])}"
    )
    for other in NOISES:
        row = found[size, other, seconds][0]
        print(f"  noise {other:3.1f}                             {_percent(row)}")
    print(f"the unit of the best one's distances: {found[best][1]:.3f}")


def figures(seen: list[Seen], name: str) -> tuple[Array, float]:
    """Rank-1 for each of GAPS, the share of pairs that the unit takes wrongly, and the unit."""
    dataset = _dataset(seen, name)
    unit = unit_of(dataset)
    wrong = float((pair_distances(dataset)[0] > unit).mean())
    return np.array([*(matches(seen, name, gap).rank1 for gap in GAPS), wrong]), unit


def simulated(
    seen: list[Seen], labels: dict[str, Sightings], effect: AppearanceNoise
) -> tuple[Array, float]:
    """The figures of an effect on the same cars of the same frames, the mean of some seeds."""
    rows, units = [], []
    for seed in range(SEEDS):
        vectors = {clip: effect(some, seed, STEP_SECONDS) for clip, some in labels.items()}
        made = [
            Seen(
                one.drive, one.frame, one.ids, {"made": vectors[one.drive][_rows(one, labels)]}, []
            )
            for one in seen
        ]
        row, unit = figures(made, "made")
        rows.append(row)
        units.append(unit)
    return np.mean(rows, axis=0), float(np.mean(units))


def _rows(one: Seen, labels: dict[str, Sightings]) -> list[int]:
    """Where the cars of a picture stand among the labels of its clip."""
    some = labels[one.drive]
    here = np.flatnonzero(some.frames == one.frame)
    return [int(here[np.flatnonzero(some.ids[here] == each)[0]]) for each in one.ids]


def _dataset(seen: list[Seen], name: str) -> DescriptorDataset:
    """All cars of all pictures, those without a descriptor left out."""
    drives = sorted({one.drive for one in seen})
    parts = []
    for one in seen:
        known = np.isfinite(one.vectors[name]).all(axis=1)
        number = drives.index(one.drive)
        count = int(known.sum())
        where = np.full(count, number), np.full(count, one.frame)
        parts.append((one.vectors[name][known], one.ids[known] + (number << 32), *where))
    return DescriptorDataset(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _labelled(root: Path, clip: str) -> Sightings:
    truth = kitti_sequence(root, clip, None, "none").truth
    assert truth is not None
    return Sightings.from_labels(truth)


def _percent(shares: Array) -> str:
    return "  ".join(f"{100 * share:5.1f}" for share in shares)
