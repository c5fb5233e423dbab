"""How well boxes of cars tell where KITTI's camera stands, beside the road under the labels.

    python -m benchmarks.calibrate_camera --root KITTI [--detections rrc]

The table of docs/results/cameras.md: height, pitch and roll by `mot-sim calibrate-camera`'s
estimate with its 95 % intervals, drive by drive and by all boxes together, and those of the plane
that is fitted to the centres of the bottom faces of all labelled cars: by their distances from it
in the image (px), and at the end in metres, too. About a minute.
"""

import argparse
from pathlib import Path

import numpy as np
from numpy import ndarray as Array
from scipy.optimize import least_squares

from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.datasets.camera_estimate import estimate_camera
from mot_sim.evaluation.scoring import choose_sequences
from tracker.errors import BadDetections
from tracker.geometry import transform

# Bottom faces that are farther from the plane count less: metres, and px times metres over the
# focal length.
USUAL_DISTANCE, USUAL_ANGLE = 0.1, 0.01
# Nearer ones are beside the camera, m.
MIN_DEPTH = 4.0


def bottoms(drive: KittiSequence) -> Array:
    """Centres of the bottom faces of the labelled cars in the camera's frame, m."""
    truth = drive.truth
    assert truth is not None
    assert truth.cuboids is not None
    base = truth.cuboids.base[np.asarray(truth.kinds) == "Car"]
    return transform(drive.camera.T_cam_road, base[np.isfinite(base).all(axis=1)])


def road_plane(points: Array, metric: bool = False) -> tuple[float, float, float]:
    """The camera's height (m), pitch and roll (rad) over the plane through these points.

    metric: distances count in metres, not as they are seen.
    """
    points = points[points[:, 2] > MIN_DEPTH]
    if len(points) < 3:
        return np.nan, np.nan, np.nan
    scale, usual = (1.0, USUAL_DISTANCE) if metric else (1.0 / points[:, 2], USUAL_ANGLE)

    def distances(x: Array) -> Array:
        normal = np.array([x[0], 1.0, x[1]])
        return scale * (points @ normal - x[2]) / np.linalg.norm(normal)

    start = np.array([0.0, 0.0, 1.65])
    right, ahead, down = least_squares(distances, start, loss="soft_l1", f_scale=usual).x
    length = float(np.linalg.norm([right, 1.0, ahead]))
    # the plane's normal in the camera's frame, as `Camera.mounted` makes it
    pitch, roll = np.arcsin(-ahead / length), np.arctan2(right, 1.0)
    return down / length, float(pitch), float(roll)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--root", type=Path, required=True, help="the KITTI tree")
    parser.add_argument("--detections", default="rrc")
    arguments = parser.parse_args()
    drives = [
        kitti_sequence(arguments.root, name, arguments.detections, "none")
        for name in choose_sequences(arguments.root, "labelled")
    ]
    print(
        "| drive | cars | height, m | by labels | pitch, deg | by labels | roll, deg | by labels |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for name, of in [*((drive.name, [drive]) for drive in drives), ("all", drives)]:
        points = np.concatenate([bottoms(drive) for drive in of])
        height, pitch, roll = road_plane(points)
        try:
            found = estimate_camera(
                [drive.log for drive in of], of[0].camera.K, of[0].camera.image_size
            )
        except BadDetections as error:
            print(f"| {name} | {str(error).split(' ')[0]} | too few | | | | | |")
            continue
        half = found.half_widths[0], *np.degrees(found.half_widths[1:])
        print(
            f"| {name} | {found.car_count} | {found.camera.height:.2f} ±{half[0]:.2f} "
            f"| {height:.2f} | {np.degrees(found.pitch):.2f} ±{half[1]:.2f} "
            f"| {np.degrees(pitch):.2f} | {np.degrees(found.roll):.2f} ±{half[2]:.2f} "
            f"| {np.degrees(roll):.2f} |",
            flush=True,
        )
    height, pitch, roll = road_plane(points, metric=True)
    print(f"\nby labels, in metres: {height:.2f}, {np.degrees(pitch):.2f}, {np.degrees(roll):.2f}")


if __name__ == "__main__":
    main()
