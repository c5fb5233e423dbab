"""How good and how fast the keypoint network is: on renders, on real cars, on one core.

    OMP_NUM_THREADS=1 python -m benchmarks.keypoints [--weights FILE] --synthetic --real --speed
        [--crops FOLDER] [--root KITTI --prior FOLDER] [--sheet OUT.png]

--synthetic: PCK@0.1 on held-out crops (other places, other cars), by distance and occlusion; drawn
first, or taken from --crops. --real: needs --root (or MOT_SIM_KITTI_ROOT), yaw after the fit
against labels on the clips with images, from boxes of the labels and of a detector; with --prior
(the folder that holds `keypoints/kp14` and `kp36`) also hand-annotated keypoints, and the published
hourglass's beside ours on the same cars. --sheet: keypoints over real and rendered cars.
"""

import argparse
import os
from itertools import pairwise
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

import cv2
import numpy as np
from numpy import ndarray as Array

from benchmarks.keypoint_real import annotated_pck, published_beside_ours, yaw_on_clips
from benchmarks.keypoint_sheet import real_tiles, rendered_tiles, sheet
from mot_sim.plotting import write_image
from mot_sim.training.augmentation import AugmentedCrops, detected_crops
from mot_sim.training.keypoint_crops import FIRST_HELD_OUT_SEED, Crops, gather_crops
from mot_sim.training.learning import KeypointScores, score_keypoints
from tracker.shape import CROP_MARGIN, Hourglass, decode

SEED = 0
DISTANCES = (0.0, 15.0, 30.0, 45.0, 70.0)
VISIBLE = (0.25, 0.5, 0.8, 0.999, 1.01)


def maps_of(hourglass: Hourglass, shown: AugmentedCrops) -> Array:
    """The heatmaps of crops."""
    images = shown.images
    maps = [hourglass.run(images[i : i + 32])[0] for i in range(0, len(images), 32)]
    return np.concatenate(maps)


def judged(shown: AugmentedCrops, found: Array, share: float = 0.1) -> KeypointScores:
    """Predictions beside the truth; share: of the box's longer side, how near is right."""
    longer = np.full(len(found), 1.0 / CROP_MARGIN)
    return score_keypoints(found, shown.keypoints, shown.states, longer, share)


def rows_of(result: KeypointScores, rows: Array) -> str:
    """PCK and count of some crops."""
    some = KeypointScores(result.right[rows], result.seen[rows], result.confidence[rows])
    return f"{some.pck:.3f} ({rows.sum()} cars)"


def synthetic(hourglass: Hourglass, crops: Crops) -> None:
    """PCK, split; whether confidences are probabilities; other ways to find a map's peak."""
    shown = detected_crops(crops, SEED)
    maps = maps_of(hourglass, shown)
    result = judged(shown, decode(maps))
    print(f"PCK@0.1 of visible keypoints, {len(crops)} held-out crops: {result.pck:.3f}")
    for what, column, edges in (
        ("metres", crops.distance, DISTANCES), ("visible", crops.visible, VISIBLE),
    ):  # fmt: skip
        for low, high in pairwise(edges):
            rows = (column >= low) & (column < high)
            print(f"  {what} {low:g} to {high:g}: {rows_of(result, rows)}")
    whole = (crops.visible > VISIBLE[2]) & (crops.truncation < 0.01)
    print(f"  four fifths visible, not cut: {rows_of(result, whole)}")
    off = f"(off by {result.calibration_error:.3f} on average)"
    print(f"confidence against share seen and right {off}:")
    print("  " + "  ".join(f"{a:.2f}:{b:.2f}" for a, b, n in result.reliability if n))
    for reach in (0, 1, 2, 3):
        near, nearer = (judged(shown, decode(maps, reach), share).pck for share in (0.1, 0.05))
        print(f"mean over {reach} cells around the peak: PCK@0.1 {near:.3f}, PCK@0.05 {nearer:.3f}")


def speed(hourglass: Hourglass) -> None:
    """Milliseconds a crop, everything in it: cutting, network, decoding."""
    cv2.setNumThreads(1)
    image = np.random.default_rng(SEED).integers(0, 255, (375, 1242, 3)).astype(np.uint8)
    print("ms a crop, one thread: CPU (best), wall clock; with boxes in a frame")
    for count in (1, 4, 10, 20):
        left = np.linspace(0.0, 1100.0, count)
        boxes = np.stack((left, np.full(count, 150.0), left + 110.0, np.full(count, 220.0)), axis=1)
        hourglass(image, boxes)
        cpu, wall = [], []
        for _ in range(12):
            begun, at = process_time(), perf_counter()
            hourglass(image, boxes)
            cpu.append(1e3 * (process_time() - begun) / count)
            wall.append(1e3 * (perf_counter() - at) / count)
        print(f"  {count:3d} boxes: {median(cpu):.2f} ({min(cpu):.2f}), {median(wall):.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    for name in ("synthetic", "real", "speed"):
        parser.add_argument(f"--{name}", action="store_true")
    parser.add_argument("--weights", type=Path, help="an ONNX file; the shipped one unless given")
    parser.add_argument("--crops", type=Path, help="a folder where held-out crops are, or go to")
    parser.add_argument("--count", type=int, default=1400, help="of held-out crops")
    parser.add_argument("--root", type=Path, default=os.environ.get("MOT_SIM_KITTI_ROOT"))
    parser.add_argument("--prior", type=Path, help="the folder of annotated keypoints")
    parser.add_argument("--sheet", type=Path, help="a PNG to write")
    given = parser.parse_args()
    hourglass = Hourglass.load(given.weights)
    root = None if given.root is None else Path(given.root)
    with TemporaryDirectory() as own:
        if given.synthetic or given.sheet:
            crops = gather_crops(
                given.crops or Path(own),
                FIRST_HELD_OUT_SEED,
                given.count if given.synthetic else 60,
            )
        if given.synthetic:
            synthetic(hourglass, crops)
        if given.sheet:
            tiles = rendered_tiles(hourglass, detected_crops(crops.select(slice(0, 40)), SEED))
            tiles += real_tiles(hourglass, root) if root else []
            write_image(given.sheet, sheet(tiles))
    if given.real and root is not None:
        yaw_on_clips(hourglass, root)
        if given.prior:
            annotated_pck(hourglass, root, given.prior)
            published_beside_ours(hourglass, root, given.prior)
    if given.speed:
        speed(hourglass)


if __name__ == "__main__":
    main()
