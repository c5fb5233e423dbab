"""How often the nearest descriptor is the same car: learned, classical, random; and what noise
a simulated descriptor needs to be as bad.

    python -m benchmarks.appearance [--root KITTI] [--sheet OUT.png] [--noise] [--memory]
        [--unit]

Rank-1, in percent: every car of a frame looks for itself among all cars of a frame 1, 5 and 10
frames later (at least 25 pixels high, KITTI's occlusion 0 to 2). Ordinary and look-alike scenes
are synthetic, of seeds that no weight was learned from; real: the frames of 0000, 0005 and 0009
that have images and given labels, with the labels' boxes. `maps` is the network's activations as
they are, centred, normalised and correlated, as the published code does with its features.
"""

import argparse
import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from pathlib import Path  # noqa: E402

import numpy as np  # noqa: E402
from numpy import ndarray as Array  # noqa: E402

from benchmarks.appearance_noise import fit_noise  # noqa: E402
from benchmarks.appearance_samples import (  # noqa: E402
    GAPS,
    LOOK_ALIKES,
    ORDINARY,
    Look,
    Seen,
    matches,
    real,
    seen_by,
    synthetic,
)
from benchmarks.appearance_sheet import confusion_sheet  # noqa: E402
from mot_sim.plotting import write_image  # noqa: E402
from mot_sim.training.appearance import (  # noqa: E402
    CarPicture,
    car_pictures,
    training_drives,
    unit_of_descriptor,
)
from tracker.descriptors import Classical, Learned, pool_maps  # noqa: E402
from tracker.shape import Hourglass  # noqa: E402

SHARES = (0.0, 0.3, 0.5, 0.7)  # that a running mean keeps of what was before


class Maps:
    """The network's activations of the latest picture, computed once for all that ask."""

    def __init__(self) -> None:
        self.hourglass = Hourglass.load(mirrored=False)
        self.latest: tuple[CarPicture, Array] | None = None

    def __call__(self, picture: CarPicture) -> Array:
        """The activations of a picture's boxes."""
        if self.latest is None or self.latest[0] is not picture:
            bgr = np.ascontiguousarray(picture.image[:, :, ::-1])
            self.latest = picture, self.hourglass(bgr, picture.boxes).activations
        return self.latest[1]


def contenders() -> dict[str, Look]:
    """Everything that describes a car, by name."""
    maps, learned, classical = Maps(), Learned.load(), Classical()
    rng = np.random.default_rng(0)

    def correlated(picture: CarPicture) -> Array:
        features = pool_maps(maps(picture), picture.boxes, learned.grid)
        features = features - learned.mean[: features.shape[1]]
        return features / np.linalg.norm(features, axis=1, keepdims=True)

    return {
        "learned": lambda picture: learned(picture.image, picture.boxes, maps(picture)),
        "maps": correlated,
        "classical": lambda picture: classical(picture.image, picture.boxes),
        "random": lambda picture: rng.normal(size=(len(picture.ids), 16)),
    }


def table(sets: dict[str, list[Seen]], names: list[str]) -> None:
    """Rank-1 of every contender on every set, a line each."""
    print(f"{'rank-1, %':22s}" + "".join(f"{gap:3d} apart       " for gap in GAPS))
    for what, seen in sets.items():
        for name in names:
            cells = []
            for gap in GAPS:
                found = matches(seen, name, gap)
                cells.append(f"{100 * found.rank1:5.1f} of {found.queries:4d}  ")
            print(f"{what:12s}{name:10s}" + "  ".join(cells))
        chances = (f"{100 * matches(seen, names[0], gap).chance:5.1f}" for gap in GAPS)
        print(f"{what:12s}{'(chance)':10s}" + "          ".join(chances))


def memory_table(sets: dict[str, list[Seen]], name: str) -> None:
    """Whether to ask with the latest descriptor or with a running mean."""
    print(f"\nrunning mean of {name} descriptors: share kept of what was before, rank-1 in %")
    for what, seen in sets.items():
        for share in SHARES:
            cells = (f"{100 * matches(seen, name, gap, share).rank1:5.1f}" for gap in GAPS)
            print(f"{what:12s}{share:4.1f}   " + "  ".join(cells))


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--root", type=Path, help="KITTI, for the real clips")
    parser.add_argument("--sheet", type=Path, help="the pairs most often confused, as a picture")
    parser.add_argument("--noise", action="store_true", help="fit a profile's descriptor noise")
    parser.add_argument("--memory", action="store_true", help="the latest, or a running mean")
    parser.add_argument("--unit", action="store_true", help="of the classical descriptor")
    given = parser.parse_args()
    if given.unit:
        pictures = (picture for drive in training_drives() for picture in car_pictures(drive))
        unit = unit_of_descriptor(pictures, Classical(unit=1.0))
        print(f"unit of the classical descriptor: {unit:.4f}")
        return
    looks = contenders()
    sets = {
        "ordinary": seen_by(synthetic(ORDINARY), looks),
        "look-alike": seen_by(synthetic(LOOK_ALIKES), looks),
    }
    if given.root is not None:
        sets["real"] = seen_by(real(given.root), looks)
    table(sets, list(looks))
    if given.memory:
        memory_table(sets, "learned")
    if given.sheet is not None:
        write_image(given.sheet, confusion_sheet(sets, "learned"))
        print(f"\n{given.sheet}: the pairs that the learned descriptor confuses most often")
    if given.noise and given.root is not None:
        fit_noise(given.root, sets["real"], "learned")


if __name__ == "__main__":
    main()
