"""Our fleet against real cars: how well its keypoints describe annotated ones.

    python -m benchmarks.fleet ANNOTATIONS AUTHORS

ANNOTATIONS: a text file, one car a line: its name and 36 x 3 numbers in the authors' axes and
order (x along the car, y up, z right). AUTHORS: the folder with the authors' own basis, which
was made from those cars. Each car is centred; what a basis leaves of it is measured in the
annotations' own unit (cars of unit diagonal). The fleet's population was designed without these
cars: nothing but the scale between metres and the annotations' unit is fitted to them here,
either once for all cars or (a looser reading) for every car.
"""

import argparse
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array
from scipy.optimize import minimize_scalar

from tracker.shape import ShapeBasis, load_prior

GOALS = {5: 1.40, 12: 1.15}  # most that ours may leave, in the error of the authors' basis at 5
METRES = (3.5, 8.0)  # lengths that one unit of the annotations may have


def read_cars(path: Path) -> Float[Array, "n 36 3"]:
    """The annotated cars, centred, in the axes of the object frame."""
    rows = [line.split()[1:] for line in path.read_text().splitlines() if line.strip()]
    return centred(np.array(rows, dtype=float).reshape(-1, 36, 3) * (1.0, -1.0, -1.0))


def centred(points: Float[Array, "*n k 3"]) -> Float[Array, "*n k 3"]:
    """Every set of points around its own mean."""
    return points - points.mean(axis=-2, keepdims=True)


def centred_basis(basis: ShapeBasis) -> ShapeBasis:
    """The basis for centred cars."""
    return ShapeBasis(basis.points, centred(basis.mean), centred(basis.vectors))


def error(basis: ShapeBasis, cars: Float[Array, "n 36 3"]) -> float:
    """The mean distance of the keypoints of cars from their nearest shapes."""
    rest = basis.shape(basis.project(cars)) - cars
    return float(np.linalg.norm(rest, axis=-1).mean())


def best_scale(basis: ShapeBasis, cars: Float[Array, "n 36 3"]) -> tuple[float, float]:
    """The least error over one scale for all cars, and the metres of one unit."""
    found = minimize_scalar(
        lambda metres: error(basis.scaled(1.0 / metres), cars), bounds=METRES, method="bounded"
    )
    return float(found.fun), float(found.x)


def own_scales(basis: ShapeBasis, cars: Float[Array, "n 36 3"]) -> float:
    """The error where every car has the scale that suits it: the mean is one more vector."""
    vectors = np.concatenate((basis.mean[None], basis.vectors))
    return error(ShapeBasis(basis.points, 0.0 * basis.mean, vectors), cars)


def main() -> None:
    """Print the figures and how they stand to the goals."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("annotations", type=Path)
    parser.add_argument("authors", type=Path)
    arguments = parser.parse_args()
    cars = read_cars(arguments.annotations)
    theirs = centred_basis(load_prior(arguments.authors))
    ours = centred_basis(load_prior())
    yardstick = error(theirs.first(5), cars)
    print(f"{len(cars)} cars; the authors' basis at B = 5 leaves {yardstick:.5f}")
    print("B   authors'   ours, one scale   (metres)   ours, a scale a car   goal")
    for size in (0, 1, 2, 3, 5, 8, 12, 16, 20):
        one, metres = best_scale(ours.first(size), cars)
        each = own_scales(ours.first(size), cars)
        own = error(theirs.first(size), cars)
        goal = (
            f"{GOALS[size]:.2f} {'met' if one <= GOALS[size] * yardstick else 'MISSED'}"
            if (size in GOALS)
            else ""
        )
        print(
            f"{size:2}  {own / yardstick:7.3f} x  {one / yardstick:13.3f} x  {metres:9.2f}"
            f"  {each / yardstick:18.3f} x   {goal}"
        )


if __name__ == "__main__":
    main()
