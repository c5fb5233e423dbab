"""Shape and pose of real cars: a network's keypoints on KITTI against its labels.

Called by `benchmarks.shape_fit` and `benchmarks.shape_sheet`.
"""

from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from benchmarks.shape_samples import real_cars
from tracker.geometry import wrap_angle
from tracker.shape import KEYPOINTS_14, CarModel, FittedCars, ShapeFit, load_prior, metric

# Hourglass keypoints: their error as a share of the box's sides, and what counts as seen.
CROP_SHARE, CROP_CONFIDENCE = 0.07, 0.1


def yaw_error(fitted: FittedCars, yaw: Array) -> Array:
    """Degrees, 0 to 180."""
    return np.degrees(np.abs(wrap_angle(fitted.yaw - yaw)))


def real(root: Path, folder: Path) -> None:
    """Hourglass keypoints against labels, a line a file and all of them."""
    priors = {
        "shipped": CarModel(load_prior(points=KEYPOINTS_14).first(5)),
        "the folder's": CarModel(metric(load_prior(folder)), scale_std=0.1),
    }
    for what, model in priors.items():
        fit = ShapeFit(model, min_confidence=CROP_CONFIDENCE)
        print(f"\nreal keypoints, {what} prior: rows, fitted, trusted; yaw error deg median of "
              "fitted, of trusted; flips of trusted; place % of depth")  # fmt: skip
        every = []
        for cars in real_cars(folder, root):
            found = fit(cars.keypoints, cars.sequence.camera, CROP_SHARE * cars.sides)
            truth = cars.labels.cuboids
            assert truth is not None
            off = np.linalg.norm((found.base - truth.base)[:, ::2], axis=1) / truth.base[:, 2]
            rows = np.column_stack((yaw_error(found, truth.yaw), found.trusted, off))
            every.append(rows)
            print(f"  {cars.name:28s} {summary(rows)}  {np.median(truth.base[:, 2]):5.1f} m away")
        print(f"  {'all':28s} {summary(np.concatenate(every))}")


def summary(rows: Array) -> str:
    """Counts and medians of rows of yaw error, trusted, place error."""
    fitted = rows[np.isfinite(rows[:, 0])]
    trusted = fitted[fitted[:, 1] > 0]
    middle = [np.median(some[:, 0]) if len(some) else np.nan for some in (fitted, trusted)]
    place = 100 * np.median(trusted[:, 2]) if len(trusted) else np.nan
    return (
        f"{len(rows):4d} {len(fitted):4d} {len(trusted):4d}  {middle[0]:6.2f} {middle[1]:6.2f}  "
        f"{(trusted[:, 0] > 90).sum():3d}  {place:5.1f}"
    )
