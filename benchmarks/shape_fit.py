"""How well and how fast shape and pose come out of keypoints.

    OMP_NUM_THREADS=1 python -m benchmarks.shape_fit [--root KITTI --keypoints FOLDER]

Drawn: cars of the fleet, unoccluded, 5 to 30 m away, any yaw; what a car hides of itself (rays
cast at its mesh), what the border cuts and the missing share get a low confidence and lie
anywhere. Real: hourglass keypoints (14 points) of KITTI against its labels, with the shipped
prior and with that of the folder. Beside the speed stands scipy's least_squares, one car a call.
"""

import argparse
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np
from numpy import ndarray as Array
from scipy.optimize import least_squares

from benchmarks.shape_real import real, yaw_error
from benchmarks.shape_samples import (
    CAMERA,
    DrawnCars,
    detect,
    draw_cars,
    imagined_clutter,
    misplaced_clutter,
    place_cars,
    scattered_clutter,
)
from mot_sim.simulation.cars import load_fleet
from tracker.costs import ShapeAndPose
from tracker.geometry import wrap_angle
from tracker.shape import (
    FittedCars,
    ShapeFit,
    no_car_fits,
)
from tracker.types import Cuboids
from tracker.types.shape_pose import ShapePose

SEED = 7
ONE_BY_ONE = 40  # cars for scipy


def describe(what: str, fitted: FittedCars, cars: DrawnCars) -> None:
    """One line: medians over the fitted cars."""
    has = fitted.seen >= 4
    fitted, yaw, base = fitted.select(has), cars.cuboids.yaw[has], cars.cuboids.base[has]
    error = yaw_error(fitted, yaw)
    off = np.linalg.norm((fitted.base - base)[:, ::2], axis=1) / base[:, 2]
    alike = [np.corrcoef(fitted.shape[:, i], cars.shape[has, i])[0, 1] for i in range(3)]
    size = np.median(np.abs(fitted.size - cars.cuboids.size[has]), axis=0)
    print(
        f"{what:26s} {has.sum():5d}/{len(has)} {fitted.seen.mean():5.1f}  {np.median(error):8.3f} "
        f"{np.percentile(error, 95):7.2f} {100 * (error > 90).mean():6.2f} "
        f"{100 * np.median(off):8.3f}  "
        + " ".join(f"{value:.3f}" for value in alike)
        + "  "
        + " ".join(f"{value:.3f}" for value in size)
        + f"  {100 * fitted.trusted.mean():5.1f}"
    )


def accuracy(cars: DrawnCars) -> None:
    """The drawn cars at several noises."""
    print(
        "drawn cars: fitted, points; yaw deg median, 95 %; flips %; place % of depth; correlation "
        "of lambda 1-3; size off m, l h w; trusted %"
    )
    for sigma, missing in ((2.0, 0.3), (2.0, 0.0), (1.0, 0.3), (4.0, 0.3), (2.0, 0.6)):
        fitted = ShapeFit(sigma=sigma)(detect(cars, sigma, missing, SEED), CAMERA)
        describe(f"{sigma:g} px, {100 * missing:.0f} % missing", fitted, cars)
    describe("and 5 % off by 30 px", ShapeFit()(with_outliers(cars), CAMERA), cars)


def with_outliers(cars: DrawnCars) -> Array:
    """Keypoints with 2 px noise and 30 % missing, of the rest 5 % off by 30 px."""
    keypoints = detect(cars, 2.0, 0.3, SEED)
    rng = np.random.default_rng([SEED, 1])  # apart from what `detect` draws
    wrong = rng.random(keypoints.shape[:2]) < 0.05
    off = rng.normal(0.0, 30.0, keypoints[:, :, :2].shape)
    keypoints[:, :, :2] += np.where(wrong[:, :, None], off, 0.0)
    return keypoints


def exactness(cars: DrawnCars) -> None:
    """The largest errors without noise, sigma stated as next to nothing."""
    print("\nwithout noise             cars   largest error: yaw rad, place m, coefficient")
    for what, visible in (("all points seen", np.ones_like(cars.visible)), ("as seen", None)):
        seen = cars.visible if visible is None else visible
        exact = DrawnCars(cars.shape, cars.cuboids, cars.pixels, seen)
        keypoints = detect(exact, 0.0, 0.0, SEED)
        keypoints[:, :, 2] = np.where(seen, 1.0, 0.0)
        fitted = ShapeFit(sigma=1e-6)(keypoints, CAMERA)
        for fewest in (4, 8):
            has = fitted.seen >= fewest
            some = fitted.select(has)
            yaw = np.radians(yaw_error(some, cars.cuboids.yaw[has]))
            off = np.abs(some.base - cars.cuboids.base[has]).max(axis=1)
            shape = np.abs(some.shape - cars.shape[has]).max(axis=1)
            good = (np.maximum(np.maximum(yaw, off), shape) < 1e-6).mean()
            print(
                f"{what}, {fewest} or more    {has.sum():5d}   {yaw.max():.1e} {off.max():.1e} "
                f"{shape.max():.1e}; within 1e-6: {100 * good:.2f} %"
            )


def calibration(cars: DrawnCars) -> None:
    """Whether the covariance is right: errors over their stated std; 1.00 = right."""
    fitted = ShapeFit()(detect(cars, 2.0, 0.3, SEED), CAMERA)
    has = fitted.seen >= 4
    off = np.column_stack((
        fitted.base[:, 0] - cars.cuboids.base[:, 0],
        fitted.base[:, 2] - cars.cuboids.base[:, 2],
        wrap_angle(fitted.yaw - cars.cuboids.yaw),
        fitted.shape - cars.shape,
    ))[has]  # fmt: skip
    ratio = off / np.sqrt(np.diagonal(fitted.cov[has], axis1=1, axis2=2))
    print("\nerror / stated std (robust), x z yaw lambda 1-5:", end=" ")
    print(" ".join(f"{1.48 * np.median(np.abs(column)):.2f}" for column in ratio.T))


def clutter(cars: DrawnCars) -> None:
    """What share of clutter no car fits, where 1 % of true cars is lost and at fixed limits."""
    fit = ShapeFit()
    true = fit(detect(cars, 2.0, 0.3, SEED), CAMERA)
    kinds = {
        "true cars (lost)": true,
        "true, 5 % of points off": fit(with_outliers(cars), CAMERA),
        "points anywhere in the box": fit(scattered_clutter(cars, SEED), CAMERA),
        "a car, points off by 10 %": fit(imagined_clutter(cars, 0.10, SEED), CAMERA),
        "a car, points off by 5 %": fit(imagined_clutter(cars, 0.05, SEED), CAMERA),
        "a car lifted and stretched": fit(misplaced_clutter(cars, SEED), CAMERA),
    }
    at_one_percent = float(np.percentile(true.residual[true.seen >= 4], 99.0))
    limits = (at_one_percent, fit.max_residual, 2.5)
    print("\nflagged as no car, % of those with 4 points, by the limit of the residual")
    print(f"  {'':28s}" + "".join(f"{limit:7.2f}" for limit in limits))
    for what, found in kinds.items():
        judged = found.select(found.seen >= 4)
        shares = [100 * no_car_fits(judged, limit).mean() for limit in limits]
        print(f"  {what:28s}" + "".join(f"{share:7.2f}" for share in shares))


def normalisation(cars: DrawnCars) -> None:
    """eta of eq. 6: 1 over the mean weighted square between two sightings of one car."""
    fleet, fit, rng = load_fleet(5), ShapeFit(), np.random.default_rng([SEED, 1])
    base, yaw = cars.cuboids.base.copy(), cars.cuboids.yaw
    base[:, ::2] += rng.normal(0.0, 0.5, (len(yaw), 2))
    turned = yaw + rng.normal(0.0, 0.02, len(yaw))
    later = place_cars(fleet, cars.shape, Cuboids(base, turned, cars.cuboids.size), CAMERA)
    looks = []
    for number, some in enumerate((cars, later)):
        found = fit(detect(some, 2.0, 0.3, SEED + number), CAMERA)
        nan = np.where(found.trusted, 0.0, np.nan)
        looks.append(ShapePose(found.shape + nan[:, None], found.yaw, found.pose_cov))
    cost, shift = ShapeAndPose(), np.roll(np.arange(len(yaw)), 1)
    same, other = cost.squares(*looks), cost.squares(looks[0], looks[1].select(shift))
    known = np.isfinite(same[0]) & np.isfinite(other[0])
    print("\neq. 6: mean weighted squares, same car a moment later / another car")
    for what, mine, others in zip(("shape", "pose"), same, other, strict=True):
        typical = float(np.mean(np.minimum(mine[known], np.percentile(mine[known], 99))))
        print(f"  {what:6s} {typical:8.2f} {np.mean(others[known]):10.1f}   eta {1 / typical:.3f}")
    for what, picked in (("shape alone", (0,)), ("shape and pose", (0, 1))):
        eta = (cost.eta_shape, cost.eta_pose)
        mine, others = (sum(eta[i] * part[i][known] for i in picked) for part in (same, other))
        print(f"  {what}: another car is further than the same one in "
              f"{100 * np.mean(np.asarray(others) > np.asarray(mine)):.1f} % of pairs")  # fmt: skip


def speed(cars: DrawnCars) -> None:
    """Cars a second, beside scipy's least_squares on the same cars from the same start."""
    fit, keypoints = ShapeFit(), detect(cars, 2.0, 0.3, SEED)
    fit(keypoints[:64], CAMERA)
    cpu, wall, alone = [], [], []
    for _ in range(7):
        begun, at = process_time(), perf_counter()
        found = fit(keypoints, CAMERA)
        cpu.append(process_time() - begun)
        wall.append(perf_counter() - at)
        begun = process_time()
        for row in range(ONE_BY_ONE):
            one_by_one(fit, keypoints[row], found.select(slice(row, row + 1)))
        alone.append(process_time() - begun)
    n = len(keypoints)
    print(f"\nspeed, cars/s: {n / median(cpu):.0f} by CPU time (best {n / min(cpu):.0f}), "
          f"{n / median(wall):.0f} by the wall clock; least_squares, one yaw, a car a call: "
          f"{ONE_BY_ONE / median(alone):.0f}")  # fmt: skip


def one_by_one(fit: ShapeFit, keypoints: Array, near: FittedCars) -> Array:
    """The same fit by scipy, from one start 0.2 rad and half a metre off, Cauchy loss."""
    basis, prior = fit.model.basis, np.sqrt(fit.precision[5:])
    seen = keypoints[:, 2] >= fit.min_confidence
    weight = np.sqrt(keypoints[seen, 2:]) / fit.sigma
    P = CAMERA.K @ CAMERA.T_cam_road[:3]
    start = np.concatenate((near.base[0] + 0.5, near.yaw + 0.2, np.zeros(basis.size)))
    if not np.isfinite(start).all():
        return start

    def off(unknowns: Array) -> Array:
        c, s = np.cos(unknowns[3]), np.sin(unknowns[3])
        points = basis.shape(unknowns[4:])[seen] @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
        shown = (points + unknowns[:3]) @ P[:, :3].T + P[:, 3]
        pixels = (shown[:, :2] / shown[:, 2:] - keypoints[seen, :2]) * weight
        priors = np.append(unknowns[4:] * prior, unknowns[1] / fit.road_std)
        return np.concatenate((pixels.ravel(), priors))

    found = least_squares(off, start, loss="cauchy", f_scale=fit.kernel)
    return np.asarray(found.x)


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--cars", type=int, default=1000)
    parser.add_argument("--root", type=Path, help="the KITTI tree")
    parser.add_argument("--keypoints", type=Path, help="the folder of hourglass keypoints")
    arguments = parser.parse_args()
    cars = draw_cars(arguments.cars, SEED)
    accuracy(cars)
    exactness(cars)
    calibration(cars)
    clutter(cars)
    normalisation(cars)
    speed(cars)
    if arguments.root and arguments.keypoints:
        real(arguments.root, arguments.keypoints)


if __name__ == "__main__":
    main()
