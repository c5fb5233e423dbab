"""Which convex-polygon overlap serves eq. 4: ours against OpenCV, in speed and in truth.

    python -m benchmarks.overlap

Cars on one road stand nearly parallel, so rectangles that share edges are the rule, not the
exception. There OpenCV is sometimes wrong by whole cars.
"""

import argparse
from time import perf_counter

import cv2
import numpy as np
from numpy import ndarray as Array

from tracker.geometry import convex_intersection

SIGNS = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) / 2


def with_opencv(a: Array, b: Array) -> Array:
    """The areas by cv2.intersectConvexConvex, a pair a call, in single precision about a."""
    middle = a.mean(axis=1, keepdims=True)
    pairs = zip((a - middle).astype(np.float32), (b - middle).astype(np.float32), strict=True)
    return np.array([cv2.intersectConvexConvex(p, q)[0] for p, q in pairs])


def parallel_rectangles(count: int, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Pairs of rectangles of one yaw, every second pair on a half-metre grid; and their overlap."""
    sides = rng.uniform(1, 8, (2, count, 2))
    offset = rng.uniform(-4, 4, (count, 2))
    grid = rng.random(count) < 0.5
    sides[:, grid], offset[grid] = np.round(sides[:, grid]), np.round(offset[grid])
    low = np.maximum(-sides[0] / 2, offset - sides[1] / 2)
    high = np.minimum(sides[0] / 2, offset + sides[1] / 2)
    yaw = rng.uniform(-np.pi, np.pi, count)
    turn = np.stack((np.cos(yaw), np.sin(yaw), -np.sin(yaw), np.cos(yaw)), -1).reshape(-1, 2, 2)
    place = rng.uniform(-60, 60, (count, 1, 2))
    a, b = SIGNS * sides[0][:, None], SIGNS * sides[1][:, None] + offset[:, None]
    return a @ turn + place, b @ turn + place, np.maximum(high - low, 0).prod(axis=1)


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()
    rng = np.random.default_rng(0)
    print("pairs      ours us   OpenCV us   ratio")
    for count in (1, 10, 100, 1000):
        a, b, _ = parallel_rectangles(count, rng)
        best = []
        for area in (convex_intersection, with_opencv):
            times = []
            for _ in range(20):
                start = perf_counter()
                area(a, b)
                times.append(perf_counter() - start)
            best.append(1e6 * min(times))
        print(f"{count:5d} {best[0]:12.1f} {best[1]:11.1f} {best[0] / best[1]:7.1f}")
    a, b, truth = parallel_rectangles(20_000, rng)
    for name, area in (("ours", convex_intersection), ("OpenCV", with_opencv)):
        error = np.abs(area(a, b) - truth)
        print(f"{name}: largest error {error.max():.2g} m^2, {np.sum(error > 1e-3)} of 20000 wrong")


if __name__ == "__main__":
    main()
