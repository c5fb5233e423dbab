"""What KITTI's annotators label, and how much of it the labels of made scenes share.

    python -m benchmarks.labels --root KITTI --cache DIR [--scenes street,highway] [--seeds 2]

The labelled cars of the given sequences are re-enacted: replayed, drawn, and measured pixel by
pixel. Printed are the rules by which made cars are labelled, as these drives give them, all of
them and two halves: where the annotators' levels of occlusion change, how many pixels of a car
their labels show, how long a hidden car keeps its label. Two checks follow: boxes of a detector
that sees more than the labels (--detections), with the share of them that is labelled, by area;
and the shares and quantiles of the labels of KITTI beside those of the scenes.

What the drives cannot show is what else hides a car: trees, walls, people.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.kitti_tables import GIVEN
from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.experiments.validation.reenactment import VEHICLES, common, draw
from mot_sim.simulation.registry import SCENES, find_scene
from mot_sim.simulation.scene_figures import LabelFigures, figures_of
from mot_sim.simulation.truth.labels import MIN_VISIBLE_PIXELS
from tracker.geometry import box_area, box_iou

LOW_SHARE = 0.05  # of the labels shows fewer pixels than the least visible area
MIN_DETECTION_SCORE = 0.9
AREAS = (200, 300, 400, 500, 600, 800, 1200, 2500)  # of detections' boxes, pixels


@dataclass(frozen=True, eq=False)
class Measured:
    """The labelled cars of a drive with what is seen of them in its re-enactment, row by row."""

    tracks: np.ndarray
    """Which car of which drive."""
    frames: np.ndarray
    levels: np.ndarray
    """KITTI's occlusion."""
    truncated: np.ndarray
    heights: np.ndarray
    """Of the labels' boxes, pixels."""
    visible: np.ndarray
    """Fraction, 0 to 1."""
    pixels: np.ndarray
    """Pixels seen."""

    @classmethod
    def concatenate(cls, parts: "Sequence[Measured]") -> "Measured":
        """The rows of all drives."""
        return cls(*(np.concatenate([getattr(one, each) for one in parts])
                     for each in cls.__dataclass_fields__))  # fmt: skip

    def figures(self) -> LabelFigures:
        """Shares and quantiles of these labels."""
        return LabelFigures.of(self.levels, self.truncated, self.heights, self.pixels)


def measured(drive: KittiSequence, number: int, cache: Path) -> Measured:
    """The labelled cars of a drive; what was drawn is kept in the cache."""
    truth, seen = drive.truth, draw(drive, cache)
    assert truth is not None
    cars = truth.select(np.flatnonzero(truth.kinds == "Car"))
    mine, theirs = common(cars.frames, cars.ids, seen["frames"], seen["ids"])
    cars = cars.select(mine)
    return Measured(
        number * (1 << 20) + cars.ids, cars.frames, cars.occlusion, cars.truncation > 0,
        cars.boxes[:, 3] - cars.boxes[:, 1], seen["visible"][theirs], seen["pixels"][theirs],
    )  # fmt: skip


def level_changes(cars: Measured) -> tuple[float, float, float]:
    """Visible fractions where the annotators' level changes from 0 to 1, 1 to 2, 2 to 3.

    The first two are where the fewest rows are on the wrong side; the last one is where the share
    of level 3 is the annotators', whose rows of it show every fraction.
    """
    found = []
    grid = np.concatenate((np.arange(0.3, 0.96, 0.05), (0.97, 0.99)))
    for level in (0, 1):
        upper, lower = (cars.visible[cars.levels == each] for each in (level, level + 1))
        wrong = [(upper < cut).sum() + (lower >= cut).sum() for cut in grid]
        found.append(float(grid[np.argmin(wrong)]))
    return found[0], found[1], float(np.quantile(cars.visible, np.mean(cars.levels == 3)))


def least_area(cars: Measured) -> float:
    """Pixels below which LOW_SHARE of the scored labels lie."""
    scored = (cars.levels <= 2) & ~cars.truncated
    return float(np.quantile(cars.pixels[scored], LOW_SHARE))


def hidden_times(cars: Measured) -> np.ndarray:
    """Frames of each time that a car shows too few pixels, between two when it shows enough."""
    order = np.lexsort((cars.frames, cars.tracks))
    order = order[cars.pixels[order] >= MIN_VISIBLE_PIXELS]
    apart = np.diff(cars.frames[order])[np.diff(cars.tracks[order]) == 0] - 1
    return apart[apart > 0]


def labelled_share(drives: Sequence[KittiSequence]) -> list[tuple[int, int, float]]:
    """By the area of sure boxes of a detector: the least area, how many, share with a label."""
    areas, labelled = [], []
    for drive in drives:
        truth, log = drive.truth, drive.log
        assert truth is not None
        cars = truth.select(np.flatnonzero(np.isin(truth.kinds, VEHICLES)))
        sure = np.flatnonzero(log.detections.scores >= MIN_DETECTION_SCORE)
        for frame in np.unique(log.frames[sure]):
            found = log.detections.boxes[sure[log.frames[sure] == frame]]
            there = cars.boxes[cars.frames == frame]
            labelled.append((box_iou(found[:, None], there[None]) >= 0.5).any(axis=1))
            areas.append(box_area(found))
    area, known = np.concatenate(areas), np.concatenate(labelled)
    classes = np.digitize(area, AREAS)
    return [
        (least, int((classes == number).sum()), float(known[classes == number].mean()))
        for number, least in enumerate(AREAS, start=1)
        if (classes == number).any()
    ]


def show_rules(parts: Sequence[Measured]) -> None:
    """What the drives say of the rules: all of them, and every second one from either."""
    print(f"{'drives':14}{'level 0/1':>11}{'1/2':>7}{'2/3':>7}{'pixels':>9}{'hidden frames':>15}")
    for name, chosen in (("all", parts), ("even", parts[::2]), ("odd", parts[1::2])):
        cars = Measured.concatenate(chosen)
        first, second, third = level_changes(cars)
        longest = np.quantile(hidden_times(cars), 0.98)
        print(
            f"{name:14}{first:11.2f}{second:7.2f}{third:7.3f}{least_area(cars):9.0f}{longest:15.0f}"
        )


def show_figures(name: str, figures: LabelFigures) -> None:
    """One row of the table of labels."""
    shares = (figures.level_2, figures.level_3, figures.low, figures.low_and_hidden)
    areas = (figures.pixels_1, figures.pixels_5, figures.pixels_10, figures.pixels_50)
    text = "".join(f"{100 * each:9.1f}" for each in shares)
    print(f"{name:14}{text}  {''.join(f'{each:7.0f}' for each in areas)}")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--cache", type=Path, required=True, help="keeps what was drawn")
    parser.add_argument("--detections", default="permatrack", help="that see more than labels")
    parser.add_argument("--scenes", default="", help="names, or `all`; without: none")
    parser.add_argument("--seeds", type=int, default=2)
    arguments = parser.parse_args()
    drives = [kitti_sequence(arguments.root, name, arguments.detections) for name in GIVEN]
    drives = [
        each for each in drives if each.truth is not None and (each.truth.kinds == "Car").any()
    ]
    parts = [measured(drive, number, arguments.cache) for number, drive in enumerate(drives)]
    show_rules(parts)
    print(f"\nboxes of {arguments.detections} from {MIN_DETECTION_SCORE}: area, boxes, labelled")
    for least, count, share in labelled_share(drives):
        print(f"from {least:5d}{count:8d}{100 * share:8.0f} %")
    print("\nlabels: level 2, level 3, under 25 px, both, %; visible pixels at 1, 5, 10, 50 %")
    show_figures("KITTI", Measured.concatenate(parts).figures())
    names = sorted(SCENES) if arguments.scenes == "all" else arguments.scenes.split(",")
    for name in filter(None, names):
        show_figures(name, figures_of(find_scene(name), range(arguments.seeds)).labels)


if __name__ == "__main__":
    main()
